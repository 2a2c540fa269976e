"""Kelley's cutting planes over f_com, compiled.

The method: Kelley, The cutting-plane method for solving convex programs, J. SIAM 8, 1960,
doi:10.1137/0108053.

Infeasible directions give cuts as well (with a right-hand side <= 0 at the trial point), so thin
ranges of feasible f_com need no special care.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.certificate import into_polar, upper_bound
from gm_ompl.mechanics.master import best_command
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.mechanics.simplex import NO_TAU
from gm_ompl.mechanics.stability import cut

MAX_CUTS = 80
"""Cuts, and"""
MAX_PASSES = 40
"""passes for one set of modes, before the directions met are put into one program."""
GAP = 1e-10
"""Cutting stops where the bound is within this of z, relative to max(z, 1e-3)."""


class ModeSets(NamedTuple):
    """Sets of modes to choose from, and what is found about them.

    Attributes:
        masks: (sets,), position-controlled fingers as bits, in order of preference.
        zs: (sets,), z where it may be the largest or tie with it, else -1.
        limiting: (sets,), the directions that limit z.
        commands: (sets, n), f_com; the largest command under position control.
    """

    masks: IntArray
    zs: Array
    limiting: IntArray
    commands: Array


class Cuts(NamedTuple):
    """Kelley's cuts h_P(y) z <= c + slopes . f_com, each with its form for every set of modes.

    Attributes:
        filled: (1,), how many of the K places are taken.
        wrenches: (K, 6), each y.
        h: (K,), h_P(y).
        met: (K,), the directions with l_i . y = h_P(y).
        c: (sets, K).
        slopes: (sets, K, n), a column per force-controlled finger, the rest unused.
        heeded: (sets,), how many cuts the set's bound and trial heed.
        bounds: (sets,), the largest z that they allow.
        proven: (sets,), the same, as the wrenches prove it.
        proofs: (sets, 1 + n, 6), those wrenches, weighted.
        held: (sets,), what z is at least at the f_com found.
        trials: (sets, n), f_com that allows it, an entry per force-controlled finger.
        passes: (sets,), how often a trial was put to the directions.
    """

    filled: IntArray
    wrenches: Array
    h: Array
    met: IntArray
    c: Array
    slopes: Array
    heeded: IntArray
    bounds: Array
    proven: Array
    proofs: Array
    held: Array
    trials: Array
    passes: IntArray


@compiled
def force_control(mask: int, force: BoolArray) -> None:
    """Write who is force-controlled in a set."""
    for i in range(len(force)):
        force[i] = not (mask >> i) & 1


@compiled
def mode_sets(masks: IntArray, n: int) -> ModeSets:
    """Return sets of modes (sets,) of n fingers, of which nothing is known."""
    sets = len(masks)
    return ModeSets(masks, np.empty(sets), np.empty(sets, dtype=np.int64), np.empty((sets, n)))


@compiled
def no_cuts(K: int, most: Array, sets: ModeSets) -> Cuts:
    """Return room for K cuts; every set's first trial f_com is half of the most (n,).

    ``commands`` get the most: a position-controlled finger's stays at that; ``zs`` get -1.
    """
    count, n = len(sets.masks), len(most)
    trials, force = np.empty((count, n)), np.empty(n, dtype=np.bool_)
    # In one piece each: to ask for room takes longer than to fill it.
    counts, levels = np.zeros(1 + 2 * count, dtype=np.int64), np.zeros(3 * count + K)
    bounds, ceilings, rest = levels[:count], levels[count : 2 * count], levels[2 * count :]
    for j in range(count):
        force_control(sets.masks[j], force)
        sets.zs[j], bounds[j], ceilings[j], nf = -1.0, np.inf, np.inf, 0
        for i in range(n):
            sets.commands[j, i] = most[i]
            if force[i]:
                trials[j, nf] = 0.5 * most[i]
                nf += 1
    return Cuts(
        counts[:1], np.empty((K, 6)), rest[count:], np.empty(K, dtype=np.int64),
        np.empty((count, K)), np.empty((count, K, n)), counts[1 : 1 + count],
        bounds, ceilings, np.zeros((count, 1 + n, 6)),
        rest[:count], trials, counts[1 + count :],
    )  # fmt: skip


@inlined
def tightest(j: int, nf: int, cuts: Cuts) -> tuple[float, int]:
    """Return the least bound on z that the cuts give at set j's trial, and whose it is."""
    least, which = np.inf, -1
    for k in range(cuts.filled[0]):
        z = cuts.c[j, k]
        for i in range(nf):
            z += cuts.slopes[j, k, i] * cuts.trials[j, i]
        if z / cuts.h[k] < least:
            least, which = z / cuts.h[k], k
    return least, which


@compiled
def settle(j: int, nf: int, sets: ModeSets, cuts: Cuts) -> None:
    """Write set j's z and what limits it: its trial reaches the bound."""
    z, which = tightest(j, nf, cuts)
    sets.zs[j] = min(max(z, cuts.held[j]), cuts.proven[j])
    sets.limiting[j] = cuts.met[which]


@compiled
def cuts_off(j: int, nf: int, cuts: Cuts) -> bool:
    """Whether the cuts exclude set j's trial, as the last one should."""
    bound = cuts.bounds[j]
    return not tightest(j, nf, cuts)[0] > bound - GAP * max(bound, 1e-3)


@compiled
def unit_wrench(env: Array, separation: Separation, y: Array, unit: Array) -> bool:
    """Write y (6,), its largest entry 1, into the polar of the environment's cone; False for none.

    ``separation`` is that of the environment's columns.
    """
    size = 0.0
    for t in range(6):
        size = max(size, abs(y[t]))
    for t in range(6):
        unit[t] = y[t] / size
    return size > NO_TAU and into_polar(env, separation, unit)


@compiled
def limiting_direction(L: Array, y: Array) -> tuple[float, int]:
    """Return h = max_i l_i . y over the directions, 0 at least, and an i that has it."""
    h, met = 0.0, 0
    for i in range(len(L)):
        dot = 0.0
        for t in range(6):
            dot += L[i, t] * y[t]
        if dot > h:
            h, met = dot, i
    return h, met


@compiled
def add_cut(
    program: Program, separation: Separation, y: Array, masks: IntArray, cuts: Cuts
) -> bool:
    """Add y's cut, for all sets, moved into the polar of the environment's cone.

    Returns:
        False where y is nothing, so that z = +inf.
    """
    force, K = np.empty(len(program.tips), dtype=np.bool_), cuts.filled[0]
    unit = cuts.wrenches[K]
    if not unit_wrench(program.env, separation, y, unit):
        return False
    cuts.h[K], cuts.met[K] = limiting_direction(program.L, unit)
    for j in range(len(masks)):
        force_control(masks[j], force)
        cuts.c[j, K] = cut(program, force, unit, cuts.slopes[j, K])
    cuts.filled[0] = K + 1
    return True


@inlined
def next_trial(j: int, caps: Array, cuts: Cuts, which: IntArray, weights: Array) -> float:
    """Write the f_com with the largest z under all cuts as set j's trial, and return that z.

    ``caps`` (nf,) are the limits of the force-controlled fingers; ``which`` and ``weights``
    (1 + nf,) get the cuts that prove it, see ``best_command``.
    """
    K = cuts.filled[0]
    z = best_command(
        cuts.h[:K], cuts.c[j, :K], cuts.slopes[j, :K], caps, cuts.trials[j], which, weights
    )
    cuts.bounds[j], cuts.heeded[j] = min(cuts.bounds[j], z), K
    return z


@compiled
def heed(program: Program, force: BoolArray, caps: Array, j: int, cuts: Cuts) -> float:
    """Let set j heed all cuts: its next trial and its bound on z, which is returned.

    ``caps`` are the limits of the force-controlled fingers.
    """
    nf = len(caps)
    which, weights, Y = np.empty(1 + nf, np.int64), np.empty(1 + nf), np.zeros((1 + nf, 6))
    z = next_trial(j, caps, cuts, which, weights)
    for k in range(1 + nf):
        if which[k] >= 0:
            for t in range(6):
                Y[k, t] = weights[k] * cuts.wrenches[which[k], t]
    U = upper_bound(program, force, Y)
    if cuts.proven[j] > U:
        cuts.proven[j] = U
        for k in range(1 + nf):
            for t in range(6):
                cuts.proofs[j, k, t] = Y[k, t]
    return z
