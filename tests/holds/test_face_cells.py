"""Cells of whole faces: what they say holds at every point in them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import Outcome
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.patches import Patch, frames, loose, patches
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.holds.face_cells import FaceCells
from gm_ompl.mechanics.cell_margin import corner_columns, corner_points
from gm_ompl.mechanics.cell_modes import aims, largest_sets, squeezed
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.cylinders import cylinder

MARGIN = {"paper/tumble": 0.5, "shapes/hexagon": 0.2, "shapes/l-bracket": 0.004}


def anywhere(name: str) -> tuple[Problem, tuple[Patch, ...], CellGraph, FaceCells]:
    """Return a problem with continuous placements, its patches, and cells over them."""
    said = {"margin": MARGIN[name]}
    problem = load(name, {"fingers.placements.continuous": said, "lattice.segments": 4}).problem
    where, hand = problem.fingers.anywhere, problem.fingers
    assert where is not None
    found = patches(problem.body, where.faces, where.margin)
    table = frames(found, hand.placements.labels)
    framed = dataclasses.replace(problem, fingers=dataclasses.replace(hand, placements=table))
    backend = KernelBackend(framed)
    judge = Judge(framed, backend)
    graph = CellGraph(
        framed, judge, backend, tree=lambda arcs: FaceCells(judge, arcs, found, hand.placements)
    )
    assert isinstance(graph.cells, FaceCells)
    return problem, found, graph, graph.cells


def descend(cells: FaceCells, rng: np.random.Generator, depth: int) -> int:
    """Return a random cell that so many halvings make of a face."""
    cell = int(rng.choice(cells.faces))
    for _ in range(depth):
        cell = cells.halves(cell)[int(rng.integers(2))]
    return cell


def drawn(cells: FaceCells, cell: int, rng: np.random.Generator) -> Array:
    """Return a random point (3,) in a cell, at times a corner."""
    sides = cells.boxes.sides[cell]
    share = rng.uniform(-1, 1, 2) if rng.random() < 0.7 else rng.choice([-1.0, 1.0], 2)
    found: Array = cells.patch(cell).points((sides[:2] + share * sides[2:])[None])[0]
    return found


@pytest.mark.parametrize("name", list(MARGIN))
def test_what_holds_at_a_point_may_hold_in_its_cell(name: str) -> None:
    """Chords are as short, fingertips as free and margins as large as at any point of a cell."""
    problem, found, graph, cells = anywhere(name)
    rng, hand = np.random.default_rng(5), problem.fingers
    scale = problem.force_scale
    for _ in range(6 if "bracket" in name else 25):
        chosen = tuple(descend(cells, rng, int(rng.integers(1, 12))) for _ in range(hand.count))
        which = [int(cells.boxes.faces[cell]) for cell in chosen]
        points = np.array([drawn(cells, cell, rng) for cell in chosen])
        offered = [found[f].offers(p[None])[0] for f, p in zip(which, points, strict=True)]
        table = loose(found, which, points, hand.placements.labels)
        placed = dataclasses.replace(problem, fingers=dataclasses.replace(hand, placements=table))
        backend = KernelBackend(placed)
        judge = Judge(placed, backend)
        whole, arcs = cells.tables, graph._table
        here = arcs.lengths(judge.centres(0))
        node_free, free = arcs.tested(judge)
        for i, cell in enumerate(chosen):
            assert (whole.lengths[i, cell] <= here[i] * (1.0 + 1e-9) + 1e-9).all()
            if offered[i]:
                assert (whole.free[i, cell] | ~free[i, i]).all()
                assert (whole.node_free[i, cell] | ~node_free[i, i]).all()
        fingers = tuple(range(hand.count))
        for arc in (0, len(arcs.frame.arcs) // 2):
            moment = arcs.frame.arcs[arc].middles()[0]
            decision = backend.decide(judge.environment(moment), fingers, fingers)
            state = arcs.state(arc, 0)
            if graph.cuts.cells < len(cells):
                graph.cuts.widen(cells.boxes, len(cells))
            z = graph._bound(state, list(fingers), chosen) * scale
            if decision.outcome is Outcome.STABLE and decision.z >= problem.mechanics.z_min:
                assert z >= decision.z * (1.0 - 1e-9)


def test_fingers_that_squeeze_are_not_both_position_controlled() -> None:
    """Where two fingers squeeze all over their cells, Problem (5) refuses them at every point."""
    problem, found, graph, cells = anywhere("paper/tumble")
    rng, hand, met = np.random.default_rng(3), problem.fingers, 0
    for _ in range(120):
        chosen = tuple(descend(cells, rng, int(rng.integers(4, 10))) for _ in range(2))
        tips = corner_columns(graph._columns, np.arange(2), np.array(chosen), cells.boxes)
        corners = corner_points(cells.planes, np.array(chosen), cells.boxes)
        pairs = squeezed(tips[:, :6, :3].copy(), corners)
        if not pairs:
            continue
        met += 1
        assert largest_sets(2, pairs).tolist() == [1, 2]
        which = [int(cells.boxes.faces[cell]) for cell in chosen]
        points = np.array([drawn(cells, cell, rng) for cell in chosen])
        table = loose(found, which, points, hand.placements.labels)
        placed = dataclasses.replace(problem, fingers=dataclasses.replace(hand, placements=table))
        backend = KernelBackend(placed)
        judge = Judge(placed, backend)
        moment = graph._table.frame.arcs[0].middles()[0]
        decision = backend.decide(judge.environment(moment), (0, 1), (0, 1))
        assert [mode.value for mode in decision.modes] != ["position", "position"]
    assert met > 5


def test_a_direction_in_a_cone() -> None:
    """A direction is in a cone where it lies within the angle of friction, edges left aside."""
    angles = 2.0 * np.pi * np.arange(6) / 6
    edges = np.stack([0.7 * np.cos(angles), 0.7 * np.sin(angles), np.ones(6)], axis=1)
    assert aims(edges, np.array([0.3, 0.1, 1.0]))
    assert not aims(edges, np.array([0.8, 0.1, 1.0]))
    assert not aims(edges, -np.array([0.3, 0.1, 1.0]))
    assert not aims(edges, edges[0])
    assert not aims(edges, np.zeros(3))


def test_cells_without_a_placement_are_empty() -> None:
    """Off a face, in a hole and near the rim no finger is placed; every placement is in a cell."""
    for tree, margin in ((load("shapes/l-bracket").resolved(), 0.004), (cylinder(24), 0.05)):
        problem = load(tree).problem
        rng = np.random.default_rng(1)
        for patch in patches(problem.body, "all", margin)[:8]:
            half = patch.rectangle.half
            spots = rng.uniform(-half, half, (200, 2))
            points, arm = patch.points(spots), 0.1 * float(half.max())
            near = points + rng.uniform(-1, 1, (200, 2)) * arm / np.sqrt(2.0) @ patch.rectangle.axes
            assert not (patch.empty(points, arm) & patch.offers(near)).any()
            assert not (patch.empty(points, 0.0) & patch.offers(points)).any()
            assert patch.places(points) == pytest.approx(spots, abs=1e-9)
            assert patch.height(points) == pytest.approx(0.0, abs=1e-9)
