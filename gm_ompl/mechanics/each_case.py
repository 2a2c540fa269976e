"""Problem (6) in each case where no finger is force-controlled, compiled: z is the least of theirs.

No f_com ties the cases together. Once z of one case is known, another need only be shown to be no
worse, which takes a fraction of what its z does.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.cases import (
    Cases,
    count_of,
    look_at,
    matters,
    new_pad,
    parts_of,
    program_of,
    try_case,
)
from gm_ompl.mechanics.certificate import into_polar, proven, reach, upper_bound
from gm_ompl.mechanics.program import Separation
from gm_ompl.mechanics.simplex import INFEASIBLE, NO_TAU, SOLVED, TROUBLE, Target
from gm_ompl.mechanics.stability import A_LOOK, BALANCED, BELOW, FAILED, REACHED, UNBOUNDED
from gm_ompl.mechanics.tableau import NEVER


@compiled
def _wrench(
    cases: Cases, c: int, separation: Separation, nobody: BoolArray, y: Array
) -> tuple[float, float]:
    """Move y (6,) into the polar of case ``c``'s cone; return h_P(y) and its bound on z there."""
    program = program_of(cases, c)
    if not into_polar(program.env, separation, y):
        y[:] = 0.0
    return reach(cases.L, y), upper_bound(program, nobody, y.reshape(1, 6))


@compiled
def _alike(cases: Cases) -> BoolArray:
    """Return whether each case is like one before it where nobody is force-controlled."""
    everyone, found = (1 << len(cases.f_max)) - 1, np.empty(count_of(cases), dtype=np.bool_)
    for c in range(len(found)):
        found[c] = not matters(cases, c, everyone)
    return found


@compiled
def _next(closed: BoolArray, scores: Array) -> int:
    """Return the open case that is bounded most, -1 for none."""
    c = -1
    for k in range(len(closed)):
        if not closed[k] and (c < 0 or scores[k] < scores[c]):
            c = k
    return c


@compiled
def position_margins(
    cases: Cases, separation: Separation, below: float, exact: bool, y: Array
) -> tuple[int, float, int, int]:
    """z in the worst case where nobody is force-controlled.

    The case next looked at is the one that wrenches met so far bound most; it need only be shown
    to be no worse than the worst so far.

    Args:
        cases: the family.
        separation: of the columns of all cases.
        below: a threshold; where z is proven smaller, stop with an upper bound on z.
        exact: whether z is wanted where it is at least ``below``; else a short look at the first
            case is made in search of a proof that it is smaller.
        y: output (6,): the wrench of a cut in the polar of a case's cone, zero where there is none.

    Returns:
        As ``position_margin``, and the case that ``y`` is a cut of.
    """
    f_max, N, patience = cases.f_max, count_of(cases), NEVER if exact else A_LOOK
    everyone, nobody, none = (1 << len(f_max)) - 1, np.zeros(len(f_max), np.bool_), np.zeros(0)
    pad, unit, scores, closed = new_pad(1, cases), np.zeros(6), np.full(N, np.inf), _alike(cases)
    limit = 1.0 / below if below > 0.0 else np.inf
    z, U, held, direction, of, c = np.inf, np.inf, np.inf, -1, 0, 0
    while c >= 0:
        closed[c] = True
        enough = 1.0 / z if exact else (limit if below > 0.0 else 0.0)
        target = Target(limit, enough, patience)
        end, which, tau, v = try_case(cases, c, 0, nobody, f_max, target, pad)
        if end != SOLVED or tau > enough:
            unit[:] = pad.work.y[:6]
            h, here = _wrench(cases, c, separation, nobody, unit)
            if h > 0.0:
                worst, least = look_at(cases, c, everyone, nobody, unit, none, scores)
                if below <= 0.0 and -least > BALANCED * np.sqrt((unit * unit).sum()):
                    return REACHED, -np.inf, which, of
                if least / h < U:
                    U = least / h
                    if parts_of(cases, worst)[2] == 0:
                        y[:], of = unit, worst
            if below > max(U, 0.0):
                return BELOW, max(U, 0.0), which, of
            if not exact and end != TROUBLE:
                return REACHED, U, which, of
            if end == INFEASIBLE:
                return REACHED if proven(0.0, max(here, 0.0)) else FAILED, 0.0, which, of
            if end != SOLVED or (tau > NO_TAU and not proven(v, here)):
                return FAILED, U, which, of
            if tau > NO_TAU and min(max(1.0 / tau, v), here) < z:
                z, direction = min(max(1.0 / tau, v), here), which
        held = min(held, v) if tau > NO_TAU else held
        c = _next(closed, scores)
    end = REACHED if proven(held, z) else FAILED
    if not z < np.inf:
        end = UNBOUNDED if exact else REACHED
    return end, z, direction, of
