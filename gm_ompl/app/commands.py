"""How a verb's options, fields of a dataclass, become a command; how a command ends.

Exit codes, and the one place where exceptions become messages.
"""

from __future__ import annotations

import enum
import errno
import functools
import importlib
import inspect
import json
import math
import sys
import traceback
from collections.abc import Callable
from dataclasses import MISSING, field, fields
from typing import Annotated, Any, get_type_hints

import typer

from gm_ompl.app.interrupts import Interrupts
from gm_ompl.errors import InputError, LimitError


class Exit(enum.IntEnum):
    """What the process's exit code says."""

    OK = 0  # solved, or holds
    BUG = 1
    BAD_INPUT = 2
    INFEASIBLE = 3  # proven on the scenario's lattice
    BUDGET = 4  # spent without a plan
    REFUTED = 5  # check found that the plan does not hold
    INTERRUPTED = 130  # what shells report for Ctrl-C


EXIT_OF_STATUS = {
    "solved": Exit.OK,
    "infeasible": Exit.INFEASIBLE,
    "budget": Exit.BUDGET,
    "interrupted": Exit.INTERRUPTED,
}

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What the system says where no more can be written."""

TRACEBACK_VARIABLE = "GM_OMPL_TRACEBACK"


class Switches:
    """Set by the options that stand before the verb."""

    show_traceback = False


def guarded(command: Callable[..., Exit]) -> Callable[..., None]:
    """Turn a command that returns its exit code into one that ends the process with it.

    With ``--json`` an error, too, is one JSON object on stdout.
    """

    @functools.wraps(command)
    def wrapper(*args: Any, **kwargs: Any) -> None:
        try:
            code = command(*args, **kwargs)
            sys.stdout.flush()
        except KeyboardInterrupt:
            code = _fail(Exit.INTERRUPTED, "interrupted", kwargs)
        except LimitError as error:
            code = _fail(Exit.BUDGET, str(error), kwargs)
        except InputError as error:
            code = _fail(Exit.BAD_INPUT, str(error), kwargs)
        except OSError as error:
            full = error.errno in _FULL
            message = f"cannot write {error.filename or 'a file'}: {error.strerror}"
            code = _fail(
                Exit.BAD_INPUT if full else Exit.BUG,
                message if full else _describe_bug(error),
                kwargs,
            )
        except Exception as error:
            if Interrupts.dropped:
                code = _fail(Exit.INTERRUPTED, "interrupted", kwargs)
            else:
                code = _fail(Exit.BUG, _describe_bug(error), kwargs)
        raise SystemExit(int(code))

    return wrapper


def _fail(code: Exit, message: str, kwargs: dict[str, Any]) -> Exit:
    if Switches.show_traceback:
        traceback.print_exc()
    sys.stderr.write(f"gm-ompl: {message}\n")
    if kwargs.get("as_json"):
        sys.stdout.write(json.dumps({"error": message, "exit_code": int(code)}) + "\n")
    return code


def _describe_bug(error: Exception) -> str:
    text = " ".join(str(error).split())
    hint = f"gm-ompl --traceback ..., or {TRACEBACK_VARIABLE}=1, shows where"
    return f"internal error: {type(error).__name__}: {text} ({hint})"


def option(default: Any, text: str, metavar: str | None = None, *names: str, **more: Any) -> Any:
    """Return a field that is an option: with its default, ``...`` for none, and its help.

    Its value is called ``metavar``; ``names`` are others than the field's.
    """
    return _field(default, typer.Option(*names, metavar=metavar, help=text, **more))


def argument(text: str, metavar: str, default: Any = ..., **more: Any) -> Any:
    """Return a field that is an argument, with its help, what it is called and its default."""
    return _field(default, typer.Argument(metavar=metavar, help=text, **more))


def _field(default: Any, info: Any) -> Any:
    return field(default=MISSING if default is ... else default, metadata={"typer": info})


def require(holds: bool, option: str, value: object, wanted: str) -> None:
    """Refuse an option's value.

    Raises:
        InputError: it does not hold; the message names option, value and what would be right.
    """
    if not holds:
        raise InputError(f"{option} {value}: must be {wanted}")


def require_positive(**limits: float | None) -> None:
    """Refuse limits that are given and are not positive numbers; named as the options are."""
    for name, value in limits.items():
        holds = value is None or (math.isfinite(value) and value > 0)
        require(holds, f"--{name.replace('_', '-')}", value, "a positive number")


def command(options: type[Any], handler: str) -> Callable[..., None]:
    """Return a verb for typer: its parameters and its help are those of ``options``.

    Args:
        options: a dataclass of ``option`` and ``argument``.
        handler: "MODULE:FUNCTION" in this folder, which takes the options and returns the exit
            code. It is imported when the verb runs, so that ``--help`` answers at once.
    """
    module, _, name = handler.partition(":")

    def run(**given: Any) -> Exit:
        found: Callable[[Any], Exit] = getattr(importlib.import_module(module, __package__), name)
        return found(options(**given))

    types = get_type_hints(options)
    hints = {f.name: Annotated[types[f.name], f.metadata["typer"]] for f in fields(options)}
    empty, kind = inspect.Parameter.empty, inspect.Parameter.KEYWORD_ONLY
    parameters = []
    for one in fields(options):
        default = empty if one.default is MISSING else one.default
        parameters.append(
            inspect.Parameter(one.name, kind, annotation=hints[one.name], default=default)
        )
    made = guarded(run)
    made.__doc__, made.__annotations__ = options.__doc__, hints
    made.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return made
