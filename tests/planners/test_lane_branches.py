"""The search over lanes where the object's graph branches, against Dijkstra's algorithm."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.holds.sets import placement_sets
from gm_ompl.planners.lattice_astar import solve_on_lanes
from gm_ompl.planners.planner import Budget, SearchResult, Status, silent
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Displacement, Problem
from gm_ompl.scenario.load import load

PLANAR = [
    ("planar/corner", ["cost.regrasp=0.01", "fingers.placements.grid=[2, 1]"]),
    (
        "planar/corridor",
        ["lattice.steps={x: 2, y: 2, yaw: 90 deg}", "fingers.placements.grid=[1, 1]"],
    ),
]


def both(problem: Problem) -> tuple[SearchResult, SearchResult]:
    """Solve over lanes and by Dijkstra's algorithm."""
    lanes = solve_on_lanes(problem, Judge(problem, KernelBackend(problem)), Budget(), silent)
    judge, rng = Judge(problem, KernelBackend(problem)), np.random.default_rng(0)
    return lanes, make_planner("dijkstra").solve(problem, judge, Budget(), rng)


def same(lanes: SearchResult, plain: SearchResult) -> None:
    assert lanes.status is plain.status
    if plain.cost is not None:
        assert lanes.cost == pytest.approx(plain.cost, rel=1e-6)
        assert lanes.cost == pytest.approx(sum(move.cost for move in lanes.moves), rel=1e-9)


@pytest.mark.parametrize(("name", "overrides"), PLANAR)
def test_planar_lattices(name: str, overrides: list[str]) -> None:
    """In the plane, with walls and regrasps, the optimum is Dijkstra's, and its arcs join."""
    problem = load(name, overrides).problem
    lanes, plain = both(problem)
    same(lanes, plain)
    assert (lanes.status is Status.SOLVED) == (name == "planar/corner")
    if not lanes.moves:
        return
    q, placements = problem.start, lanes.moves[0].placements
    for move in lanes.moves:
        assert move.placements == placements
        if isinstance(move, Displacement):
            assert move.start == pytest.approx(q)
            q = move.end
        else:
            assert move.at == pytest.approx(q)
            k = move.finger
            placements = (*placements[:k], move.target, *placements[k + 1 :])
    assert problem.goal.contains(q)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("X_regr", [0.01, 1.0])
def test_a_grid_of_slides(
    seed: int, X_regr: float, sliding_xy: Callable[..., Problem], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where random arcs of a grid are missing one way, the outcome is Dijkstra's."""
    small = load("paper/slide", ["fingers.placements.grid=[2, 1]", "lattice.segments=3"]).problem
    problem = sliding_xy(small, (3, 2))
    problem = dataclasses.replace(problem, cost=dataclasses.replace(problem.cost, regrasp=X_regr))
    graph, rng = problem.object_graph, np.random.default_rng(seed)
    arcs = {
        node: [arc for arc in graph.arcs_from(node) if rng.random() < 0.7] for node in range(12)
    }
    monkeypatch.setattr(type(graph), "arcs_from", lambda _, node: arcs[node])
    same(*both(problem))


def test_bounds_are_shortest_ways(sliding_xy: Callable[..., Problem]) -> None:
    """A lane's bounds, keys and hubs' rows are shortest ways by its arcs' costs."""
    small = load("paper/slide", ["fingers.placements.grid=[2, 1]", "lattice.segments=3"]).problem
    problem = sliding_xy(small, (3, 2))
    backend = KernelBackend(problem)
    judge = Judge(problem, backend)
    graph = LaneGraph(problem, judge, backend)
    tables, groups = graph.tables, problem.fingers.groups()
    anywhere = [row.any(axis=1) for row in tables.node_free]
    sets = placement_sets(groups, anywhere, judge.clear, 100_000)
    assert sets is not None and not tables.one_pass
    for row in sets[::5]:
        lane = graph.lane(tuple(row.tolist()))
        for a in np.flatnonzero(np.isfinite(lane.costs))[::3].tolist():
            graph.judge_arcs(lane, (a,))
        distance = np.full((len(lane.d),) * 2, np.inf)
        np.fill_diagonal(distance, 0.0)
        np.minimum.at(distance, (tables.tail, tables.head), lane.costs)
        for k in range(len(lane.d)):  # Floyd and Warshall
            np.minimum(distance, distance[:, k, None] + distance[None, k], out=distance)
        ends = [
            c
            for c in np.flatnonzero(tables.goal)
            if tables.node_free[:, :, c][np.arange(len(row)), row].all()
        ]
        to_goal = distance[:, ends].min(axis=1, initial=np.inf)
        np.testing.assert_allclose(lane.d, to_goal, rtol=1e-12)
        for c in range(len(lane.d)):
            for head in np.flatnonzero(np.isfinite(distance[c])).tolist():
                way = graph.way(lane, c, head)
                assert lane.costs[list(way)].sum() == pytest.approx(distance[c, head])
            cost, _, _ = graph.target(lane, c, 0.0)
            onward = [graph.hub(hub).value + tables.X_regr for hub in lane.hubs]
            best = min([to_goal[c], *((distance[c] + V).min() for V in onward)])
            assert cost == pytest.approx(best) or cost == best
