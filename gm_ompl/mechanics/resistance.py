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
        np.empty((codes, m), dtype=np.int64), np.empty((codes, m)), np.empty(codes),
        np.empty(codes, dtype=np.int64),
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
    rows = max(m, EIGHT)
    room, end = np.zeros((N + m + 2, rows)), N + m
    A, arms, left, sums = room[:end], room[end], room[end + 1], np.empty((3, 2 * SIDES))
    for i in range(m):
        arms[i] = _longest(raw, i) if i >= 6 else 0.0
        for j in range(N):
            A[j, i] = raw[i, j]
    _add_up(A, L, found, arms, left, np.empty((2 * SIDES, rows)), sums)
    return _least(cost, sums[0], sums[1], sums[2])


@inlined
def _least(cost: float, taus: Array, squares: Array, moved: Array) -> float:
    """Return min_i (1 - |r_i|) / tau_i, or 0, from what ``_add_up`` wrote."""
    for c in range(2 * SIDES):
        error = np.sqrt(squares[c]) + moved[c]
        z = (1.0 - error) / (cost * taus[c])
        z = z if taus[c] > 0.0 else np.inf
        moved[c] = z if error < 0.5 else 0.0
    least, other = np.inf, np.inf
    for c in range(SIDES):
        least, other = min(least, moved[c]), min(other, moved[SIDES + c])
    return max(min(least, other), 0.0)


@compiled
def _add_up(
    A: Array, L: Array, found: Resistance, arms: Array, left: Array, rests: Array, sums: Array
) -> None:
    """Write, per direction, tau and how far what the solution leaves of it moves the wrench.

    All entries of a row stand in one statement, for vectors to be made of them, and in the
    variables of this function, since views of arrays are counted.

    Args:
        A: (N + m, rows), the columns as rows, of EIGHT entries or more.
        L: (76, 6), the directions.
        found: the solutions; a negative coefficient becomes 0.
        arms: (rows,), how far a wrench moves with a normal force that is put right.
        left: (rows,), zeros, for what the balance leaves.
        rests: output (76, rows), by code, what each solution leaves.
        sums: output (3, 76): tau, the square of the wrench that is left, what is left of forces.
    """
    basis, x, times, order = found
    taus, squares, moved = sums[0], sums[1], sums[2]
    K, rows, balance = x.shape[1], len(arms), np.zeros(len(A))
    one, lone = np.uint64(1), np.zeros(2 * SIDES, dtype=np.bool_)
    for i in range(2 * SIDES):
        c, s = np.uint64(order[i]), np.uint64(number(order[i]))
        opposite, n = c ^ one, times[c]
        a, b, k, d = n * left[0], n * left[1], n * left[2], n * left[3]
        e, f, g, h = n * left[4], n * left[5], n * left[6], n * left[7]
        a, b, k, d = a - L[s, 0], b - L[s, 1], k - L[s, 2], d - L[s, 3]
        e, f, tau = e - L[s, 4], f - L[s, 5], n * balance[0]
        for t in range(EIGHT, rows):
            rests[c, t] = n * left[t]
        for r in range(K):
            j = np.uint64(basis[c, r])
            y = max(x[c, r], -n * balance[j])
            x[c, r], tau = y, tau + (y if j == 0 else 0.0)
            a, b, k, d = a + y * A[j, 0], b + y * A[j, 1], k + y * A[j, 2], d + y * A[j, 3]
            e, f, g, h = e + y * A[j, 4], f + y * A[j, 5], g + y * A[j, 6], h + y * A[j, 7]
            for t in range(EIGHT, rows):
                rests[c, t] += y * A[j, t]
        rests[c, 0], rests[c, 1], rests[c, 2], rests[c, 3] = a, b, k, d
        rests[c, 4], rests[c, 5], rests[c, 6], rests[c, 7] = e, f, g, h
        taus[c], squares[c] = tau, a * a + b * b + k * k + d * d + e * e + f * f
        # A normal force too large, or not as commanded: put right, it moves the wrench.
        moved[c] = arms[6] * abs(g) + arms[7] * abs(h)
        for t in range(EIGHT, rows):
            moved[c] += arms[t] * abs(rests[c, t])
        lone[c] = not n > 0.0
        if lone[c] and lone[opposite]:
            for t in range(rows):
                left[t] += rests[c, t] + rests[opposite, t]
            for r in range(K):
                balance[np.uint64(basis[c, r])] += x[c, r]
            for r in range(K):
                balance[np.uint64(basis[opposite, r])] += x[opposite, r]


@inlined
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
