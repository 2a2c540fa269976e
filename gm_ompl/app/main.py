"""``gm-ompl``: the command, its verbs in the order of ``--help``, and the way out.

Only the standard library and typer are imported to get here: what a verb needs is imported inside
it, so that ``--help`` answers at once.
"""

from __future__ import annotations

import gc
import os
import sys
from contextlib import suppress
from typing import Annotated, Any, Final, NoReturn

import typer
from typer.core import TyperGroup

import gm_ompl
from gm_ompl.app.commands import TRACEBACK_VARIABLE, Exit, Switches, command
from gm_ompl.app.interrupts import listen
from gm_ompl.app.leaving import leave
from gm_ompl.app.output import hush_libraries, note, outlets, show_log
from gm_ompl.app.verbs import GROUPS, VERBS


class _Grouped(TyperGroup):
    """The command, whose ``--help`` lists its verbs by what they are for."""

    def format_commands(self, _ctx: Any, formatter: Any) -> None:
        """Write a section per group of verbs, all with the same first column."""
        width = max(map(len, self.commands))
        for heading, verbs in GROUPS.items():
            rows = [
                (v.ljust(width), self.commands[v].get_short_help_str(sys.maxsize)) for v in verbs
            ]
            with formatter.section(heading):
                formatter.write_dl(rows)


app = typer.Typer(
    name="gm-ompl",
    cls=_Grouped,
    no_args_is_help=True,
    add_completion=True,
    rich_markup_mode=None,  # one plain message for a usage error, and a quicker start
    pretty_exceptions_enable=False,  # exceptions are dealt with in commands.py
    help="Plans graspless manipulation by multifingered robot hands, and checks plans.",
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"gm-ompl {gm_ompl.__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
    traceback: Annotated[
        bool,
        typer.Option(
            "--traceback", envvar=TRACEBACK_VARIABLE, help="Show where an error came from."
        ),
    ] = False,
) -> None:
    """Options that stand before the verb."""
    del version  # dealt with by its callback
    Switches.show_traceback = traceback
    show_log()


for _name, _verb in VERBS.items():
    app.command(_name)(command(*_verb))


COLLECT_AFTER: Final = 500_000
"""Objects made before garbage is looked for; at Python's 700 a tenth of a start goes into that."""


def run() -> NoReturn:
    """Entry point of the command ``gm-ompl``."""
    leave(program())


def program() -> int:
    """Run the command; return the process's exit code."""
    gc.set_threshold(COLLECT_AFTER)
    # Else pydantic looks for plugins of its own in every package that is installed.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    listen()
    hush_libraries()
    with outlets() as stdout:
        code = _code()
    if stdout is not None and stdout.failure is not None and code != Exit.BUG:
        code = Exit.BAD_INPUT
        with suppress(OSError):
            note(f"gm-ompl: cannot write the standard output: {stdout.failure.strerror}")
    return int(code)


def _code() -> int:
    """Run the command and return its exit code."""
    try:
        app(prog_name="gm-ompl")
    except KeyboardInterrupt:
        return Exit.INTERRUPTED
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else Exit.OK
    return Exit.OK
