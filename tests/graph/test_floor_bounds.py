"""Bounds on an open floor: no arc outruns them, and the search finds the same with and without."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest

from gm_ompl import limits
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph.floor_bounds import FloorBounds
from gm_ompl.holds.sets import placement_sets
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget, Status
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.kept import kept, lanes
from tests.graph.floor_scenes import arcs_on_floor, open_floor

NODES, SETS = 120, 6
AGREE = 1e-9
SMALL = (
    "fingers.placements.grid=[2, 2]",
    "motion.goal.position=[10, 0, 2.5]",
    "motion.free.region={x: [-10, 20], y: [-8, 8], z: [0, 8]}",
    "lattice.steps={translation: 2.5, rotation: 45 deg}",
    "cost.samples_per_arc=3",
)


def _bounds(problem: Problem) -> tuple[Judge, FloorBounds | None, np.ndarray]:  # type: ignore[type-arg]
    """The bounds of a problem, and sets of placements that do not run into each other."""
    judge, hand = Judge(problem, KernelBackend(problem)), problem.fingers
    free = judge.node(problem.object_graph.pose(0)).free
    rows = placement_sets(hand.groups(), free, judge.clear, 100_000)
    assert rows is not None
    return judge, FloorBounds.of(judge, rows), rows


def _floor(bounds: FloorBounds, number: int, pose: Pose) -> float:
    """The bound from a pose on."""
    table, (attitude,) = bounds.table, bounds.attitudes(pose.rotation[None], pose.position[None])
    row = table.rows[number]
    o = pose.apply(table.points[row])[:2]
    left = table.values[row, attitude] - table.slack + table.ways[row] @ (table.goal - o)
    return float(left)


@pytest.mark.parametrize("seed", range(30))
def test_no_arc_outruns_the_bound(seed: int) -> None:
    """Along every arc that a set can do it falls by at most Eq. (9), whichever way y is."""
    problem, rng = open_floor(seed), np.random.default_rng(seed)
    judge, bounds, rows = _bounds(problem)
    if bounds is None or not len(rows):
        return
    which = rng.permutation(len(rows))[:SETS]
    asked = bounds._asked
    angle = rng.uniform(0.0, 2.0 * np.pi, len(rows))
    ways = np.column_stack([np.cos(angle), np.sin(angle)]) * rng.choice([0.5, 1.0, 1.0])
    if rng.random() < 0.7:
        with mock.patch.object(
            bounds, "_asked", lambda which: asked(which)._replace(ways=ways[which])
        ):
            left = bounds.settle(which, np.inf)
    else:
        left = bounds.settle(which, np.inf)
    graph, prices, fell = problem.object_graph, problem.cost.stability, 0
    for tail, arc in arcs_on_floor(problem, NODES):
        passing, chosen = judge.along(arc.arc), list[int]()
        for k in which.tolist() if passing.object_free else ():
            if all(passing.free[i][row] for i, row in enumerate(rows[k])):
                chosen.append(k)
        if not chosen:
            continue
        states, z = judge.environments(arc), np.full((len(chosen), arc.parts), np.inf)
        for j, state in enumerate(states):
            here = np.full(len(chosen), state)
            z[:, j] = judge.backend.margins(here, rows[chosen], problem.mechanics.z_min)  # type: ignore[attr-defined]
        for k, margins in zip(chosen, z, strict=True):
            if (margins < problem.mechanics.z_min).any():
                continue
            tips = np.array([judge.centres(i)[row] for i, row in enumerate(rows[k])])
            travel = arc.lengths(tips).max(axis=0)
            cost = float(((1.0 + prices / np.maximum(margins, problem.z_floor)) * travel).sum())
            fallen = _floor(bounds, k, graph.pose(tail)) - _floor(bounds, k, graph.pose(arc.head))
            assert np.isnan(fallen) or fallen <= cost + 1e-6 * problem.body.diagonal
            fell += fallen > 0.0
            if graph.in_goal(arc.head):
                assert _floor(bounds, k, graph.pose(arc.head)) <= 1e-9
    DONE.append(fell)


DONE = list[int]()


def _infeasible_too(problem: Problem) -> tuple[KeptSearch, KeptSearch]:
    """The search with and without these bounds."""
    with mock.patch.object(FloorBounds, "of", return_value=None):
        other = kept(problem, ENOUGH)
    return kept(problem, ENOUGH), other


ENOUGH = 4.0


@pytest.mark.parametrize("seed", range(100, 130))
def test_the_search_finds_the_same(seed: int) -> None:
    """Cost and bound are those that it finds without these bounds."""
    problem = open_floor(seed)
    on, off = _infeasible_too(problem)
    assert on.cost == pytest.approx(off.cost, rel=AGREE)
    assert on.bound == pytest.approx(off.bound, rel=1e-6, abs=1e-6)
    print(seed, on.cost, on.bound, on.expanded, off.expanded, on.graph._floor is not None)
