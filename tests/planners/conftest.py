"""Problems with two coordinates, and decisions that two searches share."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import final

import numpy as np
import pytest

from gm_ompl.arrays import Array, read_only
from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.state import Instant
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.reference_backend import ReferenceBackend
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.arc import Arc, Motion
from gm_ompl.motion.lattice import Goal, Lattice
from gm_ompl.motion.screw import Screw, Slide
from gm_ompl.planners.planner import Budget, SearchResult
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Problem
from gm_ompl.reference.modes import Modes, decide_modes
from gm_ompl.scenario.load import load
from tests.shared_decisions import SharedDecisions

Decide = Callable[[Instant, Modes | None], ModeDecision]


@final
class SlidingXY(Motion):
    """The object slides on the floor in x and y."""

    def __init__(self, height: float, reach: float) -> None:
        self.names = ("x", "y")
        self.low, self.high = (-reach, -reach), (reach, reach)
        self.periods = (None, None)
        self.breakpoints = ((), ())
        self._height = height

    def pose(self, q: Sequence[float] | Array) -> Pose:
        return Pose(np.eye(3), np.array([float(q[0]), float(q[1]), self._height]))

    def velocity(self, q: Sequence[float] | Array, dq: Sequence[float] | Array) -> Twist:  # noqa: ARG002
        return Twist(np.array([float(dq[0]), float(dq[1]), 0.0]), np.zeros(3))

    def arc(self, tail: Sequence[float] | Array, head: Sequence[float] | Array) -> Arc:
        start = self.pose(tail)
        return Screw(start, Slide(self.pose(head).position - start.position))


def _sliding_xy(problem: Problem, steps: tuple[int, int], goal: Goal | None = None) -> Problem:
    """Return ``problem`` with its object on a lattice in x and y, unit steps from (0, 0)."""
    axes = tuple(read_only(np.arange(n + 1.0), (None,), "axis") for n in steps)
    corner = (float(steps[0]), float(steps[1]))
    motion = SlidingXY(float(problem.motion.pose(problem.start).position[2]), 10.0)
    return dataclasses.replace(
        problem,
        motion=motion,
        lattice=Lattice(axes, (None, None)),
        start=(0.0, 0.0),
        goal=goal or Goal(corner, corner, (None, None)),
    )


@pytest.fixture(scope="session")
def shared_decisions() -> Callable[[Problem], Decide]:
    return SharedDecisions


@pytest.fixture(scope="session")
def sliding_xy() -> Callable[..., Problem]:
    return _sliding_xy


@pytest.fixture(scope="session")
def solve() -> Callable[..., SearchResult]:
    """``solve(problem, planner, decide, budget)`` with the reference's decisions."""

    def run(
        problem: Problem,
        planner: str = "astar",
        decide: Decide = decide_modes,
        budget: Budget | None = None,
    ) -> SearchResult:
        judge = Judge(problem, ReferenceBackend(problem, lambda instant: decide(instant, None)))
        rng = np.random.default_rng(0)
        return make_planner(planner).solve(problem, judge, budget or Budget(), rng)

    return run


@pytest.fixture(scope="session")
def small_slide() -> Problem:
    """A short slide of the paper's box, two fingers, two cells per face."""
    return load("paper/slide", ["fingers.placements.grid=[2, 1]", "lattice.segments=3"]).problem
