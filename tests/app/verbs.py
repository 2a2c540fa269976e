"""Every verb that reads a file, run on one in this process: what may come of it, and what not."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from typer.testing import CliRunner

from gm_ompl.app.main import app
from tests.app.mutations import SMALL, Mutant

ENDS = (0, 2, 3, 4, 5)
"""Exit codes that say what the file is worth; 1 is a bug."""

PATIENCE = 60
"""A verb that takes longer hangs [s]."""

PLANNERS = ("astar", "HybridRRTConnect", "dijkstra", "RRTConnect", "HybridRRT", "BITstar", "astar")
BUDGET = ("--max-iterations", "20", "--time-limit", "2", "--memory-limit", "3000")


class TooLongError(BaseException):
    """Raised where a verb hangs; no ``except Exception`` holds it up."""


def trouble(mutant: Mutant, folder: Path, number: int) -> list[str]:
    """Return what goes wrong in the verbs that read ``mutant``, a line each."""
    suffix = ".json" if mutant.kind == "plan" else ".yaml"
    file = folder / f"{mutant.kind}-{number}{suffix}"
    file.write_bytes(mutant.content)
    found = []
    for arguments in commands(mutant, file, folder, number):
        wrong = _wrong(arguments)
        if wrong:
            found.append(f"gm-ompl {' '.join(arguments)}: {wrong}")
    return found


def commands(mutant: Mutant, file: Path, folder: Path, number: int) -> Iterator[list[str]]:
    """Yield the command lines that read a mutated file."""
    name = str(file)
    if mutant.kind == "parameters":
        scenario = [part for change in SMALL["paper/slide"] for part in ("--set", change)]
        planner = ["--planner", mutant.origin, "--params", name]
        yield ["plan", "paper/slide", *scenario, *planner, *BUDGET]
    elif mutant.kind == "scenario":
        planner = ["--planner", PLANNERS[number % len(PLANNERS)]]
        yield ["plan", name, *planner, *BUDGET, "-o", str(folder / "plan.json")]
    else:
        yield ["check", name]
        picture = ("pdf", "svg", "png")[number % 3]
        show = ("forces", "snapshots", "search")[number // 3 % 3]
        yield ["plot", name, "--show", show, "-o", str(folder / f"picture.{picture}")]
        yield ["view", name, "--html", str(folder / "view.html")]
        yield ["export", name, "-o", str(folder / "plan.csv")]
        if number % 10 == 3:  # it takes longest
            yield ["execute", name, "--speed", "5"]


def _wrong(arguments: list[str]) -> str:
    try:
        with warnings.catch_warnings(), _patience():
            warnings.simplefilter("error")
            result = CliRunner().invoke(app, ["--traceback", *arguments])
    except TooLongError:
        return f"takes longer than {PATIENCE} s"
    if result.exit_code not in ENDS:
        return f"ends with {result.exit_code}: {result.stderr[-1500:]} {result.exception!r}"
    if "Warning" in result.stderr:
        return f"warns: {result.stderr[-500:]}"
    if result.exit_code == 2 and not result.stderr.strip():
        return "ends with 2 and says nothing"
    return ""


@contextmanager
def _patience() -> Iterator[None]:
    """End what takes too long, by the process's own time: others may use the machine, too."""

    def give_up(_signal: int, _frame: FrameType | None) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGPROF, give_up)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
