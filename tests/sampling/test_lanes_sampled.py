"""What bounds, draws and the lazy search over a sample promise."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.known import FAILED
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Problem
from gm_ompl.sampling.lane_sample import LaneSample
from gm_ompl.sampling.lane_store import LaneStore, SetDraw
from gm_ompl.sampling.lines import polyline
from gm_ompl.sampling.route import Route


def _store(problem: Problem, judge: Judge) -> LaneStore:
    route = Route(judge, polyline(problem, [problem.start, (1.0,)]))
    return LaneStore(judge, PlacementSets(problem.fingers.groups()), route)


def _every_set(problem: Problem, judge: Judge) -> np.ndarray:
    rows = range(len(problem.fingers.placements))
    sets = [pair for pair in itertools.combinations(rows, 2) if judge.apart(pair)]
    return np.array(sets, dtype=np.int64)


@pytest.mark.parametrize("ahead", [True, False])
def test_screening_refutes_no_set_that_holds(
    ahead: bool, small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """How far a set comes by the cuts is never less than how far it comes when judged."""
    problem = small("tumble")
    judge = new_judge(problem)
    store, rng = _store(problem, judge), np.random.default_rng(1)
    sets = rng.permutation(_every_set(problem, judge))[:60]
    K = store.route.strides
    first, last = (0, K) if ahead else (K, 0)
    for lane in map(tuple, sets[:30].tolist()):
        store.probe(lane, first, last)  # leaves cuts
    bound = np.full(len(sets), last, dtype=np.int64)
    store.screen(np.ascontiguousarray(sets), first, last, bound)
    stopped = 0
    for m, lane in enumerate(map(tuple, sets.tolist())):
        reach = _judged(problem, judge, store, lane, ahead)
        assert reach <= bound[m] if ahead else reach >= bound[m]
        stopped += bound[m] != last
    assert stopped > 10, "the cuts say something"


def _judged(
    problem: Problem, judge: Judge, store: LaneStore, lane: tuple[int, ...], ahead: bool
) -> int:
    """Return how far a set comes, each segment judged in turn."""
    table, z_min = store.route.table, problem.mechanics.z_min
    K, P = table.tables.states.shape
    k = 0 if ahead else K
    while 0 <= (j := k if ahead else k - 1) < K:
        free = all(table.tables.free[i, row, j] for i, row in enumerate(lane))
        if not free or any(
            judge.backend.decide(table.state(j, p), (0, 1), lane).z < z_min for p in range(P)
        ):
            break
        k += 1 if ahead else -1
    return k


def test_probing_ends_where_a_stride_fails(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """Probing until nothing fails gives the same reach as judging every segment in turn."""
    problem = small("tumble")
    judge = new_judge(problem)
    store, rng = _store(problem, judge), np.random.default_rng(2)
    K = store.route.strides
    for lane in map(tuple, rng.permutation(_every_set(problem, judge))[:25].tolist()):
        if not all(store.route.table.tables.free[i, row].all() for i, row in enumerate(lane)):
            continue
        reach = K
        while (got := store.probe(lane, 0, reach)) != reach:
            reach = got
        assert reach == _judged(problem, judge, store, lane, True)
        assert reach == K or FAILED in store.known.margins(lane)[reach]


@pytest.mark.parametrize("name", ["slide", "tumble", "regrasp"])
def test_a_sample_of_all_sets_holds_the_optimum(
    name: str, small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """With every set in the sample the lazy search finds what A* proves optimal."""
    problem = small(name)
    judge = new_judge(problem)
    best = make_planner("astar").solve(problem, judge, Budget(), np.random.default_rng(0)).cost
    assert best is not None
    judge = new_judge(problem)
    sample = LaneSample(problem, _store(problem, judge))
    sample.add(_every_set(problem, judge))
    assert sample.least[0] <= best
    assert sample.improve(np.inf, 100_000, lambda: False) is not None
    assert sample.best == pytest.approx(best, rel=1e-9)


def test_bounds_hold_for_the_best_plan(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """No lane of the best plan is bounded above the plan's cost."""
    problem = small("regrasp")
    judge = new_judge(problem)
    sample = LaneSample(problem, _store(problem, judge))
    sample.add(_every_set(problem, judge))
    legs = sample.improve(np.inf, 100_000, lambda: False)
    assert legs is not None
    lanes = np.array([lane for lane, _, _ in legs])
    _, g = sample.so_far()
    _, d = sample.onward()
    for bounds in sample.bounds(lanes, g, d):
        assert (bounds <= sample.best * (1 + 1e-9)).all()


def test_draws_are_valid_sets_and_lean_to_success(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """Drawn sets are distinct, ordered and apart; rows that did well come more often."""
    problem = small("tumble")
    judge = new_judge(problem)
    draw, rng = SetDraw(problem, judge, 2.0, 0.1), np.random.default_rng(0)
    rows = len(problem.fingers.placements)
    allowed = (np.ones(rows, dtype=bool),) * 2
    before = draw.draw(400, allowed, rng)
    assert len(np.unique(before, axis=0)) == len(before)
    assert (before[:, 0] < before[:, 1]).all()
    assert all(judge.apart(tuple(row)) for row in before.tolist())
    good = (before == 5).any(axis=1)
    draw.learn(before, good.astype(float))
    later = draw.draw(400, allowed, rng)
    assert (later == 5).any(axis=1).mean() > 2 * good.mean()
