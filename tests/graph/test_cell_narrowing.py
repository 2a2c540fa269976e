"""Placements that leave a cell are of no use in its product."""

from __future__ import annotations

import itertools
import math

import pytest

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.graph.cell_keys import Keys
from gm_ompl.graph.cell_narrowing import Narrowing
from gm_ompl.graph.cell_products import Products
from gm_ompl.holds.cells import Cells
from gm_ompl.scenario.load import load


@pytest.mark.parametrize(("name", "grid"), [("paper/regrasp", 3), ("shapes/hexagon", 3)])
@pytest.mark.parametrize("regrasps", [0, 1])
def test_no_plan_that_is_of_use_is_lost(name: str, grid: int, regrasps: int) -> None:
    """Every choice of placements whose own key is good enough stays; keys only rise."""
    changes = [f"fingers.placements.grid=[{grid}, {grid}]", "lattice.segments=6"]
    problem = load(name, changes).problem
    backend = KernelBackend(problem)
    graph = CellGraph(problem, Judge(problem, backend), backend)
    cells = graph.cells
    assert isinstance(cells, Cells)
    products, keys = Products(problem.fingers, graph), Keys(graph)
    narrowing = Narrowing(graph, cells, products, keys)
    found = products.begin(regrasps)
    assert found is not None
    lost = 0
    for product in found[:: 1 if regrasps == 0 else 7]:
        key = keys.key(product)
        enough = math.inf if regrasps == 0 else 1.1 * key
        narrow_key, narrow = narrowing.narrowed(product, key, enough)
        assert narrow_key >= key
        left = [set(cells.members(cell).tolist()) for cell in narrow.cells]
        if narrow_key >= enough:
            left = [set[int]() for _ in narrow.cells]
        for rows in itertools.product(*(cells.members(c).tolist() for c in product.cells)):
            stays = all(row in some for row, some in zip(rows, left, strict=True))
            lost += not stays
            if not stays:
                points = tuple(cells.point(row) for row in rows)
                single = products.made(product.skeleton, points, None)
                assert single is None or keys.key(single) >= enough * (1.0 - 1e-9)
    assert lost > 0


def test_what_was_narrowed_is_narrowed_no_more() -> None:
    """Nothing is lost twice, and cells of the same placements are one."""
    problem = load("paper/regrasp", ["fingers.placements.grid=[5, 5]"]).problem
    backend = KernelBackend(problem)
    graph = CellGraph(problem, Judge(problem, backend), backend)
    cells = graph.cells
    assert isinstance(cells, Cells)
    products, keys = Products(problem.fingers, graph), Keys(graph)
    narrowing, changed = Narrowing(graph, cells, products, keys), 0
    for product in products.begin(1) or []:
        key, before = keys.key(product), product
        for _ in range(20):
            after_key, after = narrowing.narrowed(before, key, math.inf)
            if after is before:
                break
            changed, key, before = changed + 1, after_key, after
        assert after is before
        for cell in before.cells:
            assert cells.of(cells.members(cell)) == cell
    assert changed > 0
