"""Bounds on z over cells of placements: no point of a cell is better."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.arrays import Array, IntArray
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.mechanics import columns
from gm_ompl.mechanics.cell_cuts import CellBoxes, CellCuts
from gm_ompl.mechanics.cell_margin import cell_margin, corner_columns
from gm_ompl.mechanics.certificate import NO_RECORD, separates_environment
from gm_ompl.mechanics.cuts import state_bound
from gm_ompl.mechanics.instant import DIRECTIONS, touching
from gm_ompl.mechanics.modes import decide
from gm_ompl.mechanics.program import Program
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load

NAMES = ("paper/slide", "paper/tumble", "paper/cork", "shapes/hexagon", "fingers/three")


def sides(problem: Problem) -> Array:
    """Return the hand's columns (n, F, s, 3, 6) on each face, in lengths along two tangents."""
    hand, s = problem.fingers, problem.mechanics.cone_edges
    faces = np.unique(hand.placements.face, return_index=True)[1]
    U = columns.wrench_norm(problem.mass, problem.inertia)
    found = []
    for row in faces:
        n, p = hand.placements.normals[row], hand.placements.points[row]
        t = np.linalg.svd(n[None])[2][1:]
        spots = np.array([p, p + t[0], p + t[1]])
        shape = (hand.count, 3, 3)
        at = columns.hand_columns(
            np.broadcast_to(spots, shape), np.broadcast_to(n, shape), hand.friction, hand.soft, s, U
        )
        found.append(np.stack([at[:, 0], at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]], axis=2))
    return np.stack(found, axis=1)


def drawn(rng: np.random.Generator, faces: int, size: float, n: int) -> CellBoxes:
    """Return n random cells of sides up to ``size``."""
    boxes = rng.uniform(-size, size, (n, 4))
    boxes[:, 2:] = np.abs(boxes[:, 2:]) * rng.choice([0.0, 0.1, 1.0], (n, 1))
    return CellBoxes(boxes, rng.integers(0, faces, n))


def inside(rng: np.random.Generator, boxes: CellBoxes) -> CellBoxes:
    """Return a random point of each cell, often a corner, as cells of no size."""
    share = rng.choice([-1.0, 1.0, 0.0], (len(boxes.faces), 2)) * rng.uniform(0, 1, 2) ** 0.2
    points = np.zeros_like(boxes.sides)
    points[:, :2] = boxes.sides[:, :2] + share * boxes.sides[:, 2:]
    return CellBoxes(points, boxes.faces)


def bounded(
    backend: KernelBackend, side: Array, state: int, boxes: CellBoxes
) -> tuple[float, Array, Array, Array]:
    """Return the bound of a product of cells, its wrench, and columns and load."""
    env, q, _, f_max = backend.columns(state)
    y, hand = np.zeros(6), np.arange(len(f_max))
    tips = corner_columns(side, hand, hand, boxes)
    program = Program(env, q, tips, f_max, DIRECTIONS)
    z = cell_margin(program, separates_environment(env), 0.0, y)
    return z, y, tips, q


@pytest.mark.parametrize("name", NAMES)
def test_no_point_of_a_cell_is_better(name: str) -> None:
    """z(point) <= bound of the cell, for any modes: position control of all bounds them."""
    problem = load(name, ["fingers.placements.grid=[2, 2]"]).problem
    backend = make_backend(problem)
    assert isinstance(backend, KernelBackend)
    judge, rng, side = Judge(problem, backend), np.random.default_rng(5), sides(problem)
    state = judge.environment(problem.motion.moment((0.3,), (0.1,)))
    env, q, _, f_max = backend.columns(state)
    stable, size = 0, 0.3 * problem.body.diagonal
    for _ in range(40):
        boxes = drawn(rng, side.shape[1], size, problem.fingers.count)
        bound, y, _, _ = bounded(backend, side, state, boxes)
        points = inside(rng, boxes)
        z, _, tips, _ = bounded(backend, side, state, points)
        slack = 4e-7 * max(bound, 1e-3) if bound > -np.inf else 0.0
        assert z <= max(bound, 0.0) + slack  # where it is -inf, both are bounds alone
        single = np.ascontiguousarray(tips[:, : side.shape[2]])
        program, f_com = Program(env, q, single, f_max, DIRECTIONS), np.zeros(len(f_max))
        _, best, _, _ = decide(touching(program), 0.0, -1, -1, NO_RECORD, f_com, np.zeros(6))
        assert best <= bound + slack
        stable += best > 0.0
        rows: IntArray = np.arange(len(f_max))
        fresh = CellCuts(side, f_max, DIRECTIONS)
        fresh.widen(points, len(rows))
        fresh.add(state, q, y)
        assert state_bound(state, rows, fresh.tables) >= best - 1e-9
    assert stable


def test_cuts_of_cells_are_largest_at_corners() -> None:
    """T over a cell is the largest T of its corners; cells and cuts may come in any order."""
    rng = np.random.default_rng(1)
    side, f_max = rng.normal(size=(2, 3, 6, 3, 6)), np.array([1.0, 2.0])
    boxes = drawn(rng, 3, 1.0, 9)
    q = rng.normal(size=6)
    early, late = CellCuts(side, f_max, DIRECTIONS), CellCuts(side, f_max, DIRECTIONS)
    early.widen(boxes, 4)
    ys = rng.normal(size=(60, 6))
    for y in ys:
        early.add(2, q, y)
        late.add(2, q, y)
    early.widen(boxes, 9)
    late.widen(boxes, 9)
    assert early.version == 60
    for rows in rng.integers(0, 9, (20, 2)):
        tips = corner_columns(side, np.arange(2), rows, boxes)
        kept = ys[-48:]
        supports = np.maximum(np.einsum("ikt,yt->yik", tips, kept).max(axis=2), 0.0)
        h = (DIRECTIONS @ kept.T).max(axis=0)
        expected = max(0.0, ((kept @ q + supports @ f_max) / h).min())
        for cuts in (early, late):
            found = state_bound(2, rows, cuts.tables)
            assert found < 0.0 or found == pytest.approx(expected, abs=1e-12)
