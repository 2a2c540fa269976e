"""Whether any forces balance the load, compiled: what is asked where Problem (6) has no margin."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.certificate import Record, into_polar, write_down
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.mechanics.resistance import new_resistance
from gm_ompl.mechanics.sides import fill_in
from gm_ompl.mechanics.stability import BALANCED, BELOW, FAILED, REACHED, cut
from gm_ompl.mechanics.tableau import CAREFUL, FEASIBLE, feasible
from gm_ompl.mechanics.tau import fill


@inlined
def equilibrium(program: Program, separation: Separation, record: Record, f: Array) -> int:
    """Whether any forces within the limits balance the load; ``f`` (n,) gets the normal forces.

    The choice of modes does not matter: some f_com gives whatever a position-controlled finger
    would.

    Returns:
        REACHED where forces were found that do; BELOW where a wrench proves that none do; else
        FAILED.
    """
    n, y = len(program.tips), np.zeros((1, 6))
    end = balance(program, separation, np.zeros(n, dtype=np.bool_), program.f_max, y[0], f)
    if end == BELOW:
        write_down(record, 0, (1 << n) - 1, y, new_resistance(0), False)
    return end


@compiled
def balance(
    program: Program, separation: Separation, force: BoolArray, commands: Array, y: Array, f: Array
) -> int:
    """Whether any forces balance the load: the tau program with tau = 1 and l = 0.

    Args:
        program: whose load and forces.
        separation: of the environment's columns.
        force: (n,), whose normal force is commanded; else it is at most f_max.
        commands: (n,), f_com, where commanded.
        y: output (6,), where nothing balances the load: the wrench that proves it.
        f: output (n,), the normal forces, where something does.

    Returns:
        As ``equilibrium``.
    """
    e, n, s = len(program.env), len(program.tips), program.tips.shape[1]
    m, N = 6 + n, 1 + e + n * s + n
    raw, T, d = np.empty((m, N)), np.empty((m, N + m)), np.empty(N + m)
    basis, b, x, k = np.empty(m, dtype=np.int64), np.empty(m), np.empty(m), np.zeros(N)
    fill(program, force, commands, raw)
    raw[:, 0] = 0.0
    for t in range(6):
        b[t] = -program.q[t]
    for i in range(n):
        b[6 + i] = commands[i] if force[i] else program.f_max[i]
    for tolerance in (FEASIBLE, CAREFUL):
        fill_in(raw, 0.0, T, d, basis)
        end = feasible(T, d, basis, b, tolerance, x, y)
        proof = end == 0 and into_polar(program.env, separation, y)
        if proof and _missed(program, force, commands, y) > BALANCED:
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
            f[i] = min(f[i], program.f_max[i])
        if _unbalanced(raw, k, b) <= BALANCED:
            return REACHED
    return FAILED


@inlined
def _missed(program: Program, force: BoolArray, commands: Array, y: Array) -> float:
    """Return by how much at least any forces miss equilibrium, as y (6,) in the polar proves."""
    square, slopes, j = 0.0, np.zeros(len(force)), 0
    work = cut(program, force, y, slopes)
    for i in range(len(force)):
        if force[i]:
            work += slopes[j] * commands[i]
            j += 1
    for t in range(6):
        square += y[t] * y[t]
    return -work / np.sqrt(square) if square > 0.0 else 0.0


@inlined
def _unbalanced(raw: Array, k: Array, b: Array) -> float:
    """Return |A k - b|, the largest of its entries."""
    worst = 0.0
    for i in range(len(b)):
        rest = -b[i]
        for j in range(len(k)):
            rest += raw[i, j] * k[j]
        worst = max(worst, abs(rest))
    return worst
