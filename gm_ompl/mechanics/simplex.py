"""All 76 directions of Problem (6) on one tableau.

Only the right-hand sides of their tau programs (``tau``) differ: a basis that is optimal for one
direction stays dual feasible for all, and one pivot moves all right-hand sides along.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.closing import (
    basic,
    bounded,
    choose,
    drop_closed,
    extremes,
    join_balance,
    keep,
    share,
    sides_left,
    solved,
    weigh,
    worst_of,
)
from gm_ompl.mechanics.sides import SIDES
from gm_ompl.mechanics.tableau import (
    DANTZIG_STEPS,
    MAX_STEPS,
    MORE_STEPS,
    entering,
    leaving,
    pivot,
)
from gm_ompl.mechanics.tau import Tableau

NO_TAU = 1e-13
"""A tau up to this (over force_scale) is none: z_i = +inf."""

SPACED = (SIDES + 7) // 8 * 8
"""Entries per right-hand side, rounded up to where a vector may begin."""
SOLVED, EXCEEDED, INFEASIBLE, TROUBLE = 0, 1, 2, 3
"""Ends of a pass: the worst direction found; stopped early at a direction; a direction that
nothing resists; give up."""


Ended: TypeAlias = tuple[int, int, float]
"""How a pass ended, a direction's code, its tau."""


class Target(NamedTuple):
    """Where a pass over the directions may stop.

    Attributes:
        limit: as soon as a direction is solved whose tau exceeds this.
        enough: a tau that is proven to stay within this need not be known; 0 for the largest tau
            exactly.
        patience: pivots after which the worst direction so far will do.
    """

    limit: float
    enough: float
    patience: int


class Care(NamedTuple):
    """What a pass over the directions takes for nothing.

    Attributes:
        least: the smallest entry accepted as a pivot.
        overlooked: how far a basic variable may be on the wrong side, relative to the largest.
        bland: whether to use Bland's rule throughout, the slow and sure one.
    """

    least: float
    overlooked: float
    bland: bool


@inlined
def _step(T: Array, d: Array, basis: IntArray, W: int, x: Array, care: Care, room: Array) -> int:
    """Pivot to mend a basic solution x (m,); where nothing can, it gets the ray that proves it.

    A row of the tableau ends at ``W``; ``room`` (N,) is room to work in.

    Returns:
        SOLVED where a pivot was made, INFEASIBLE, or TROUBLE.
    """
    m, N = len(basis), len(room)
    r = leaving(x, basis, m, N, care.overlooked, care.bland)
    if r < 0:
        return TROUBLE
    sign = 1.0 if x[r] < 0.0 else -1.0
    c = entering(T, d, r, sign, care.least, care.bland, room)
    if c < 0:
        for i in range(m):
            x[i] = -sign * T[r, N + i]
        return INFEASIBLE
    pivot(T, d, basis, m, W, r, c)
    return SOLVED


@inlined
def _rooms(m: int, N: int) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
    """Return rooms in one piece, zeros but for the ones: to ask for each takes longer than a pivot.

    The least and greatest basic variables (SPACED,); ones, weights and a solution (m,); room and
    the balance (N,).
    """
    numbers = np.zeros(2 * SPACED + 3 * m + 2 * N)
    lo, hi, rest = numbers[:SPACED], numbers[SPACED : 2 * SPACED], numbers[2 * SPACED :]
    ones, more = rest[:m], rest[3 * m :]
    ones[:] = 1.0
    return lo, hi, ones, rest[m : 2 * m], rest[2 * m : 3 * m], more[:N], more[N:]


@compiled
def search_directions(tableau: Tableau, cost: float, target: Target, care: Care) -> Ended:
    """Find the direction with the largest tau, or one whose tau is large enough.

    Args:
        tableau: dual feasible, with all right-hand sides; left at its last basis, and right-hand
            sides are lost. Its ``y`` gets the duals that prove the tau returned (y . l_i = tau), or
            the ray with y . l_i > 0 where a direction is infeasible; ``found`` what resists each
            direction that was closed.
        cost: of the tau column: tau = cost times its variable.
        target: where to stop.
        care: what counts as nothing.

    Returns:
        How the pass ended, the direction's code, its tau.
    """
    raw, T, d, basis, y, (columns, x, times, order) = tableau
    m, N = raw.shape
    slots, ahead, behind, alone = sides_left()
    lo, hi, ones, weights, side, room, balance = _rooms(m, N)
    times[:] = 0.0
    now, worst, worst_tau, here, first, S, count = -1, -1, -1.0, 0, N + m, SIDES, 0
    for step in range(MAX_STEPS + MORE_STEPS * N):
        extremes(T, basis, N, S, ones, lo, hi)
        some = solved(S, lo, hi, care.overlooked, ahead, behind, order[count:])
        if some > 0:
            closing, before, count = order[count : count + some], worst, count + some
            worst, worst_tau = worst_of(d[first:], slots, closing, worst, worst_tau)
            keep(T, basis, first, slots, closing, columns, x)
            join_balance(closing, columns, x, N, alone, balance)
            for r in range(m if worst != before else 0):
                y[r] = -d[N + r]
        if worst_tau > target.limit or (step >= target.patience and worst_tau > NO_TAU):
            return EXCEEDED, worst, worst_tau
        if balance[0] > 0.0:
            per_tau, enough = weigh(basis, N, balance, cost, weights), max(worst_tau, target.enough)
            extremes(T, basis, N, S, weights, lo, hi)
            some = bounded(d[first : first + S], lo, hi, enough, ahead, behind, order[count:])
            closing, count = order[count : count + some], count + some
            share(closing, slots, lo, hi, per_tau, times)
            keep(T, basis, first, slots, closing, columns, x)
        if now < 0 or not (behind[now // 2] if now % 2 else ahead[now // 2]):
            S = drop_closed(T, d, first, S, slots, ahead, behind)
            if S == 0:
                return SOLVED, worst, worst_tau
            now, here = choose(d[first : first + S], S, ahead, behind, lo), 0
        here += 1
        basic(T, first + now // 2, now % 2, side)
        slow = care.bland or here > DANTZIG_STEPS + N
        end = _step(T, d, basis, first + S, side, Care(care.least, care.overlooked, slow), room)
        if end != SOLVED:
            for r in range(m if end == INFEASIBLE else 0):
                y[r] = side[r]
            return end, 2 * slots[now // 2] + now % 2, np.inf
    return TROUBLE, -1, 0.0
