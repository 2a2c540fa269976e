"""Problem (6) in each case where no finger is force-controlled, compiled: z is the least of theirs.

No f_com ties the cases together. Once z of one case is known, another need only be shown to be no
worse, which takes a fraction of what its z does.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.cases import Cases, count_of, look_at, matters, new_pad, parts_of, try_case
from gm_ompl.mechanics.certificate import into_polar, proven, reach, upper_bound
from gm_ompl.mechanics.simplex import INFEASIBLE, NO_TAU, SOLVED, TROUBLE
from gm_ompl.mechanics.stability import A_LOOK, BALANCED, BELOW, FAILED, REACHED, UNBOUNDED
from gm_ompl.mechanics.tableau import NEVER


@compiled
def position_margins(
    cases: Cases, f_max: Array, L: Array, below: float, exact: bool, w: Array, margin: float,
    y: Array,
) -> tuple[int, float, int, int]:  # fmt: skip
    """z in the worst case where nobody is force-controlled.

    The case next looked at is the one that wrenches met so far bound most; it need only be shown
    to be no worse than the worst so far.

    Args:
        cases: the family.
        f_max: (n,).
        L: (76, 6), the directions.
        below: a threshold; where z is proven smaller, stop with an upper bound on z.
        exact: whether z is wanted where it is at least ``below``; else a short look at the first
            case is made in search of a proof that it is smaller.
        w: (6,), a wrench that separates the columns of all cases, with its
        margin: see ``into_polar``.
        y: output (6,): the wrench of a cut in the polar of a case's cone, zero where there is none.

    Returns:
        As ``position_margin``, and the case that ``y`` is a cut of.
    """
    n, N = len(f_max), count_of(cases)
    everyone, nobody, none = (1 << n) - 1, np.zeros(n, dtype=np.bool_), np.zeros(0)
    pad, unit, scores, closed = new_pad(1, cases), np.zeros(6), np.full(N, np.inf), np.empty(N)
    for k in range(N):
        closed[k] = 0.0 if matters(cases, k, everyone) else np.inf
    limit, z, U, held, direction, of, c = np.inf, np.inf, np.inf, np.inf, -1, 0, 0
    if below > 0.0:
        limit = 1.0 / below
    while c >= 0:
        closed[c] = np.inf
        env, load, tip, _ = parts_of(cases, c)
        enough = 1.0 / z if exact else (limit if below > 0.0 else 0.0)
        end, which, tau, v = try_case(
            cases, c, 0, f_max, nobody, f_max, L, limit, enough, NEVER if exact else A_LOOK, pad
        )
        if end != SOLVED or tau > enough:
            for t in range(6):
                unit[t] = pad.y[t]
            if not into_polar(cases.envs[env], w, margin, unit):
                unit[:] = 0.0
            h = reach(L, unit)
            here = upper_bound(
                cases.loads[load], cases.tips[tip], f_max, nobody, L, unit.reshape(1, 6)
            )
            if h > 0.0:
                worst, least = look_at(cases, c, everyone, f_max, nobody, unit, none, scores)
                if below <= 0.0 and -least > BALANCED * np.sqrt((unit * unit).sum()):
                    return REACHED, -np.inf, which, of
                if least / h < U:
                    U = least / h
                    if parts_of(cases, worst)[2] == 0:
                        y[:], of = unit, worst
            if below > max(U, 0.0):
                return BELOW, max(U, 0.0), which, of
            if end == TROUBLE:
                return FAILED, U, which, of
            if not exact:
                return REACHED, U, which, of
            if end == INFEASIBLE:
                return REACHED if proven(0.0, max(here, 0.0)) else FAILED, 0.0, which, of
            if end != SOLVED or (tau > NO_TAU and not proven(v, here)):
                return FAILED, U, which, of
            if tau > NO_TAU and min(max(1.0 / tau, v), here) < z:
                z, direction = min(max(1.0 / tau, v), here), which
        if tau > NO_TAU:
            held = min(held, v)
        c = -1
        for k in range(N):
            if closed[k] == 0.0 and (c < 0 or scores[k] < scores[c]):
                c = k
    if not z < np.inf:
        return UNBOUNDED if exact else REACHED, np.inf, direction, of
    return REACHED if proven(held, z) else FAILED, z, direction, of
