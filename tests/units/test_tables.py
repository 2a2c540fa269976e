"""The tables along arcs: lengths are those of the arcs, costs ahead those of shortest ways."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.tables import ArcTable
from gm_ompl.sampling.lines import polyline
from gm_ompl.sampling.route import Route
from gm_ompl.scenario.load import load


@pytest.fixture(scope="module")
def table() -> ArcTable:
    """Return the tables of a small scenario's path."""
    changes = ["fingers.placements.grid=[2, 2]", "lattice.segments=6"]
    problem = load("paper/tumble", changes).problem
    judge = Judge(problem, make_backend(problem))
    return Route(judge, polyline(problem, [problem.start, (1.0,)])).table


def test_free_along_an_arc_is_free_at_its_ends(table: ArcTable) -> None:
    """Nothing is free along an arc and not at the nodes that it joins."""
    tables = table.tables
    for a, row in enumerate(tables.like):
        for node in (tables.tail[a], tables.head[a]):
            assert not (tables.free[:, :, row] & ~tables.node_free[:, :, node]).any()


def test_costs_ahead_are_shortest_ways(table: ArcTable) -> None:
    """Per finger and placement the travel to the goal, as Dijkstra finds it."""
    tables = table.measured
    V, goal = len(tables.goal), np.flatnonzero(tables.goal)
    finite = 0
    for i in range(len(tables.ahead)):
        for g in range(tables.ahead.shape[1]):
            travel = tables.lengths[i, g].sum(axis=1)[tables.like]
            open_ = tables.free[i, g][tables.like]
            ways = (travel[open_], (tables.head[open_], tables.tail[open_]))
            expected = dijkstra(coo_array(ways, shape=(V, V)).tocsr(), indices=goal).min(axis=0)
            np.testing.assert_allclose(tables.ahead[i, g], expected, rtol=1e-12)
            finite += int(np.isfinite(expected).sum())
    assert finite > V
    assert (tables.least <= tables.ahead.min(axis=(0, 1)) + 1e-12).all()
