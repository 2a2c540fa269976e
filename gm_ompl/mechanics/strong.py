"""z_strong for given modes and commands: the least disturbance under which contacts give way.

For given ways of all contacts (``deviations``) the least disturbance t that forces balance is

    t = min sum_i w_i  subject to  q + sum_i w_i l_i + A k = 0,  per finger sum_k = f, w, k >= 0

(<= f_max under position control), with the edges that the ways let press; z_strong is the least of
z and all t. Branch and bound over the contacts: where some are not told yet, all their edges may
press, which bounds t from below. Telling one more bars columns, so that a tableau that was optimal
stays dual feasible: a few pivots renew it, and stop where t is large enough.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.deviations import (
    CLOSED,
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
    contacts: ContactRows, q: Array, f: Array, directions: Array, T: Array, d: Array,
    basis: IntArray,
) -> None:  # fmt: skip
    """Write the tableau with all variables out of the basis."""
    K, C, n = len(directions), len(contacts.columns), len(f)
    m, N = 6 + n, K + C + n
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
    contacts: ContactRows, q: Array, f: Array, directions: Array, ways: IntArray, beyond: float
) -> float:
    """Return t for the given ways (c,) of all contacts, or some t >= ``beyond``.

    The rest as for ``gives_way``; whether a deviation goes with them is not asked.
    """
    K, C, n = len(directions), len(contacts.columns), len(f)
    m, N = 6 + n, K + C + n
    T, d, basis = np.empty((m, N + m + 1)), np.empty(N + m + 1), np.empty(m, dtype=np.int64)
    _begin(contacts, q, f, directions, T, d, basis)
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


class Scratch(NamedTuple):
    """What branch and bound works in, by level: first who is open, then how the others slide.

    Attributes:
        T: (2 c + 1, m, N + m + 1), tableaux.
        d: (2 c + 1, N + m + 1), their reduced costs.
        basis: (2 c + 1, m).
        allowed: (2 c + 1, N), the columns that may be used.
        bounds: (2 c, w), of the ways that are left to try, the least last.
        order: (2 c, w), those ways.
        left: (2 c,), how many there are.
    """

    T: Array
    d: Array
    basis: IntArray
    allowed: BoolArray
    bounds: Array
    order: IntArray
    left: IntArray


def _room(contacts: ContactRows, n: int, K: int) -> Scratch:
    c, m = len(contacts.normal), 6 + n
    N = K + len(contacts.columns) + n
    most = 2 + 2 * int(np.diff(contacts.first).max(initial=0))
    levels, W = 2 * c, N + m + 1
    return Scratch(
        np.empty((levels + 1, m, W)), np.empty((levels + 1, W)),
        np.empty((levels + 1, m), dtype=np.int64), np.empty((levels + 1, N), dtype=np.bool_),
        np.empty((levels, most)), np.empty((levels, most), dtype=np.int64),
        np.zeros(levels, dtype=np.int64),
    )  # fmt: skip


@compiled
def _tried(
    contacts: ContactRows, room: Scratch, level: int, way: int, K: int, beyond: float
) -> float:
    """Write the next level's tableau for a way at this level; return its bound on t."""
    i, C = level % len(contacts.normal), len(contacts.columns)
    T, d, basis, allowed = room.T, room.d, room.basis, room.allowed
    m, N = T.shape[1], allowed.shape[1]
    allowed[level + 1] = allowed[level]
    presses(contacts, i, way, allowed[level + 1, K : K + C])
    if _unmoved(T[level], basis[level], m, N, allowed[level + 1]):
        return max(-d[level, N + m], 0.0) + 0.0
    T[level + 1], d[level + 1], basis[level + 1] = T[level], d[level], basis[level]
    return _renew(T[level + 1], d[level + 1], basis[level + 1], m, N, allowed[level + 1], beyond)


@compiled
def _look(
    contacts: ContactRows, room: Scratch, level: int, ways: IntArray, K: int, best: float
) -> None:
    """Write which ways are worth trying at a level, the one with the least bound last."""
    c = len(contacts.normal)
    i, now, count = level % c, ways[level % c], 0
    first, last = OPEN if contacts.one_sided[i] else STICKS, STICKS
    if level >= c:
        first, last = now, now
        if now == CLOSED:
            first, last = STICKS, last_way(contacts, i)
    for each in range(first, last + 1):
        # At first, what is not open is closed, and no more is said.
        way = CLOSED if level < c and each == STICKS and not contacts.plain[i] else each
        t = _tried(contacts, room, level, way, K, best)
        if t >= best - CLOSER:
            continue
        ways[i] = way
        if way != now and not deviates(contacts, ways):
            continue
        at = count
        while at > 0 and room.bounds[level, at - 1] < t:
            room.bounds[level, at] = room.bounds[level, at - 1]
            room.order[level, at] = room.order[level, at - 1]
            at -= 1
        room.bounds[level, at], room.order[level, at] = t, way
        count += 1
    ways[i] = now
    room.left[level] = count


@compiled
def _descend(
    contacts: ContactRows, room: Scratch, K: int, z: float, enough: float, found: IntArray
) -> float:
    """Search below the first level, whose tableau is written; see ``gives_way``."""
    c, best, level = len(contacts.normal), z, 0
    ways, before = np.full(c, UNTOLD), np.full(2 * c, UNTOLD)
    _look(contacts, room, 0, ways, K, best)
    while level >= 0:
        i, k = level % c, room.left[level] - 1
        ways[i] = before[level]
        if k < 0 or room.bounds[level, k] >= best - CLOSER:
            level -= 1
            continue
        room.left[level] = k
        ways[i] = room.order[level, k]
        if level + 1 == 2 * c:
            best = room.bounds[level, k]
            found[:] = ways
            if best <= enough:
                return best
            continue
        room.T[level + 1], room.d[level + 1] = room.T[level], room.d[level]
        room.basis[level + 1] = room.basis[level]
        _tried(contacts, room, level, ways[i], K, np.inf)
        level += 1
        before[level] = ways[level % c]
        _look(contacts, room, level, ways, K, best)
    return best


def gives_way(
    contacts: ContactRows, q: Array, f: Array, directions: Array, z: float, enough: float,
    found: IntArray,
) -> float:  # fmt: skip
    """Return z_strong; forces over M g.

    Args:
        contacts: fingertips first, as their modes are.
        q: (6,), the load.
        f: (fingertips,), f_com of force-controlled fingers, f_max of others.
        directions: (76, 6), the l_i.
        z: of Problem (6), for these modes and commands.
        enough: where z_strong is at most this, it need not be known any better.
        found: output (c,), what contacts do at z_strong; UNTOLD where none gives way below z.
    """
    found[:] = UNTOLD
    if len(contacts.normal) == 0:
        return z
    room = _room(contacts, len(f), len(directions))
    _begin(contacts, q, f, directions, room.T[0], room.d[0], room.basis[0])
    room.allowed[0] = _all_allowed(contacts, len(f), len(directions))
    m, N = room.T.shape[1], room.allowed.shape[1]
    if _renew(room.T[0], room.d[0], room.basis[0], m, N, room.allowed[0], z) >= z:
        return z
    return float(_descend(contacts, room, len(directions), z, enough, found))
