"""What searches have compiled before they begin: a call of each function, with their types.

The calls compute next to nothing: they are there for the types of their arguments. What few
scenarios ask for is compiled when they do: cells of placements, commands where z_min is 0, several
cases, z_strong, the contact lattice. Run as a program it compiles ``edges``, says so by a line, and
then what lanes, hubs and routes need.
"""

from __future__ import annotations

import sys
from typing import Final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, box
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.geometry.swept import SweptScene
from gm_ompl.graph import cell_bounds, cell_narrowing, hub_bounds, lane_bounds
from gm_ompl.holds import bounds
from gm_ompl.holds.rows import Tables, settle
from gm_ompl.mechanics import (
    cell_modes,
    certificate,
    equilibrium,
    kelley,
    modes,
    resistance,
    sides,
    simplex,
    stability,
    tableau,
    tau,
    trials,
)
from gm_ompl.mechanics.blocks import joint_margin
from gm_ompl.mechanics.cell_cuts import CellBoxes, CellCuts
from gm_ompl.mechanics.cell_margin import cell_margin, corner_columns, corner_points
from gm_ompl.mechanics.cuts import CutPool, CutTables
from gm_ompl.mechanics.instant import DIRECTIONS, touching
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.planners import lane_sources

# A unit weight on one contact, and one finger of three columns pressing down.
ENV: Final = np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
LOAD: Final = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
TIPS: Final = np.tile(LOAD, (1, 3, 1))
F_MAX: Final = np.ones(1)
PROGRAM: Final = Program(ENV, LOAD, TIPS, F_MAX, DIRECTIONS)


def passes() -> None:
    """Compile the simplex and what runs it, and what states it for several directions."""
    one, none = _tableau(), np.zeros(1, dtype=np.int64)
    target, care = simplex.Target(np.inf, 0.0, tableau.NEVER), simplex.Care(1e-9, 1e-10, False)
    simplex.search_directions(one, 1.0, target, care)
    stability.run_pass(one, 1.0, DIRECTIONS, np.zeros(len(one.raw)), False, target)
    f, force = np.zeros(1), np.ones(1, dtype=np.bool_)
    joint_margin(PROGRAM, force, none, tableau.FEASIBLE, f, np.empty((1, 6)))
    separation = Separation(LOAD, 0.0)
    equilibrium.balance(PROGRAM, separation, force, f, np.zeros(6), np.zeros(1))


def decision() -> None:
    """Compile the mode decision; all that it calls had better be there."""
    modes.decide(touching(PROGRAM), 0.0, -1, -1, certificate.NO_RECORD, np.zeros(1), np.zeros(6))


def _tableau() -> tau.Tableau:
    """Return a tableau of one finger, right-hand sides 0."""
    one = tau.new_tableau(1, len(ENV), TIPS.shape[1])
    m, N = one.raw.shape
    for room in (*one[:5], *one.found):
        room[...] = 0
    one.raw[:], one.d[0], one.basis[:] = 1.0, 1.0, np.arange(N, N + m)
    one.T[:, N : N + m] = np.eye(m)
    return one


def edges() -> None:
    """Compile what the mode decision calls beside the simplex, what is needed first first."""
    f, y, force, one = np.zeros(1), LOAD.copy(), np.ones(1, dtype=np.bool_), np.ones(1)
    raw, T, d, basis, _, _ = _tableau()
    cost = tau.fill(PROGRAM, force, f, raw)
    sides.move_tau(np.zeros(len(raw)), DIRECTIONS, T, d, basis, *raw.shape)
    sides.refactor(raw, cost, DIRECTIONS, T, d, basis)
    sides.dual_error(raw, cost, 1.0, f)
    masks = np.zeros(1, dtype=np.int64)
    modes.passing_sets(ENV, TIPS, -1, False, np.empty(2, dtype=np.int64))
    separation = certificate.separates_environment(ENV)
    _proofs(raw, cost, basis)
    certificate.proven(0.0, 1.0)
    sets = kelley.mode_sets(masks, 1)
    cuts = kelley.no_cuts(1, F_MAX, sets)
    kelley.add_cut(PROGRAM, separation, y, masks, cuts)
    kelley.settle(0, 1, sets, cuts)
    kelley.cuts_off(0, 1, cuts)
    kelley.force_control(1, force)
    trials.take_up(0, F_MAX, sets, cuts, force, f)
    kelley.heed(PROGRAM, force, one, 0, cuts)
    tau.new_work(1, _tableau())


def _proofs(raw: Array, cost: float, basis: IntArray) -> None:
    """Compile what proves z from below."""
    m = len(raw)
    found = resistance.new_resistance(m)
    for room in found:
        room[...] = 0
    resistance.lower_bound(raw, cost, DIRECTIONS, found)
    resistance.refine(raw, DIRECTIONS, found)
    resistance.refine_duals(raw, cost, basis, np.zeros(m))


def _tables(pool: CutPool) -> tuple[Tables, CutTables]:
    """Return what one finger at two placements, two nodes and an arc need; no cuts."""
    pool.reserve(1)
    yes, none = np.ones((1, 2, 1), dtype=np.bool_), np.zeros((1, 1), dtype=np.int64)
    tables = Tables(
        tail=none[0],
        head=none[0] + 1,
        kind=none[0],
        like=none[0],
        order=none[0],
        one_pass=True,
        into=none[0],
        first=np.array([0, 0, 1]),
        states=none,
        free=yes,
        lengths=np.ones((1, 2, 1, 1)),
        node_free=np.ones((1, 2, 2), dtype=np.bool_),
        goal=np.ones(2, dtype=np.bool_),
        wanted=none[0] - 1,
        ahead=np.zeros((1, 2, 2)),
        least=np.zeros(2),
        z_min=0.0,
        z_floor=1.0,
        X_stab=0.0,
        X_regr=0.0,
    )
    return tables, pool.tables


def lanes() -> None:
    """Compile what lanes need."""
    pool, rows = CutPool(np.stack([TIPS, TIPS], axis=1), F_MAX, DIRECTIONS), np.zeros(1, np.int64)
    pool.add(0, LOAD, LOAD)
    pool.bound(0, rows)
    tables, cuts = _tables(pool)
    none, z, costs, d, V = rows[None], np.ones((1, 1)), np.ones(1), np.ones(2), np.ones((1, 2))
    settle(z, tables, V.copy())
    bounds.refresh(rows, tables, cuts, z.copy(), z, costs, d)
    lane_bounds.lane_keys(none, none, V, 0, tables, cuts, np.empty(1))
    lane_bounds.hub_defaults(rows, tables, V)
    lane_bounds.best_target(0, 0.0, costs, d, (V, V.copy()), tables, d.copy())
    lane_bounds.spread(0, costs, tables, d.copy(), np.zeros(2, dtype=np.int64))
    lane_bounds.hub_rows(rows, 0, rows, rows, tables, cuts, V)
    lane_sources.merge(d[:0], none[:0], 0, 0, d, none, rows)


def cells() -> None:
    """Compile what cells of placements need; their bound on z takes the decision's simplex."""
    side, none = np.zeros((1, 1, 3, 3, 6)), np.zeros(1, dtype=np.int64)
    side[0, 0, :, 0] = TIPS
    cuts, boxes = CellCuts(side, F_MAX, DIRECTIONS), CellBoxes(np.zeros((1, 4)), none)
    cuts.widen(boxes, 1)
    cuts.add(0, LOAD, LOAD)
    tips, y = corner_columns(side, none, none, boxes), LOAD.copy()
    program, separation = PROGRAM._replace(tips=tips), Separation(LOAD, 1.0)
    cell_margin(program, separation, 0.0, y)
    corners = corner_points(np.zeros((1, 3, 3)), none, boxes)
    cell_modes.squeezed(tips[:, :, :3].copy(), corners)
    masks = cell_modes.largest_sets(1, 0)
    cell_modes.mode_margin(program, separation, 0.0, masks - masks, y)
    tables, _ = _tables(CutPool(np.stack([TIPS, TIPS], axis=1), F_MAX, DIRECTIONS))
    no, D = np.zeros((1, 1, 1), dtype=np.bool_), np.zeros((1, 2))
    room = cell_bounds.LaneRoom(none[None], np.ones((1, 1, 1)), no, np.ones((1, 1)), D)
    resting, steps = cell_bounds.RestRoom(D.copy(), no[0]), np.zeros((2, 3), dtype=np.int64)
    cell_bounds.renew_lane(0, room, tables, cuts.tables)
    cell_bounds.renew_rest(D[0], none, np.zeros(2, dtype=np.int64), cuts.tables)
    cell_bounds.to_go(none, none[:0], room, resting, tables, D, D[:0])
    cell_bounds.follow(0, none, room, tables, D, D[:0], steps)
    cell_bounds.weakest(steps[:1], none, none[:0], room, resting, tables)
    cell_bounds.least_margin(steps[:1], none, none[:0], room, resting, tables)
    cell_bounds.note(0, 0, 1.0, room, tables)
    ways = cell_narrowing.LegWays(none, D, no[0], 0, 1.0)
    cell_narrowing.useful(0, none, (0, 0), ways, room, tables, tables)


def hubs_and_routes() -> None:
    """Compile what hubs and random routes need."""
    pool, rows = CutPool(np.stack([TIPS, TIPS], axis=1), F_MAX, DIRECTIONS), np.zeros(1, np.int64)
    tables, cuts = _tables(pool)
    none, costs, d, V = rows[None], np.ones((1, 1)), np.ones((1, 2)), np.ones((1, 2))
    bounds.refresh_many(none, tables, cuts, rows, np.ones((1, 1, 1)), costs, d)
    hub_bounds.lower_hubs(none, none, tables, costs, d, np.ones((1, 2), dtype=np.bool_), V)
    bounds.reaches(none, 0, 0, tables, cuts, rows)


def sweeps() -> None:
    """Compile what swept tests need."""
    still = Sweep(Pose(np.eye(3), np.ones(3)), np.zeros(3), np.eye(3)[2], 0.0, np.zeros(3))
    cube = Body((box(np.zeros(3), np.ones(3)),))
    scene = SweptScene(Scene(cube, [cube], floor=True))
    scene.object_free(still)
    scene.free_placements(still, np.zeros((1, 3)), 0.1)


if __name__ == "__main__":
    edges()
    sys.stdout.write("\n")
    sys.stdout.flush()
    lanes()
    hubs_and_routes()
