"""Times of two builds side by side: runs alternate, so that both see the same machine."""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from tests.side_by_side.builds import Build

WORKER: Final = Path(__file__).with_name("worker.py")
PAPER: Final = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")
SLOWER: Final = 1.05
"""Ratio of times up to which nothing counts as slower."""

RESAMPLES: Final = 2000

Ask = Callable[..., dict[str, Any]]
"""Sends a request to a work process and returns its answer."""


@dataclass(frozen=True)
class Row:
    """Times of one piece of work.

    Attributes:
        name: what was timed.
        old: per repetition [s].
        new: per repetition [s].
    """

    name: str
    old: Sequence[float]
    new: Sequence[float]

    @property
    def ratio(self) -> float:
        """The new median over the old one."""
        return float(np.median(self.new) / np.median(self.old))

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % bootstrap interval of the ratio; repetitions are drawn as pairs."""
        pairs = np.array([self.old, self.new])
        rng = np.random.default_rng(0)
        drawn = pairs[:, rng.integers(pairs.shape[1], size=(RESAMPLES, pairs.shape[1]))]
        old, new = np.median(drawn, axis=2)
        low, high = np.quantile(new / old, (0.025, 0.975))
        return float(low), float(high)

    @property
    def slower(self) -> bool:
        """Whether the new build is slower, by more than 5 % and than the interval explains."""
        return self.ratio > SLOWER and self.interval[0] > 1.0


def table(rows: Sequence[Row]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| work | runs | old s | new s | new / old | 95 % | |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        (low, high), word = row.interval, "slower" if row.slower else ""
        lines.append(
            f"| {row.name} | {len(row.old)} | {np.median(row.old):.4g} | {np.median(row.new):.4g} "
            f"| {row.ratio:.3f} | {low:.3f} to {high:.3f} | {word} |"
        )
    return "\n".join(lines) + "\n"


@contextmanager
def asking(build: Build) -> Iterator[Ask]:
    """Start a work process inside a build; it ends with the block."""
    with subprocess.Popen(
        [build.python, "-P", WORKER], env=build.variables(), text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None
        to, back = process.stdin, process.stdout

        def ask(**request: Any) -> dict[str, Any]:
            to.write(json.dumps(request) + "\n")
            to.flush()
            answer = back.readline()
            if not answer:
                raise RuntimeError(f"the work process of {build.name} ended at {request}")
            found: dict[str, Any] = json.loads(answer)
            return found

        try:
            yield ask
        finally:
            to.close()


def alternate(
    name: str, runs: int, old: Callable[[int], float], new: Callable[[int], float]
) -> Row:
    """Time both, ``runs`` times each; who goes first alternates, too. Repetitions are numbered."""
    times: tuple[list[float], list[float]] = [], []
    for k in range(runs):
        for side in (0, 1) if k % 2 == 0 else (1, 0):
            times[side].append((old, new)[side](k))
    return Row(name, *times)


def requests(clock: str) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield name, time and request of second solves, first randomised plans and decisions.

    Args:
        clock: "wall_s" or "cpu_s".
    """
    for scenario in PAPER:
        yield f"second solve, {scenario}", clock, {"task": "plan", "scenario": scenario}
    # With patience 1 the improving planner ends soon after its first plan.
    for planner, parameters in {"HybridRRTConnect": {}, "HybridRRTstar": {"patience": 1}}.items():
        for scenario in PAPER:
            request = {"scenario": scenario, "planner": planner, "parameters": parameters}
            yield f"first plan, {planner}, {scenario}", "first_plan_s", {"task": "plan", **request}
    for threshold, word in ((False, "exact"), (True, "z_min or more?")):
        for scenario in PAPER:
            decisions = {"task": "decisions", "scenario": scenario, "threshold": threshold}
            yield f"1000 decisions, {word}, {scenario}", clock, decisions


def answers(old: Ask, new: Ask, runs: int, clock: str, only: str = "") -> Iterator[Row]:
    """Yield the times of ``requests`` whose names begin with ``only``; repetitions are seeds.

    Args:
        old: the old build's work process, warm.
        new: the new one's.
        runs: repetitions.
        clock: "wall_s" or "cpu_s".
        only: what names begin with.
    """
    for name, key, request in requests(clock):
        if name.startswith(only):

            def seconds(k: int, ask: Ask, key: str = key, request: Any = request) -> float:
                return float(ask(**request, seed=k)[key])

            for ask in (old, new):  # the first solve loads what only this scenario needs
                seconds(0, ask)
            yield alternate(name, runs, partial(seconds, ask=old), partial(seconds, ask=new))


def starts(old: Build, new: Build, runs: int, first_uses: int) -> Iterator[Row]:
    """Yield wall times of ``plan paper/slide`` in a new process.

    Args:
        old: one build.
        new: the other.
        runs: repetitions with compiled code at hand.
        first_uses: repetitions with an empty cache.
    """
    for build in (old, new) if runs else ():
        _start(build, None)
    if runs:
        yield alternate(
            "later start", runs, lambda _: _start(old, None), lambda _: _start(new, None)
        )
    if first_uses:
        yield alternate("first use", first_uses, lambda _: _first(old), lambda _: _first(new))


def _first(build: Build) -> float:
    with tempfile.TemporaryDirectory() as empty:
        return _start(build, Path(empty))


def _start(build: Build, cache: Path | None) -> float:
    started = time.perf_counter()
    subprocess.run(
        [build.command, "plan", "paper/slide"], env=build.variables(cache), check=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    return time.perf_counter() - started
