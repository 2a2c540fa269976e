"""Limits on time and memory, on every shipped scenario made ten and a hundred times denser."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import cache

import gm_ompl
from gm_ompl.limits import MEGABYTE
from gm_ompl.scenario.load import shipped
from tests.verify.counting import Result, count

SECONDS, MEGABYTES = 3.0, 700.0
OVER_S, OVER = 1.0, 1.1
"""What may be taken beyond a limit: seconds, and times."""

CALLS = (
    ("plan", "--planner", "astar"),
    ("plan", "--planner", "dijkstra"),
    ("plan", "--planner", "HybridRRTConnect"),
    ("explain",),
)
PATIENCE = 60.0
"""A call that takes longer is killed [s]."""

NAMES = shipped()
CASES = [(name, key, times) for name in NAMES for key in ("lattice", "grid") for times in (10, 100)]


def denser(name: str, key: str, times: int) -> str:
    """Return what makes a scenario's lattice or grid so many times denser, as ``--set`` has it.

    A lattice is made denser in every coordinate. Of a grid's cells there are so many times more.
    """
    model = gm_ompl.load(name).model
    if key == "grid":
        rows, columns = model.fingers.placements.grid
        each = round(times**0.5)
        return f"fingers.placements.grid=[{rows * each}, {columns * (times // each)}]"
    steps, segments = model.lattice.steps, model.lattice.segments
    if steps is not None:
        angles = {"yaw": " rad", "rotation": " rad"}
        finer = ", ".join(
            f"{key}: {step / times!r}{angles.get(key, '')}" for key, step in steps.given.items()
        )
        return f"lattice.steps={{{finer}}}"
    given = segments if isinstance(segments, tuple) else (segments or 1,)
    finer = ", ".join(str(n * times) for n in given)
    return f"lattice.segments=[{finer}]" if len(given) > 1 else f"lattice.segments={finer}"


@dataclass(frozen=True)
class Call:
    """How a call of the command ended: exit code, wall and processor time [s], memory [MB]."""

    code: int
    wall: float
    cpu: float
    peak: float
    said: str


def called(*arguments: str) -> Call:
    """Call the command in a process of its own; one that takes far too long is killed."""
    with tempfile.TemporaryFile() as errors:
        began = time.monotonic()
        command = [sys.executable, "-m", "gm_ompl", *arguments]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors) as process:
            usage, status = None, 0
            while usage is None:
                pid, status, spent = os.wait4(process.pid, os.WNOHANG)
                usage = spent if pid else None
                if usage is None and time.monotonic() - began > PATIENCE:
                    process.kill()
                time.sleep(0.02)
            process.returncode = os.waitstatus_to_exitcode(status)
        wall = time.monotonic() - began
        errors.seek(0)
        said = errors.read().decode(errors="replace").strip()[-300:]
    peak = usage.ru_maxrss / (1024.0 if sys.platform != "darwin" else MEGABYTE)
    cpu = usage.ru_utime + usage.ru_stime
    return Call(process.returncode, wall, cpu, peak, said)


@cache
def beginning() -> float:
    """Return what a call takes beside its search: it begins, and loads its machine code [s]."""
    command = [sys.executable, "-m", "gm_ompl", "plan", "paper/tumble", "--json"]
    taken = []
    for _ in range(3):
        began = time.monotonic()
        told = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
        taken.append(time.monotonic() - began - told["statistics"]["time_s"])
    return float(min(taken))


@count(instances=len(CASES) * len(CALLS))
def limits(instance: int) -> Result:
    """On denser scenarios `plan` and `explain` keep to 3 s and 700 MB.

    At most 1 s and 10 % more time, what a call takes to begin and to load machine code left aside,
    and at most 10 % more memory (worst: seconds).
    """
    (name, key, times), call = CASES[instance // len(CALLS)], CALLS[instance % len(CALLS)]
    verb, *more = call
    change, began = denser(name, key, times), beginning()
    ended = called(
        verb, name, *more, "--set", change, "--json",
        "--time-limit", f"{SECONDS:g}", "--memory-limit", f"{MEGABYTES:g}",
    )  # fmt: skip
    taken = ended.wall - began
    holds = taken <= OVER * SECONDS + OVER_S and ended.peak <= OVER * MEGABYTES
    note = (
        f"{' '.join(call)} {name} --set {change!r}: exit {ended.code}, {taken:.2f} s "
        f"({ended.cpu:.2f} s cpu in all), {ended.peak:.0f} MB; {ended.said}"
    )
    return Result(holds and ended.code in (0, 2, 3, 4), taken, note, outcome=f"exit {ended.code}")
