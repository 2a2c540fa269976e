"""z_strong for given modes and commands: the least disturbance under which contacts give way.

For given ways of all contacts (``deviations``) the least disturbance t that forces balance is

    t = min sum_i w_i  subject to  q + sum_i w_i l_i + A k = 0,  per finger sum_k = f, w, k >= 0

(<= f_max under position control), with the edges that the ways let press; z_strong is the least of
z and all t. Branch and bound over the contacts: where some are not told yet, all their edges may
press, which bounds t from below. Telling one more bars columns, so that a tableau that was optimal
stays dual feasible: a few pivots renew it, and stop where t is large enough.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.deviations import (
    CORNER,
    OPEN,
    STICKS,
    UNTOLD,
    ContactRows,
    deviates,
    last_way,
    presses,
)
from gm_ompl.mechanics.tableau import FEASIBLE, PIVOT, pivot

CLOSER: Final = 1e-9
"""By how much less, over M g, contacts must give way otherwise to be told so."""

MOST_PIVOTS: Final = 600
"""Until one bound is taken as it is: it only grows on the way."""


@compiled
def _renew(
    T: Array, d: Array, basis: IntArray, m: int, N: int, allowed: BoolArray, beyond: float
) -> float:
    """Return t with the ``allowed`` (N,) columns; +inf for none, or some t >= ``beyond``."""
    last = N + m
    for _ in range(MOST_PIVOTS):
        if -d[last] >= beyond:
            return -d[last]
        size, worst, row = 1.0, 0.0, -1
        for r in range(m):
            x = T[r, last]
            size = max(size, abs(x))
            barred = basis[r] >= N or not allowed[basis[r]]
            excess = abs(x) if barred else -x
            if excess > worst:
                worst, row = excess, r
        if worst <= FEASIBLE * size:
            break
        sign = 1.0 if T[row, last] < 0.0 else -1.0
        nearest, steepest, column = np.inf, 0.0, -1
        for j in range(N):
            if allowed[j]:
                alpha = -sign * T[row, j]
                if alpha > PIVOT:
                    nearest = min(nearest, (d[j] + 1e-12) / alpha)
        for j in range(N):
            if allowed[j]:
                alpha = -sign * T[row, j]
                if alpha > max(PIVOT, steepest) and d[j] <= nearest * alpha:
                    steepest, column = alpha, j
        if column < 0:
            return np.inf
        pivot(T, d, basis, m, last + 1, row, column)
    return max(-d[last], 0.0) + 0.0


@compiled
def _begin(
    contacts: ContactRows, n: int, q: Array, f: Array, directions: Array, T: Array, d: Array,
    basis: IntArray,
) -> None:  # fmt: skip
    """Write the tableau with all variables out of the basis."""
    K, C, m = len(directions), len(contacts.columns), 6 + n
    N = K + C + n
    T[:], d[:] = 0.0, 0.0
    d[:K] = 1.0
    for t in range(6):
        for k in range(K):
            T[t, k] = directions[k, t]
        for j in range(C):
            T[t, K + j] = contacts.columns[j, t]
        T[t, N + m] = -q[t]
    for i in range(n):
        for j in range(contacts.first[i], contacts.first[i + 1]):
            T[6 + i, K + j] = 1.0
        T[6 + i, K + C + i], T[6 + i, N + m] = 1.0, f[i]
    for r in range(m):
        basis[r], T[r, N + r] = N + r, 1.0


@compiled
def _all_allowed(contacts: ContactRows, n: int, K: int) -> BoolArray:
    """Return the columns that may be used where nothing is told: no slack of a command."""
    C = len(contacts.columns)
    allowed = np.ones(K + C + n, dtype=np.bool_)
    for i in range(n):
        allowed[K + C + i] = contacts.one_sided[i]
    return allowed


@compiled
def least_for(
    contacts: ContactRows, n: int, q: Array, f: Array, directions: Array, ways: IntArray,
    beyond: float,
) -> float:  # fmt: skip
    """Return t for the given ways (c,) of all contacts, or some t >= ``beyond``.

    The rest as for ``gives_way``; whether a deviation goes with them is not asked.
    """
    K, C, m = len(directions), len(contacts.columns), 6 + n
    N = K + C + n
    T, d, basis = np.empty((m, N + m + 1)), np.empty(N + m + 1), np.empty(m, dtype=np.int64)
    _begin(contacts, n, q, f, directions, T, d, basis)
    allowed = _all_allowed(contacts, n, K)
    for i in range(len(ways)):
        presses(contacts, i, ways[i], allowed[K : K + C])
    return _renew(T, d, basis, m, N, allowed, beyond)


@compiled
def _unmoved(T: Array, basis: IntArray, m: int, N: int, allowed: BoolArray) -> bool:
    """Whether a basic solution uses allowed columns alone."""
    for r in range(m):
        if basis[r] < N and not allowed[basis[r]] and T[r, N + m] != 0.0:
            return False
    return True


@compiled
def gives_way(
    contacts: ContactRows, n: int, q: Array, f: Array, directions: Array, z: float, enough: float,
    found: IntArray,
) -> float:  # fmt: skip
    """Return z_strong; forces over M g.

    Args:
        contacts: fingertips first, as their modes are.
        n: how many of them are fingertips.
        q: (6,), the load.
        f: (n,), f_com of force-controlled fingers, f_max of others.
        directions: (76, 6), the l_i.
        z: of Problem (6), for these modes and commands.
        enough: where z_strong is at most this, it need not be known any better.
        found: output (c,), what contacts do at z_strong; UNTOLD where none gives way below z.
    """
    K, C, c, m = len(directions), len(contacts.columns), len(contacts.normal), 6 + n
    N = K + C + n
    most = 1
    for i in range(c):
        most = max(most, 1 + last_way(contacts, i))
    T, d = np.empty((c + 1, m, N + m + 1)), np.empty((c + 1, N + m + 1))
    basis, allowed = np.empty((c + 1, m), dtype=np.int64), np.empty((c + 1, N), dtype=np.bool_)
    bounds, order = np.empty((c, most)), np.empty((c, most), dtype=np.int64)
    left, ways = np.zeros(c, dtype=np.int64), np.full(c, UNTOLD)
    found[:] = UNTOLD
    best = z
    _begin(contacts, n, q, f, directions, T[0], d[0], basis[0])
    allowed[0] = _all_allowed(contacts, n, K)
    if _renew(T[0], d[0], basis[0], m, N, allowed[0], best) >= best or c == 0:
        return best
    depth = 0
    fresh = True
    while depth >= 0:
        if fresh:
            left[depth] = 0
            first = OPEN if contacts.one_sided[depth] else STICKS
            for way in range(first, last_way(contacts, depth) + 1):
                allowed[depth + 1] = allowed[depth]
                presses(contacts, depth, way, allowed[depth + 1, K : K + C])
                t = max(-d[depth, N + m], 0.0) + 0.0
                if not _unmoved(T[depth], basis[depth], m, N, allowed[depth + 1]):
                    T[depth + 1], d[depth + 1] = T[depth], d[depth]
                    basis[depth + 1] = basis[depth]
                    t = _renew(
                        T[depth + 1], d[depth + 1], basis[depth + 1], m, N, allowed[depth + 1], best
                    )
                if t >= best - CLOSER:
                    continue
                ways[depth] = way
                if not deviates(contacts, ways):
                    continue
                at = left[depth]
                while at > 0 and bounds[depth, at - 1] < t:  # the least comes last
                    bounds[depth, at], order[depth, at] = (
                        bounds[depth, at - 1], order[depth, at - 1],
                    )  # fmt: skip
                    at -= 1
                bounds[depth, at], order[depth, at] = t, way
                left[depth] += 1
            ways[depth] = UNTOLD
        fresh = False
        if left[depth] == 0 or bounds[depth, left[depth] - 1] >= best - CLOSER:
            ways[depth] = UNTOLD
            depth -= 1
            continue
        left[depth] -= 1
        ways[depth] = order[depth, left[depth]]
        if depth + 1 == c:
            best = bounds[depth, left[depth]]
            found[:] = ways
            if best <= enough:
                return best
            continue
        allowed[depth + 1] = allowed[depth]
        presses(contacts, depth, ways[depth], allowed[depth + 1, K : K + C])
        T[depth + 1], d[depth + 1], basis[depth + 1] = T[depth], d[depth], basis[depth]
        _renew(T[depth + 1], d[depth + 1], basis[depth + 1], m, N, allowed[depth + 1], np.inf)
        depth += 1
        fresh = True
    return best
