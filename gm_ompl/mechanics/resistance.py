"""What resists each of the 76 directions for one f_com, compiled, and the z that it proves.

Solutions of tau_i q + A k_i = l_i up to a residual r_i prove z >= v, v = min_i (1 - |r_i|) / tau_i:
the wrenches that can be resisted form a convex set with the points (l_i + r_i) / tau_i. In any
direction u some l_i has l_i . u >= |u|, so the set reaches at least as far as v max_i l_i . u.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.sides import SIDES, number

EIGHT = 8
"""Rows that are done at a time: those of one or two fingers."""
SINGULAR = 1e-12
"""A pivot up to this is none; columns have norms of order 1."""


class Resistance(NamedTuple):
    """What resists each direction, by code: a basic solution, and a multiple of the balance.

    The balance (right-hand side 0) is the sum of the solutions that were kept without it and whose
    opposites were, too. It grows; a direction is kept with the balance of that moment.

    Attributes:
        basis: (76, m), columns, those of artificial variables from N on.
        x: (76, m), their coefficients.
        times: (76,), the multiple of the balance.
        order: (76,), codes in the order in which they were kept.
    """

    basis: IntArray
    x: Array
    times: Array
    order: IntArray


@compiled
def new_resistance(m: int) -> Resistance:
    """Return room for the solutions of a tau program with m rows."""
    codes = 2 * SIDES
    return Resistance(
        np.zeros((codes, m), dtype=np.int64), np.empty((codes, m)), np.empty(codes),
        np.zeros(codes, dtype=np.int64),
    )  # fmt: skip


@compiled
def factored(raw: Array, columns: IntArray, B: Array, order: IntArray) -> bool:
    """Write the LU factors (m, m) of basic columns and their rows' order; False if singular."""
    m, N = raw.shape
    for r in range(m):
        order[r] = r
        for t in range(m):
            B[t, r] = raw[t, columns[r]] if columns[r] < N else 0.0
        if columns[r] >= N:
            B[columns[r] - N, r] = 1.0
    for r in range(m):
        best = r
        for t in range(r + 1, m):
            best = t if abs(B[t, r]) > abs(B[best, r]) else best
        if not abs(B[best, r]) > SINGULAR:
            return False
        order[r], order[best] = order[best], order[r]
        for k in range(m):
            B[r, k], B[best, k] = B[best, k], B[r, k]
        for t in range(r + 1, m):
            B[t, r] /= B[r, r]
            for k in range(r + 1, m):
                B[t, k] -= B[t, r] * B[r, k]
    return True


@compiled
def refine(raw: Array, L: Array, found: Resistance) -> None:
    """Solve each direction's basis anew: the tableau carries the rounding of all its pivots.

    Large coefficients that cancel almost need it.
    """
    m = len(raw)
    B, order, x = np.empty((m, m)), np.empty(m, dtype=np.int64), np.empty(m)
    for c in found.order:
        if not factored(raw, found.basis[c], B, order):
            continue
        for r in range(m):
            x[r] = L[number(c), order[r]] if order[r] < 6 else 0.0
            for k in range(r):
                x[r] -= B[r, k] * x[k]
        for r in range(m - 1, -1, -1):
            for k in range(r + 1, m):
                x[r] -= B[r, k] * x[k]
            x[r] /= B[r, r]
        for r in range(m):
            found.x[c, r] = x[r]


@compiled
def refine_duals(raw: Array, cost: float, columns: IntArray, y: Array) -> None:
    """Solve for the duals y (m,) of a basis anew, see ``refine``."""
    m = len(raw)
    B, order, u = np.empty((m, m)), np.empty(m, dtype=np.int64), np.empty(m)
    if not factored(raw, columns, B, order):
        return
    for r in range(m):
        u[r] = cost if columns[r] == 0 else 0.0
        for k in range(r):
            u[r] -= B[k, r] * u[k]
        u[r] /= B[r, r]
    for r in range(m - 1, -1, -1):
        for k in range(r + 1, m):
            u[r] -= B[k, r] * u[k]
    for r in range(m):
        y[order[r]] = u[r]


@compiled
def lower_bound(raw: Array, cost: float, L: Array, found: Resistance) -> float:
    """Return v <= z for one f_com, see the top; 0 where the solutions prove nothing.

    A coefficient that is negative counts as 0. All is added up anew, the balance too.

    Args:
        raw: (m, N), the tau program's columns.
        cost: of the tau column: tau = cost times its variable.
        L: (76, 6), the directions.
        found: the solutions, of all directions.
    """
    m, N = raw.shape
    K, rows = found.x.shape[1], max(m, EIGHT)
    A, rests = np.zeros((N + m, rows)), np.zeros((2 * SIDES, rows))
    balance, left, arms = np.zeros(N + m), np.zeros(rows), np.zeros(rows)
    seen, least = np.zeros(2 * SIDES, dtype=np.bool_), np.inf
    for i in range(m):
        arms[i] = _longest(raw, i) if i >= 6 else 0.0
        for j in range(N):
            A[j, i] = raw[i, j]
    for c in found.order:
        columns, x, times = found.basis[c], found.x[c], found.times[c]
        tau = times * balance[0]
        for r in range(K):
            x[r] = max(x[r], -times * balance[columns[r]])
            tau += x[r] if columns[r] == 0 else 0.0
        error = _rest(A, L[number(c)], columns, x, left, times, arms, rests[c])
        z = (1.0 - error) / (cost * tau) if tau > 0.0 else np.inf
        least = min(least, z if error < 0.5 else 0.0)
        seen[c] = not times > 0.0
        if seen[c] and seen[c ^ 1]:
            for k in range(2):
                for r in range(K):
                    balance[found.basis[c ^ k, r]] += found.x[c ^ k, r]
                for t in range(rows):
                    left[t] += rests[c ^ k, t]
    return max(least, 0.0)


@inlined
def _rest(
    A: Array, side: Array, columns: IntArray, x: Array, left: Array, times: float, arms: Array,
    rest: Array,
) -> float:  # fmt: skip
    """Write what a solution leaves of its side, per row; return how far that moves the wrench.

    ``A`` are columns as rows, of EIGHT entries or more; ``left`` is what the balance leaves.
    """
    a, b, c, d = times * left[0], times * left[1], times * left[2], times * left[3]
    e, f, g, h = times * left[4], times * left[5], times * left[6], times * left[7]
    a, b, c, d, e, f = a - side[0], b - side[1], c - side[2], d - side[3], e - side[4], f - side[5]
    for t in range(EIGHT, len(rest)):
        rest[t] = times * left[t]
    for r in range(len(x)):
        column, k = A[columns[r]], x[r]
        a, b, c, d = a + k * column[0], b + k * column[1], c + k * column[2], d + k * column[3]
        e, f, g, h = e + k * column[4], f + k * column[5], g + k * column[6], h + k * column[7]
        for t in range(EIGHT, len(rest)):
            rest[t] += k * column[t]
    rest[0], rest[1], rest[2], rest[3] = a, b, c, d
    rest[4], rest[5], rest[6], rest[7] = e, f, g, h
    moved = np.sqrt(a * a + b * b + c * c + d * d + e * e + f * f)
    for t in range(6, len(rest)):
        # A normal force too large, or not as commanded: put right, it moves the wrench.
        moved += arms[t] * abs(rest[t])
    return moved


@compiled
def _longest(raw: Array, i: int) -> float:
    """Return the norm of the longest wrench among the columns with an entry 1 in row i."""
    best = 0.0
    for j in range(1, raw.shape[1]):
        if raw[i, j] == 1.0:
            square = 0.0
            for t in range(6):
                square += raw[t, j] * raw[t, j]
            best = max(best, square)
    return np.sqrt(best)


@compiled
def written_out(found: Resistance, solutions: Array) -> None:
    """Write the solutions (N, 76), by code, all coefficients of a direction in a column."""
    N = len(solutions)
    balance, seen = np.zeros(N), np.zeros(2 * SIDES, dtype=np.bool_)
    for c in found.order:
        for j in range(N):
            solutions[j, c] = found.times[c] * balance[j]
        for r in range(found.x.shape[1]):
            if found.basis[c, r] < N:
                solutions[found.basis[c, r], c] += found.x[c, r]
        seen[c] = not found.times[c] > 0.0
        for j in range(N):
            solutions[j, c] = max(solutions[j, c], 0.0)
            if seen[c] and seen[c ^ 1]:
                balance[j] += solutions[j, c] + solutions[j, c ^ 1]
