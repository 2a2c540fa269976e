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

NODES, SETS = 60, 6
AGREE = 1e-9
ENOUGH = 4.0
SEARCHED = (*range(100, 102), *range(103, 108), *range(109, 123))
LANES = (100, 104, 105, 109)
FALLS = range(0)
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


@pytest.mark.parametrize("seed", range(16))
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
    assert fell or seed not in FALLS


def without(problem: Problem, enough: float = np.inf) -> KeptSearch:
    """The search without these bounds."""
    with mock.patch.object(FloorBounds, "of", return_value=None):
        return kept(problem, enough)


@pytest.mark.parametrize("seed", SEARCHED)
def test_the_search_finds_the_same(seed: int) -> None:
    """Cost and bound are those that it finds without these bounds."""
    problem = open_floor(seed)
    on, off = kept(problem, ENOUGH), without(problem, ENOUGH)
    assert on.graph._floor is not None
    assert on.cost == pytest.approx(off.cost, rel=AGREE)
    assert on.bound == pytest.approx(off.bound, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("seed", LANES)
def test_lanes_find_the_same(seed: int) -> None:
    """The other search, which knows nothing of these bounds."""
    problem = open_floor(seed)
    search, other = kept(problem), lanes(problem)
    assert other.status is Status.SOLVED
    assert other.optimal
    assert search.cost == pytest.approx(other.cost, rel=AGREE)


def test_a_box_goes_over_there() -> None:
    """A small variant of the example, its optimum and how much less is looked at."""
    problem = load("free/over-there", SMALL).problem
    on, off = kept(problem), without(problem)
    print(on.cost, on.bound, on.expanded, off.expanded)
    assert on.cost == pytest.approx(off.cost, rel=AGREE)
    assert on.expanded < 0.2 * off.expanded


@pytest.mark.parametrize("step", [1, 2, 5, 9])
def test_it_is_gone_on_with_where_a_limit_came(step: int) -> None:
    """A limit is reached while sets are settled: the search goes on as if it had not been."""
    problem = load("free/over-there", SMALL).problem
    whole, evaluate, calls = kept(problem), FloorBounds._evaluate, list[int]()

    def tired(*given: object) -> None:
        calls.append(1)
        if len(calls) == step:
            raise LimitError
        evaluate(*given)  # type: ignore[arg-type]

    judge = Judge(problem, KernelBackend(problem))
    search, stopped = KeptSearch.of(judge, Log(Budget().start(), judge)), 0
    assert search is not None
    with mock.patch.object(FloorBounds, "_evaluate", tired):
        while not search.done:
            try:
                search.step(np.inf)
            except LimitError:
                stopped += 1
    assert stopped == 1
    assert (search.cost, search.expanded) == (whole.cost, whole.expanded)


def test_limits_hold_while_sets_are_settled() -> None:
    """And where what is kept of them takes too much room."""
    _, bounds, rows = _bounds(load("free/over-there", SMALL).problem)
    assert bounds is not None
    with limits.holding(0.0), pytest.raises(LimitError):
        bounds.settle(np.arange(len(rows)), np.inf)
    refusing = mock.patch.object(limits.Limits, "refuses", return_value="too much")
    with refusing, limits.holding(), pytest.raises(LimitError, match="too much"):
        bounds.settle(np.arange(len(rows)), np.inf)
    assert (bounds.table.rows < 0).all()
    assert np.isfinite(bounds.settle(np.arange(len(rows)), np.inf)).any()
