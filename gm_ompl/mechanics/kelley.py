"""Kelley's cutting planes over f_com, compiled: what they keep, and one trial.

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
from gm_ompl.mechanics.resistance import Resistance, new_resistance
from gm_ompl.mechanics.sides import width
from gm_ompl.mechanics.simplex import NO_TAU
from gm_ompl.mechanics.stability import Tableau, cut, fill, run_pass
from gm_ompl.mechanics.tableau import NEVER

MAX_CUTS = 80
"""Cuts, and"""
MAX_PASSES = 40
"""passes for one set of modes, before the directions met are put into one program."""
GAP = 1e-10
"""Cutting stops where the bound is within this of z, relative to max(z, 1e-3)."""
FRESH = 8
"""Passes on one tableau before it is filled anew: rounding adds up with every pivot."""
FIRST_LOOK = 12
"""Pivots at a trial f_com while nothing bounds z."""

UNUSED = -1
"""Stands for the first basic variable of a tableau that is not filled."""


class Cuts(NamedTuple):
    """Kelley's cuts h_P(y) z <= c + slopes . f_com, each with its form for every set of modes.

    Attributes:
        wrenches: (MAX_CUTS, 6), each y.
        h: (MAX_CUTS,), h_P(y).
        met: (MAX_CUTS,), the directions with l_i . y = h_P(y).
        c: (sets, MAX_CUTS).
        slopes: (sets, MAX_CUTS, n), a column per force-controlled finger, the rest unused.
        heeded: (sets,), how many cuts the set's bound and trial heed.
        bounds: (sets,), the largest z that they allow.
        proven: (sets,), the same, as the wrenches prove it.
        proofs: (sets, 1 + n, 6), those wrenches, weighted.
        held: (sets,), what z is at least at the f_com found.
        trials: (sets, n), f_com that allows it, an entry per force-controlled finger.
        passes: (sets,), how often a trial was put to the directions.
    """

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


class Work(NamedTuple):
    """The tableau of each set of modes, kept from pass to pass.

    Attributes:
        raw: (m, N), columns.
        T: (sets, m, W), tableaus.
        d: (sets, W), reduced costs.
        basis: (sets, m).
        tau: (sets, m), the raw tau column of the last pass.
        change: (m,), what f_com's step adds to it.
        y: (m,), duals.
        found: what resists each direction.
    """

    raw: Array
    T: Array
    d: Array
    basis: IntArray
    tau: Array
    change: Array
    y: Array
    found: Resistance


@compiled
def new_work(sets: int, n: int, e: int, s: int) -> Work:
    """Return unused tableaus for hands of n fingers, e columns of the environment."""
    m, N = 6 + n, 1 + e + n * s + n
    W = width(m, N)
    return Work(
        np.empty((m, N)), np.empty((sets, m, W)), np.empty((sets, W)),
        np.empty((sets, m), dtype=np.int64), np.empty((sets, m)), np.empty(m), np.empty(m),
        new_resistance(m),
    )  # fmt: skip


@compiled
def plant(seed: Tableau, masks: IntArray, work: Work) -> None:
    """Begin every set of modes at the basis of position control of all fingers.

    A force-controlled finger has no slack. What its slack has in the tableau is also the artificial
    variable's of its row, which takes its place in the basis; so all reduced costs stay >= 0.
    """
    m, N = seed.raw.shape
    n, W = m - 6, len(seed.d)
    for j in range(len(masks)):
        basis = work.basis[j]
        basis[0] = UNUSED
        if seed.basis[0] == UNUSED:
            continue
        for r in range(m):
            old, new = seed.T[r], work.T[j, r]
            for k in range(W):
                new[k] = old[k]
            basis[r], work.tau[j, r] = seed.basis[r], seed.raw[r, 0]
        costs = work.d[j]
        for k in range(W):
            costs[k] = seed.d[k]
        for i in range(n):
            slack = N - n + i
            if (masks[j] >> i) & 1:
                continue
            costs[slack] = 0.0
            for r in range(m):
                work.T[j, r, slack] = 0.0
                if basis[r] == slack:
                    basis[r] = N + 6 + i


@compiled
def tightest(h: Array, c: Array, slopes: Array, count: int, trial: Array) -> tuple[float, int]:
    """Return the least bound on z that the cuts give at ``trial``, and whose it is."""
    least, which = np.inf, -1
    for k in range(count):
        z = c[k]
        for j in range(len(trial)):
            z += slopes[k, j] * trial[j]
        if z / h[k] < least:
            least, which = z / h[k], k
    return least, which


@compiled
def force_control(mask: int, force: BoolArray) -> None:
    """Write who is force-controlled in a set."""
    for i in range(len(force)):
        force[i] = not (mask >> i) & 1


@compiled
def no_cuts(f_max: Array, masks: IntArray, zs: Array, commands: Array) -> Cuts:
    """Return no cuts; every set's first trial f_com is in the middle of its range.

    ``commands`` (sets, n) gets f_max: a position-controlled finger's stays at that; ``zs``
    (sets,) gets -1.
    """
    sets, n = len(masks), len(f_max)
    trials, force, bounds = np.empty((sets, n)), np.empty(n, dtype=np.bool_), np.empty(sets)
    for j in range(sets):
        force_control(masks[j], force)
        zs[j], bounds[j], nf = -1.0, np.inf, 0
        for i in range(n):
            commands[j, i] = f_max[i]
            if force[i]:
                trials[j, nf] = 0.5 * f_max[i]
                nf += 1
    return Cuts(
        np.empty((MAX_CUTS, 6)), np.empty(MAX_CUTS), np.empty(MAX_CUTS, dtype=np.int64),
        np.empty((sets, MAX_CUTS)), np.empty((sets, MAX_CUTS, n)), np.zeros(sets, dtype=np.int64),
        bounds, bounds.copy(), np.zeros((sets, 1 + n, 6)), np.zeros(sets), trials,
        np.zeros(sets, dtype=np.int64),
    )  # fmt: skip


@compiled
def take_up(
    j: int, mask: int, f_max: Array, force: BoolArray, trials: Array, commands: Array, caps: Array
) -> int:
    """Write set j's modes, trial f_com and its limits; return how many are force-controlled."""
    force_control(mask, force)
    nf = 0
    for i in range(len(force)):
        if force[i]:
            caps[nf] = f_max[i]
            commands[j, i] = trials[j, nf]
            nf += 1
    return nf


@compiled
def unit_wrench(env: Array, w: Array, margin: float, y: Array, unit: Array) -> bool:
    """Write y (6,), its largest entry 1, into the polar of the environment's cone; False for none.

    ``w`` and ``margin`` are those of ``into_polar``.
    """
    size = 0.0
    for t in range(6):
        size = max(size, abs(y[t]))
    for t in range(6):
        unit[t] = y[t] / size
    return size > NO_TAU and into_polar(env, w, margin, unit)


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
    env: Array, q: Array, tips: Array, f_max: Array, masks: IntArray, force: BoolArray, L: Array,
    w: Array, margin: float, y: Array, cuts: Cuts, K: int,
) -> bool:  # fmt: skip
    """Add y's cut as number K, for all sets, moved into the polar of the environment's cone.

    ``w`` and ``margin`` are those of ``into_polar``.

    Returns:
        False where y is nothing, so that z = +inf.
    """
    unit = cuts.wrenches[K]
    if not unit_wrench(env, w, margin, y, unit):
        return False
    cuts.h[K], cuts.met[K] = limiting_direction(L, unit)
    for j in range(len(masks)):
        force_control(masks[j], force)
        cuts.c[j, K] = cut(q, tips, f_max, force, unit, cuts.slopes[j, K])
    return True


@compiled
def heed(
    q: Array, tips: Array, f_max: Array, force: BoolArray, L: Array, caps: Array, j: int, K: int,
    cuts: Cuts,
) -> float:  # fmt: skip
    """Let set j heed K cuts: its next trial and its bound on z, which is returned.

    ``caps`` are the limits of the force-controlled fingers.
    """
    nf = len(caps)
    which, weights, Y = np.empty(1 + nf, np.int64), np.empty(1 + nf), np.zeros((1 + nf, 6))
    z = best_command(cuts.h, cuts.c[j], cuts.slopes[j], K, caps, nf, cuts.trials[j], which, weights)
    for k in range(1 + nf):
        if which[k] >= 0:
            for t in range(6):
                Y[k, t] = weights[k] * cuts.wrenches[which[k], t]
    cuts.bounds[j], cuts.heeded[j] = min(cuts.bounds[j], z), K
    U = upper_bound(q, tips, f_max, force, L, Y)
    if cuts.proven[j] > U:
        cuts.proven[j] = U
        for k in range(1 + nf):
            for t in range(6):
                cuts.proofs[j, k, t] = Y[k, t]
    return z


@inlined
def try_command(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, L: Array, j: int,
    cuts: Cuts, commands: Array, work: Work,
) -> int:  # fmt: skip
    """Try set j's f_com: SOLVED where z is proven to reach its bound, else ``work.y`` proves less.

    While nothing bounds z a look at the directions will do.
    """
    tried, bound = cuts.passes[j], cuts.bounds[j]
    cuts.passes[j] += 1
    cost = fill(env, q, tips, f_max, force, commands[j], work.raw)
    for r in range(len(work.change)):
        work.change[r] = work.raw[r, 0] - work.tau[j, r]
        work.tau[j, r] = work.raw[r, 0]
    aim = bound - GAP * max(bound, 1e-3) if bound < np.inf else 0.0
    limit, enough = (1.0 / aim, 1.0 / aim) if aim > 0.0 else (np.inf, 0.0)
    patience = NEVER if bound < np.inf else FIRST_LOOK
    warm = tried % FRESH > 0 or (tried == 0 and work.basis[j, 0] != UNUSED)
    end, _, _, cuts.held[j] = run_pass(
        work.raw, cost, L, work.T[j], work.d[j], work.basis[j], work.change, warm, limit, enough,
        patience, work.y, work.found,
    )  # fmt: skip
    return end
