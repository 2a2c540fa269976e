"""Bounds along lanes: the same numbers, whichever way they are asked for."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.holds.sets import LIFTED, placement_sets
from gm_ompl.scenario.load import load

NAMES = (
    "paper/slide", "paper/tumble", "paper/regrasp",
    *(f"random/{family}/{seed}" for family in ("slide", "regrasp", "chain") for seed in range(3)),
)  # fmt: skip


@pytest.fixture(params=NAMES)
def graph(request: pytest.FixtureRequest) -> LaneGraph:
    """Return a graph of which a little is known: some lanes judged both ways."""
    segments = "[3, 4, 3]" if "chain" in request.param else "8"
    coarse = ["fingers.placements.grid=[3, 2]", f"lattice.segments={segments}"]
    problem = load(request.param, coarse).problem
    backend = KernelBackend(problem)
    graph = LaneGraph(problem, Judge(problem, backend), backend)
    rng, N = np.random.default_rng(1), len(graph.tables.goal) - 1
    for row in rng.permutation(all_sets(graph))[:6]:
        lane = graph.lane(tuple(row.tolist()))
        for a in np.flatnonzero(np.isfinite(lane.costs)).tolist():
            graph.judge_arcs(lane, (a,))
        for hub in lane.hubs:
            config = int(rng.integers(N + 1))
            graph.judge_rest(graph.hub(hub), config)
    return graph


def all_sets(graph: LaneGraph) -> np.ndarray:
    """Return all sets that are clear of each other somewhere."""
    fingers, judge = graph._problem.fingers, graph._judge
    anywhere = [row.any(axis=1) for row in graph.tables.node_free]
    sets = placement_sets(fingers.groups(), anywhere, judge.clear, 100_000)
    assert sets is not None
    return sets


def test_keys_of_many_lanes_are_those_of_one(graph: LaneGraph) -> None:
    """A key is the cost of the best target where nothing is decided of the lane itself."""
    sets, N = all_sets(graph), len(graph.tables.goal) - 1
    for config in (0, N // 2, N):
        keys = graph.keys(sets, config)
        for row, key in list(zip(sets, keys, strict=True))[:: max(1, len(sets) // 40)]:
            lane = graph.lane(tuple(row.tolist()))
            if np.isfinite(lane.known).any():
                continue
            free = all(graph.tables.node_free[k, p, config] for k, p in enumerate(row))
            cost, _, _ = graph.target(lane, config, 0.0)
            if free:
                assert key <= cost * (1 + 1e-12)
                assert graph.keys(row[None], config)[0] == pytest.approx(cost, rel=1e-12)


def test_rows_of_hubs_are_those_of_lanes(graph: LaneGraph) -> None:
    """What a hub knows of a lane is the lane's own cost to the goal."""
    sets = all_sets(graph)
    for row in sets[:: max(1, len(sets) // 15)]:
        for k in range(sets.shape[1]):
            hub = graph.hub(graph.sets.replaced(tuple(row.tolist()), k, LIFTED))
            for index in range(0, len(hub.choices), 3):
                lane = graph.lane(graph.lane_of(hub, index))
                if hub.versions[index] >= 0 and not np.isfinite(lane.known).any():
                    np.testing.assert_allclose(hub.table[index], lane.d, rtol=1e-12)


def test_bounds_of_hubs_start_from_geometry(graph: LaneGraph) -> None:
    """No hub's bound is below what geometry gives, and each set's hubs are all there."""
    assert graph.bounds is not None
    sets = all_sets(graph)
    ids = graph.bounds.ids(sets)
    ahead, least, X_regr = graph.tables.ahead, graph.tables.least, graph.tables.X_regr
    for row, mine in zip(sets[::7], ids[::7], strict=True):
        for k in range(len(row)):
            hub = graph.sets.replaced(tuple(row.tolist()), k, LIFTED)
            assert graph.bounds.row(hub) is not None
            assert (graph.bounds.V[mine[k]] == graph.bounds.row(hub)).all()
            others = [ahead[i, p] for i, p in enumerate(row) if i != k]
            geometric = np.minimum(np.max([least, *others], axis=0), X_regr + least)
            assert (graph.bounds.row(hub) >= geometric).all()
