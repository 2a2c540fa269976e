"""Whether any forces balance the load, compiled: what is asked where Problem (6) has no margin."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import Record, into_polar, write_down
from gm_ompl.mechanics.resistance import new_resistance
from gm_ompl.mechanics.sides import SIDES, start
from gm_ompl.mechanics.stability import BALANCED, BELOW, FAILED, REACHED, cut, fill
from gm_ompl.mechanics.tableau import CAREFUL, FEASIBLE, feasible


@compiled
def equilibrium(
    env: Array, q: Array, tips: Array, f_max: Array, L: Array, w: Array, margin: float,
    record: Record, f: Array,
) -> int:  # fmt: skip
    """Whether any forces within the limits balance the load; ``f`` (n,) gets the normal forces.

    The choice of modes does not matter: some f_com gives whatever a position-controlled finger
    would.

    Returns:
        REACHED where forces were found that do; BELOW where a wrench proves that none do; else
        FAILED.
    """
    n, y = len(tips), np.zeros((1, 6))
    end = balance(env, q, tips, f_max, np.zeros(n, dtype=np.bool_), f_max, L, w, margin, y[0], f)
    if end == BELOW:
        write_down(record, 0, (1 << n) - 1, y, new_resistance(0), False)
    return end


@compiled
def balance(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, commands: Array, L: Array,
    w: Array, margin: float, y: Array, f: Array,
) -> int:  # fmt: skip
    """Whether any forces balance the load: the tau program with tau = 1 and l = 0.

    Args:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale.
        force: (n,), whose normal force is commanded; else it is at most f_max.
        commands: (n,), f_com, where commanded.
        L: (76, 6), the directions.
        w: (6,), a wrench that separates the environment's columns, with its
        margin: see ``into_polar``.
        y: output (6,), where nothing balances the load: the wrench that proves it.
        f: output (n,), the normal forces, where something does.

    Returns:
        As ``equilibrium``.
    """
    e, n, s = len(env), len(tips), tips.shape[1]
    m, N = 6 + n, 1 + e + n * s + n
    raw, T, d = np.empty((m, N)), np.empty((m, N + m + SIDES)), np.empty(N + m + SIDES)
    basis, b, x, k = np.empty(m, dtype=np.int64), np.empty(m), np.empty(m), np.zeros(N)
    fill(env, q, tips, f_max, force, commands, raw)
    raw[:, 0] = 0.0
    for t in range(6):
        b[t] = -q[t]
    for i in range(n):
        b[6 + i] = commands[i] if force[i] else f_max[i]
    for tolerance in (FEASIBLE, CAREFUL):
        start(raw, 0.0, L, T, d, basis, m, N)
        end = feasible(T, d, basis, m, N, N + m, b, tolerance, x, y)
        proof = end == 0 and into_polar(env, w, margin, y)
        if proof and _missed(q, tips, f_max, force, commands, y) > BALANCED:
            return BELOW
        if end != 1:
            continue
        k[:] = 0.0
        for r in range(m):
            if basis[r] < N:
                k[basis[r]] = max(x[r], 0.0)
        for i in range(n):
            f[i] = 0.0
            for j in range(s):
                f[i] += k[1 + e + i * s + j]
            f[i] = min(f[i], f_max[i])
        if _unbalanced(raw, k, b) <= BALANCED:
            return REACHED
    return FAILED


@compiled
def _missed(
    q: Array, tips: Array, f_max: Array, force: BoolArray, commands: Array, y: Array
) -> float:
    """Return by how much at least any forces miss equilibrium, as y (6,) in the polar proves."""
    square, slopes, j = 0.0, np.zeros(len(tips)), 0
    work = cut(q, tips, f_max, force, y, slopes)
    for i in range(len(tips)):
        if force[i]:
            work += slopes[j] * commands[i]
            j += 1
    for t in range(6):
        square += y[t] * y[t]
    return -work / np.sqrt(square) if square > 0.0 else 0.0


@compiled
def _unbalanced(raw: Array, k: Array, b: Array) -> float:
    """Return |A k - b|, the largest of its entries."""
    worst = 0.0
    for i in range(len(b)):
        rest = -b[i]
        for j in range(len(k)):
            rest += raw[i, j] * k[j]
        worst = max(worst, abs(rest))
    return worst
