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
    GAP,
    MAX_CUTS,
    MAX_PASSES,
    add_cut,
    heed,
    new_work,
    no_cuts,
    plant,
    take_up,
    tightest,
    try_command,
)
from gm_ompl.mechanics.resistance import new_resistance
from gm_ompl.mechanics.sides import SIDES
from gm_ompl.mechanics.simplex import SOLVED, TROUBLE
from gm_ompl.mechanics.stability import (
    BELOW,
    FAILED,
    REACHED,
    UNBOUNDED,
    Tableau,
    fill,
    run_pass,
)
from gm_ompl.mechanics.tableau import CAREFUL, FEASIBLE, NEVER

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
def _joint(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, L: Array, below: float,
    met: IntArray, w: Array, margin: float, j: int, mask: int, record: Record, f: Array,
) -> tuple[int, float, int, float, float]:  # fmt: skip
    """z where cutting creeps: the last directions met in one program, more as they are violated.

    Returns:
        How it ended, z, a direction, and proven bounds on z from below and from above.
    """
    n, s = len(tips), tips.shape[1]
    m, N = 6 + n, 1 + len(env) + n * s + n
    raw, T, d = np.empty((m, N)), np.empty((m, N + m + SIDES)), np.empty(N + m + SIDES)
    basis, y, found = np.empty(m, dtype=np.int64), np.empty(m), new_resistance(m)
    chosen, count = np.empty(MAX_BLOCKS, dtype=np.int64), 0 * m
    Y, tolerance = np.empty((MAX_BLOCKS, 6)), FEASIBLE
    for K in range(len(met) - 1, -1, -1):
        if count < 1 + n and not _among(met[K], chosen, count):
            chosen[count] = met[K]
            count += 1
    while True:
        solved, z = joint_margin(env, q, tips, f_max, force, L, chosen, count, tolerance, f, Y)
        for k in range(count):
            solved = solved and into_polar(env, w, margin, Y[k])
        U = upper_bound(q, tips, f_max, force, L, Y[:count]) if solved else np.inf
        if not (solved and proven(z, max(U, 0.0))):
            if tolerance < FEASIBLE:
                return FAILED, 0.0, -1, 0.0, np.inf
            tolerance = CAREFUL
            continue
        write_down(record, j, mask, Y[:count], found, False)
        if below > 0.0 and z < below:
            return BELOW, z, chosen[0], 0.0, U
        if z <= ZERO:
            return REACHED, 0.0, chosen[0], 0.0, U
        cost = fill(env, q, tips, f_max, force, f, raw)
        limit = (1.0 + 1e-9) / z
        end, direction, _, v = run_pass(
            raw, cost, L, T, d, basis, y, False, limit, limit, NEVER, y, found
        )
        if end == SOLVED:
            write_down(record, j, mask, Y[:count], found, True)
            return REACHED, z, direction, v, U
        if end == TROUBLE or count == MAX_BLOCKS or _among(direction, chosen, count):
            if tolerance < FEASIBLE:
                return FAILED, 0.0, direction, 0.0, U
            tolerance = CAREFUL
            continue
        chosen[count] = direction
        count += 1


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
    env: Array, q: Array, tips: Array, f_max: Array, L: Array, below: float, masks: IntArray,
    first: Array, w: Array, margin: float, seed: Tableau, record: Record, zs: Array,
    limiting: IntArray, commands: Array,
) -> tuple[int, float]:  # fmt: skip
    """Find the largest z among sets of modes, each with at least one force-controlled finger.

    Args:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale.
        L: (76, 6), the directions.
        below: a threshold; where all z are proven smaller, stop.
        masks: (sets,), position-controlled fingers as bits, in order of preference.
        first: (6,), a wrench in the polar of the environment's cone whose cut may help, or zero.
        w: (6,), a wrench that separates the environment's columns, with its
        margin: see ``into_polar``.
        seed: the tableau of position control of all fingers, where passes begin, or UNUSED.
        record: output, see ``Record``.
        zs: output (sets,): z where it may be the largest or tie with it, else -1.
        limiting: output (sets,): the directions that limit z.
        commands: output (sets, n): f_com; f_max under position control.

    Returns:
        REACHED (some z is at least ``below``), BELOW, UNBOUNDED or FAILED, with an upper bound on
        all z. REACHED and BELOW are proven.
    """
    sets, n, top = len(masks), len(tips), -1.0
    work, cuts = new_work(sets, n, len(env), tips.shape[1]), no_cuts(f_max, masks, zs, commands)
    force, caps, K = np.empty(n, dtype=np.bool_), np.empty(n), 0
    plant(seed, masks, work)
    if add_cut(env, q, tips, f_max, masks, force, L, w, margin, first, cuts, 0):
        K = 1
    while True:
        j = next_set(zs, cuts.bounds, below)
        if j == sets:
            break
        nf = take_up(j, masks[j], f_max, force, cuts.trials, commands, caps)
        if cuts.heeded[j] < K:
            z = heed(q, tips, f_max, force, L, caps[:nf], j, K, cuts)
            if z <= ZERO and proven(0.0, max(cuts.proven[j], 0.0)):
                zs[j], cuts.bounds[j], limiting[j], top = 0.0, 0.0, cuts.met[K - 1], max(top, 0.0)
            elif z <= ZERO:  # rounding: the joint program must tell
                cuts.passes[j], cuts.bounds[j] = MAX_PASSES, cuts.proven[j]
        elif cuts.passes[j] == MAX_PASSES or K == MAX_CUTS:
            end, cuts.bounds[j], limiting[j], cuts.held[j], cuts.proven[j] = _joint(
                env, q, tips, f_max, force, L, max(below, top * (1.0 - 2.0 * TIE)), cuts.met[:K],
                w, margin, j, masks[j], record, commands[j],
            )  # fmt: skip
            if end == FAILED:
                return FAILED, np.inf
            if end == REACHED:
                zs[j], top = cuts.bounds[j], max(top, cuts.bounds[j])
        else:
            end = try_command(env, q, tips, f_max, force, L, j, cuts, commands, work)
            if end == TROUBLE:
                return FAILED, np.inf
            if end == SOLVED and cuts.bounds[j] < np.inf:
                write_down(record, j, masks[j], cuts.proofs[j], work.found, True)
                z, which = tightest(cuts.h, cuts.c[j], cuts.slopes[j], K, cuts.trials[j, :nf])
                zs[j] = min(max(z, cuts.held[j]), cuts.proven[j])
                limiting[j], top = cuts.met[which], max(top, zs[j])
            elif not add_cut(env, q, tips, f_max, masks, force, L, w, margin, work.y, cuts, K):
                return UNBOUNDED, np.inf
            else:
                K += 1
                z, _ = tightest(cuts.h, cuts.c[j], cuts.slopes[j], K, cuts.trials[j, :nf])
                if z > cuts.bounds[j] - GAP * max(cuts.bounds[j], 1e-3):  # it cuts nothing off
                    cuts.passes[j] = MAX_PASSES
    for j in range(min(sets, len(record.sets))):
        if record.sets[j] < 0:
            write_down(record, j, masks[j], cuts.proofs[j], work.found, False)
    return all_proven(zs, cuts.proven, cuts.held, top, below)


@inlined
def all_proven(
    zs: Array, ceilings: Array, held: Array, top: float, below: float
) -> tuple[int, float]:
    """Return how the search over sets ended, if every set is proven to be what it is taken for.

    ``ceilings`` (sets,) bound their z, ``held`` (sets,) is what z is at least at the f_com found.
    That is: as good as ``top`` within a tie, where it may be chosen; no better, else.
    """
    bound, most = 0.0, top + TIE * top + CLOSE * max(top, LITTLE)
    for j in range(len(zs)):
        bound = max(bound, ceilings[j])
    if top < below:
        return BELOW if bound < below else FAILED, bound
    sure = bound <= most
    for j in range(len(zs)):
        if zs[j] > 0.0 and zs[j] >= top * (1.0 - TIE):
            sure = sure and proven(held[j], zs[j])
    return REACHED if sure else FAILED, bound
