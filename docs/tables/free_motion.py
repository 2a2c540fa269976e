"""``python -m docs.tables.free_motion [PAGE]``: what exact planning of free motion costs.

Plans every shipped scenario of free motion, then one of them with other steps, placements and
fingers, and shows how the cost of a small one goes as its steps are halved. Every search has a new
process, which has planned something small before. The tables go into
docs/results/free-motion.md. Takes less than ten minutes.
"""

from __future__ import annotations

import multiprocessing
import resource
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from docs.tables.pages import growing, write_page
from gm_ompl import api, limits
from gm_ompl.contact.lattice import ContactLattice
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planners.planner import Budget, SearchResult
from gm_ompl.planners.registry import make_planner
from gm_ompl.scenario.load import shipped
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.study.report import number

SHIPPED_LIMIT = 60.0
"""Wall time of a shipped scenario, and of one with halved steps [s]."""

LIMIT = 20.0
"""Of the others [s]."""

WARM = "random/free/3"
"""Planned first in each process: machine code is loaded then."""

VARIED = "tasks/reorient"
"""Whose steps, placements and fingers are changed."""

BASE = ("fingers.placements.grid=[3, 3]",)

GROWTH: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    "steps": tuple(
        (
            f"{length:g}, {angle:g} deg",
            (f"lattice.steps={{translation: {length}, rotation: {angle} deg}}",),
        )
        for length, angle in ((0.5, 30.0), (0.5, 15.0), (0.25, 15.0), (0.25, 7.5))
    ),
    "placements": tuple(
        (f"{n} x {n} per face", (f"fingers.placements.grid=[{n}, {n}]",)) for n in (2, 3, 5, 7)
    ),
    "fingers": tuple((f"{n}", (f"fingers.count={n}",)) for n in (1, 2, 3)),
}
"""What is varied, and the changes."""

HALVED = (
    "fingers.placements={grid: [2, 2], faces: [-y, +y]}",
    "motion.free.region={x: [0, 1], y: [0, 0], z: [0, 1]}",
    "motion.goal={x: [0.5, 1], rotation: {axis: [0, 1, 0], angle: 90 deg}}",
)
"""Of the same: a quarter turn, wherever it ends, on steps that are halved."""

STEPS = (0.5, 30.0)
"""The first steps: a length, and an angle [deg]."""

HALVINGS = 3

HEAD = (
    "scenario", "ends", "cost", "bound", "poses", "arc classes", "decisions", "s", "MB",
)  # fmt: skip


@dataclass(frozen=True)
class Cost:
    """What a search cost.

    Attributes:
        found: how it ended.
        poses: whose arcs were asked for.
        classes: of those arcs.
        seconds: wall time, the scenario's lattice included.
        megabytes: peak resident memory of its process [MiB].
    """

    found: SearchResult
    poses: int
    classes: int
    seconds: float
    megabytes: float

    def cells(self) -> list[str]:
        """Return them for a table."""
        found = self.found
        return [
            "proven optimal" if found.optimal else found.status.value,
            number(found.cost, 6),
            "" if found.optimal else number(found.lower_bound, 4),
            f"{self.poses:,}",
            f"{self.classes:,}",
            f"{found.statistics['mode_decisions']:,}",
            number(self.seconds),
            number(self.megabytes),
        ]


def measure(name: str, changes: Sequence[str] = (), limit: float = LIMIT) -> Cost:
    """Return what planning a scenario costs, in a new process."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
        return process.submit(measured, name, tuple(changes), limit).result()


def measured(name: str, changes: Sequence[str], limit: float) -> Cost:
    """Return the same, measured in this process."""
    _solved(api.load(WARM), LIMIT)
    return _solved(api.load(name, changes), limit)


def _solved(scenario: Scenario, limit: float) -> Cost:
    problem = scenario.problem
    started, graph = time.perf_counter(), problem.object_graph
    assert isinstance(graph, ContactLattice)
    with limits.holding(limit):
        judge = Judge(problem, make_backend(problem))
        found = make_planner("astar").solve(problem, judge, Budget(limit), np.random.default_rng(0))
    seconds = time.perf_counter() - started
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return Cost(found, graph.left, len(graph.arcs.kind_arcs), seconds, megabytes)


def of_shipped() -> Iterator[list[str]]:
    """Yield a row per shipped scenario of free motion."""
    for name in shipped():
        if isinstance(api.load(name).problem.motion, FreeMotion):
            yield [f"`{name}`", *measure(name, limit=SHIPPED_LIMIT).cells()]


def of_growth() -> Iterator[list[str]]:
    """Yield rows that show how the cost of planning grows."""
    for axis, cases in GROWTH.items():
        for shown, changes in cases:
            yield [axis, shown, *measure(VARIED, (*BASE, *changes)).cells()]


def of_halving() -> Iterator[list[str]]:
    """Yield rows that show how the optimum goes as steps are halved."""
    for k in range(HALVINGS + 1):
        length, angle = (step / 2**k for step in STEPS)
        steps = f"lattice.steps={{translation: {length:g}, rotation: {angle:g} deg}}"
        yield [
            f"{length:g}, {angle:g} deg",
            *measure(VARIED, (*HALVED, steps), SHIPPED_LIMIT).cells(),
        ]


if __name__ == "__main__":
    write_page(
        "free-motion",
        {
            "shipped": growing(HEAD, of_shipped()),
            "growth": growing(("varied", "to", *HEAD[1:]), of_growth()),
            "halving": growing(("steps", *HEAD[1:]), of_halving()),
        },
    )
