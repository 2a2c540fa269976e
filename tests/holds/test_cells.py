"""Cells of placements: what they say holds for every placement in them."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.mechanics.cell_margin import corner_columns
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load


def graph_of(problem: Problem) -> CellGraph:
    backend = make_backend(problem)
    assert isinstance(backend, KernelBackend)
    return CellGraph(problem, Judge(problem, backend), backend)


@pytest.mark.parametrize("name", ["paper/tumble", "shapes/hexagon", "shapes/l-bracket"])
def test_cells_bound_their_placements(name: str) -> None:
    """Halving ends at single placements; a cell is as free, and as near, as its best placement."""
    problem = load(name, ["fingers.placements.grid=[5, 4]", "lattice.segments=4"]).problem
    graph = graph_of(problem)
    cells, whole = graph.cells, graph._table.measured
    found, waiting = list[int](), list(cells.faces)
    while waiting:
        cell = waiting.pop()
        if cells.row(cell) >= 0:
            assert cells.width(cell) == 0.0
            found.append(cells.row(cell))
            continue
        assert cells.width(cell) > 0.0
        left, right = cells.halves(cell)
        assert cells.halves(cell) == (left, right)
        tables = cells.tables
        for many, pair in (
            (tables.lengths[:, cell], tables.lengths[:, [left, right]].min(axis=1)),
            (tables.free[:, cell], tables.free[:, [left, right]].any(axis=1)),
            (tables.node_free[:, cell], tables.node_free[:, [left, right]].any(axis=1)),
        ):
            assert np.array_equal(many, pair)
        waiting += [left, right]
    assert sorted(found) == list(range(len(problem.fingers.placements)))
    for row in found:
        assert np.array_equal(cells.tables.lengths[:, cells.point(row)], whole.lengths[:, row])


@pytest.mark.parametrize("name", ["paper/tumble", "shapes/hexagon"])
def test_columns_are_affine_on_a_face(name: str) -> None:
    """The columns at a cell's corners are those of its placements there, or beyond them."""
    problem = load(name, ["fingers.placements.grid=[5, 4]", "lattice.segments=4"]).problem
    graph, backend = graph_of(problem), make_backend(problem)
    assert isinstance(backend, KernelBackend)
    columns = graph.cells.by_face(backend.tips)
    hand = np.arange(problem.fingers.count)
    for row in range(len(problem.fingers.placements)):
        cell = graph.cells.point(row)
        tips = corner_columns(columns, hand, np.full(len(hand), cell), graph.cells.boxes)
        expected = np.tile(backend.tips[:, row], (1, 4, 1))
        assert tips == pytest.approx(expected, abs=1e-9)


def test_fingertips_too_wide_for_two_cells() -> None:
    """Cells in which no two placements are far enough apart hold no set."""
    problem = load("paper/tumble", ["fingers.placements.grid=[9, 9]"]).problem
    graph = graph_of(problem)
    least = Judge(problem, make_backend(problem)).least_distances()[0, 1]
    cell = graph.cells.faces[0]
    assert graph.apart((cell, cell))
    while graph.cells.width(cell) > 0.5 * least:
        cell = graph.cells.halves(cell)[0]
    left, right = graph.cells.halves(cell)
    assert not graph.cells.apart(0, left, 1, right, least)
