"""Bounds on an open floor: no arc outruns them; the search finds the same with and without."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph.floor_bounds import FloorBounds
from gm_ompl.graph.floor_values import FloorSets
from gm_ompl.holds.sets import placement_sets
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget, Status
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.graph.floor_scenes import arcs_on_floor, open_floor
from tests.kept import kept, lanes

NODES, SETS = 60, 6
AGREE = 1e-9
ENOUGH = 4.0
SEARCHED = (*range(100, 102), *range(103, 108), *range(109, 123))
LANES = (104, 105, 109, 115)
OPTIMUM = 23.68712315540289
OUTRUN = range(16)
SMALL = (
    "fingers.placements.grid=[2, 2]",
    "motion.goal.position=[10, 0, 2.5]",
    "motion.free.region={x: [-10, 20], y: [-8, 8], z: [0, 8]}",
    "lattice.steps={translation: 2.5, rotation: 45 deg}",
    "cost.samples_per_arc=3",
)


def _bounds(problem: Problem) -> tuple[Judge, FloorBounds | None, IntArray]:
    """The bounds of a problem, and sets of placements that do not run into each other."""
    judge, hand = Judge(problem, KernelBackend(problem)), problem.fingers
    free = judge.node(problem.object_graph.pose(0)).free
    rows = placement_sets(hand.groups(), free, judge.clear, 100_000)
    assert rows is not None
    return judge, FloorBounds.of(judge, rows), rows


def _floor(bounds: FloorBounds, number: int, pose: Pose) -> float:
    """The bound of a set from a pose on."""
    table, (attitude,) = bounds.table, bounds.attitudes(pose.rotation[None], pose.position[None])
    row = table.rows[number]
    left = table.ways[row] @ (table.goal - pose.apply(table.points[row])[:2])
    return float(table.values[row, attitude] - table.slack + left)


def _margins(problem: Problem, judge: Judge, arc: GraphArc, rows: IntArray) -> Array:
    """z of sets (K, n) in each segment of an arc (K, parts); -inf where a fingertip is not free."""
    backend, passing = judge.backend, judge.along(arc.arc)
    assert isinstance(backend, KernelBackend)
    z = np.full((len(rows), arc.parts), -np.inf)
    own = [passing.free[i][rows[:, i]] for i in range(rows.shape[1])]
    (free,) = np.nonzero(np.all(own, axis=0) & passing.object_free)
    if len(free):
        for j, state in enumerate(judge.environments(arc)):
            states = np.full(len(free), state)
            z[free, j] = backend.margins(states, rows[free], problem.mechanics.z_min)
    return z


def _settled(bounds: FloorBounds, which: IntArray, rng: np.random.Generator) -> None:
    """Settle sets, for directions by chance now and then."""
    asked, angles = bounds._asked, rng.uniform(0.0, 2.0 * np.pi, len(which))
    ways = np.column_stack([np.cos(angles), np.sin(angles)]) * rng.choice([0.5, 1.0, 1.0])

    def by_chance(sets: IntArray) -> FloorSets:
        return asked(sets)._replace(ways=ways) if rng.random() < 0.7 else asked(sets)

    with mock.patch.object(bounds, "_asked", by_chance):
        bounds.settle(which, np.inf)


@pytest.mark.parametrize("seed", OUTRUN)
def test_no_arc_outruns_the_bound(seed: int) -> None:
    """Along every arc that a set can do it falls by at most Eq. (9), whichever way y is."""
    problem, rng = open_floor(seed), np.random.default_rng(seed)
    judge, bounds, rows = _bounds(problem)
    assert bounds is not None
    which = rng.permutation(len(rows))[:SETS]
    _settled(bounds, which, rng)
    graph, X_stab, D = problem.object_graph, problem.cost.stability, problem.body.diagonal
    for tail, arc in arcs_on_floor(problem, NODES):
        here, there = graph.pose(tail), graph.pose(arc.head)
        for k, z in zip(which, _margins(problem, judge, arc, rows[which]), strict=True):
            if (z < problem.mechanics.z_min).any():
                continue
            tips = np.array([judge.centres(i)[row] for i, row in enumerate(rows[k])])
            travel = arc.lengths(tips).max(axis=0)
            cost = float(((1.0 + X_stab / np.maximum(z, problem.z_floor)) * travel).sum())
            fallen = _floor(bounds, k, here) - _floor(bounds, k, there)
            assert np.isnan(fallen) or fallen <= cost + 1e-6 * D  # NaN: dead ends
            if graph.in_goal(arc.head):
                assert _floor(bounds, k, there) <= 1e-9


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
    assert on.cost == pytest.approx(OPTIMUM, rel=1e-6)
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
    """What takes too much memory is not kept; that is found again, and costs are the same."""
    problem = load("free/over-there", SMALL).problem
    _, bounds, rows = _bounds(problem)
    assert bounds is not None
    every = np.arange(len(rows))
    with limits.holding(0.0), pytest.raises(LimitError):
        bounds.settle(every, np.inf)
    with mock.patch.object(limits, "fits", return_value=False):
        found = bounds.settle(every, np.inf)
    assert (bounds.table.rows < 0).all()
    assert bounds.settle(every, np.inf) == pytest.approx(found)
    assert (bounds.table.rows >= 0).all()
    with mock.patch.object(FloorBounds, "_keep"):
        search = kept(problem)
    assert search.cost == pytest.approx(OPTIMUM, rel=1e-6)
