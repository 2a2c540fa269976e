"""Problem (6) with force-controlled fingers, compiled: the best f_com, for several mode sets.

Each set has its cuts on z(f_com) (Kelley's cutting planes); the set whose bound on z is largest is
taken on until no other can match what has been proven.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.blocks import MAX_BLOCKS, joint_margin
from gm_ompl.mechanics.certificate import (
    CLOSE,
    LITTLE,
    Record,
    into_polar,
    proven,
    upper_bound,
    write_down,
)
from gm_ompl.mechanics.kelley import (
    MAX_CUTS,
    MAX_PASSES,
    Cuts,
    ModeSets,
    add_cut,
    cuts_off,
    force_control,
    heed,
    no_cuts,
    settle,
)
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.mechanics.simplex import SOLVED, TROUBLE, Target
from gm_ompl.mechanics.stability import BELOW, FAILED, REACHED, UNBOUNDED, run_pass
from gm_ompl.mechanics.tableau import CAREFUL, FEASIBLE, NEVER
from gm_ompl.mechanics.tau import Tableau, fill, new_tableau, new_work
from gm_ompl.mechanics.trials import plant, take_up, try_command

ZERO = 1e-10
"""z up to this (over force_scale) is no margin at all."""
TIE = 1e-7
"""z equal within this, relatively, is a tie (convention)."""


@compiled
def _among(value: int, chosen: IntArray, count: int) -> bool:
    """Whether a value is among the first ones chosen."""
    found = False
    for i in range(count):
        found = found or chosen[i] == value
    return found


@inlined
def _last_met(cuts: Cuts, most: int, chosen: IntArray) -> int:
    """Write the last directions met, each once, the ``most`` at most; return how many."""
    count = 0 * most
    for k in range(cuts.filled[0] - 1, -1, -1):
        if count < most and not _among(cuts.met[k], chosen, count):
            chosen[count] = cuts.met[k]
            count += 1
    return count


@inlined
def _joined(
    program: Program, separation: Separation, force: BoolArray, chosen: IntArray,
    tolerance: float, f: Array, Y: Array,
) -> tuple[bool, float, float]:  # fmt: skip
    """Return whether z of the chosen directions is proven, z, and a bound on it by wrenches Y.

    The rest as for ``joint_margin``.
    """
    solved, z = joint_margin(program, force, chosen, tolerance, f, Y)
    for k in range(len(chosen)):
        solved = solved and into_polar(program.env, separation, Y[k])
    U = upper_bound(program, force, Y[: len(chosen)]) if solved else np.inf
    return solved and proven(z, max(U, 0.0)), z, U


@inlined
def _joint(
    program: Program, separation: Separation, below: float, j: int, sets: ModeSets, cuts: Cuts,
    record: Record,
) -> tuple[int, float, int, float, float]:  # fmt: skip
    """z where cutting creeps: the last directions met in one program, more as they are violated.

    Returns:
        How it ended, z, a direction, and proven bounds on z from below and from above.
    """
    n, f, mask = len(program.tips), sets.commands[j], sets.masks[j]
    tableau = new_tableau(n, len(program.env), program.tips.shape[1])
    force, chosen = np.empty(n, dtype=np.bool_), np.empty(MAX_BLOCKS, dtype=np.int64)
    Y, tolerance, count = np.empty((MAX_BLOCKS, 6)), FEASIBLE, _last_met(cuts, 1 + n, chosen)
    force_control(mask, force)
    while True:
        sure, z, U = _joined(program, separation, force, chosen[:count], tolerance, f, Y)
        direction = -1
        if sure:
            write_down(record, j, mask, Y[:count], tableau.found, False)
            if below > 0.0 and z < below:
                return BELOW, z, chosen[0], 0.0, U
            if z <= ZERO:
                return REACHED, 0.0, chosen[0], 0.0, U
            limit = (1.0 + 1e-9) / z
            cost, target = fill(program, force, f, tableau.raw), Target(limit, limit, NEVER)
            end, direction, _, v = run_pass(tableau, cost, program.L, tableau.y, False, target)
            if end == SOLVED:
                write_down(record, j, mask, Y[:count], tableau.found, True)
                return REACHED, z, direction, v, U
            sure = end != TROUBLE and count < MAX_BLOCKS and not _among(direction, chosen, count)
        if sure:
            chosen[count] = direction
            count += 1
        elif tolerance < FEASIBLE:
            return FAILED, 0.0, direction, 0.0, U
        else:
            tolerance = CAREFUL


@compiled
def next_set(zs: Array, bounds: Array, below: float) -> int:
    """Return the set to take on next: the largest bound, the preferred set in a tie.

    Sets stand in order of preference: one that at best ties with a set before it need not be
    solved. ``len(zs)`` where none needs to be.
    """
    sets, best, chosen = len(zs), -1.0, len(zs)
    for j in range(sets - 1, -1, -1):
        # Factors of two keep clear of the tie's edge; bounds are exact to much less.
        needed = zs[j] < 0.0 and bounds[j] >= below
        for i in range(sets):
            if zs[i] >= 0.0:
                least = 1.0 + 0.5 * TIE if i < j else 1.0 - 2.0 * TIE
                needed = needed and bounds[j] > zs[i] * least
        if needed and bounds[j] * (1.0 + TIE) >= best:
            best, chosen = max(best, bounds[j]), j
    return chosen


@inlined
def best_commands(
    program: Program, separation: Separation, below: float, sets: ModeSets, first: Array,
    seed: Tableau, record: Record,
) -> tuple[int, float]:  # fmt: skip
    """Find the largest z among sets of modes, each with at least one force-controlled finger.

    Args:
        program: whose z.
        separation: of the environment's columns.
        below: a threshold; where all z are proven smaller, stop.
        sets: output, with their masks.
        first: (6,), a wrench in the polar of the environment's cone whose cut may help, or zero.
        seed: the tableau of position control of all fingers, where passes begin, or UNUSED;
            changed.
        record: output, see ``Record``.

    Returns:
        REACHED (some z is at least ``below``), BELOW, UNBOUNDED or FAILED, with an upper bound on
        all z. REACHED and BELOW are proven.
    """
    n, masks, zs, f_max = len(program.tips), sets.masks, sets.zs, program.f_max
    work = new_work(len(masks), seed)
    force, caps, cuts = np.empty(n, dtype=np.bool_), np.empty(n), no_cuts(MAX_CUTS, f_max, sets)
    # Taken apart once: numba counts every use of every array of a tuple.
    filled, _, _, _, _, _, heeded, bounds, _, proofs, _, _, passes = cuts
    plant(seed, masks, work)
    add_cut(program, separation, first, masks, cuts)
    while True:
        j = next_set(zs, bounds, below)
        if j == len(masks):
            break
        nf = take_up(j, f_max, sets, cuts, force, caps)
        if heeded[j] < filled[0]:
            _heed(program, force, caps[:nf], j, sets, cuts)
        elif passes[j] == MAX_PASSES or filled[0] == MAX_CUTS:
            if _join(program, separation, below, j, sets, cuts, record) == FAILED:
                return FAILED, np.inf
        else:
            end = try_command(program, force, j, sets.commands[j], cuts, work)
            if end == TROUBLE:
                return FAILED, np.inf
            if end == SOLVED and bounds[j] < np.inf:
                write_down(record, j, masks[j], proofs[j], work.found, True)
                settle(j, nf, sets, cuts)
            elif not add_cut(program, separation, work.y, masks, cuts):
                return UNBOUNDED, np.inf
            elif not cuts_off(j, nf, cuts):
                passes[j] = MAX_PASSES
    for j in range(min(len(masks), len(record.sets))):
        if record.sets[j] < 0:
            write_down(record, j, masks[j], proofs[j], work.found, False)
    return all_proven(zs, cuts, below)


@inlined
def _join(
    program: Program, separation: Separation, below: float, j: int, sets: ModeSets, cuts: Cuts,
    record: Record,
) -> int:  # fmt: skip
    """Find set j's z by ``_joint``, unless it is worse than what is known; return how it ended."""
    least = max(below, sets.zs.max() * (1.0 - 2.0 * TIE))
    end, cuts.bounds[j], sets.limiting[j], cuts.held[j], cuts.proven[j] = _joint(
        program, separation, least, j, sets, cuts, record
    )
    if end == REACHED:
        sets.zs[j] = cuts.bounds[j]
    return end


@inlined
def _heed(
    program: Program, force: BoolArray, caps: Array, j: int, sets: ModeSets, cuts: Cuts
) -> None:
    """Let set j heed all cuts; where they leave it no margin, that may be its z."""
    z = heed(program, force, caps, j, cuts)
    if z <= ZERO and proven(0.0, max(cuts.proven[j], 0.0)):
        sets.zs[j], cuts.bounds[j], sets.limiting[j] = 0.0, 0.0, cuts.met[cuts.filled[0] - 1]
    elif z <= ZERO:  # rounding: the joint program must tell
        cuts.passes[j], cuts.bounds[j] = MAX_PASSES, cuts.proven[j]


@inlined
def all_proven(zs: Array, cuts: Cuts, below: float) -> tuple[int, float]:
    """Return how the search over sets ended, if every set is proven to be what it is taken for.

    That is: as good as the best within a tie, where it may be chosen; no better, else.
    """
    top = zs.max()
    bound, most = 0.0, top + TIE * top + CLOSE * max(top, LITTLE)
    for j in range(len(zs)):
        bound = max(bound, cuts.proven[j])
    if top < below:
        return BELOW if bound < below else FAILED, bound
    sure = bound <= most
    for j in range(len(zs)):
        if zs[j] > 0.0 and zs[j] >= top * (1.0 - TIE):
            sure = sure and proven(cuts.held[j], zs[j])
    return REACHED if sure else FAILED, bound
