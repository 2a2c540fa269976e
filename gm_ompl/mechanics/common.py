"""Problem (6) for all cases at once, compiled: one f_com, and z the least of theirs.

The cuts of all cases bound one z over one f_com, as those of all directions do in one case.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.cases import (
    Cases,
    Pad,
    case_cut,
    count_of,
    look_at,
    matters,
    new_pad,
    parts_of,
    try_case,
)
from gm_ompl.mechanics.certificate import proven
from gm_ompl.mechanics.commands import ZERO, all_proven, next_set
from gm_ompl.mechanics.kelley import (
    Cuts,
    ModeSets,
    cuts_off,
    force_control,
    limiting_direction,
    next_trial,
    no_cuts,
    settle,
    unit_wrench,
)
from gm_ompl.mechanics.program import Separation
from gm_ompl.mechanics.simplex import SOLVED, TROUBLE
from gm_ompl.mechanics.stability import FAILED, UNBOUNDED
from gm_ompl.mechanics.trials import aim_at, take_up

MOST_CUTS = 160
"""Cuts, and two more per case; and"""
MOST_TRIALS = 80
"""trials of one set of modes, before the reference is asked."""


@compiled
def _add_cut(
    cases: Cases, c: int, separation: Separation, y: Array, masks: IntArray, cuts: Cuts
) -> bool:
    """Add y's cut in case ``c`` for all sets; False where y is nothing: z = +inf."""
    force, K = np.empty(len(cases.f_max), dtype=np.bool_), cuts.filled[0]
    unit = cuts.wrenches[K]
    if not unit_wrench(cases.envs[parts_of(cases, c)[0]], separation, y, unit):
        return False
    cuts.h[K], cuts.met[K] = limiting_direction(cases.L, unit)
    for j in range(len(masks)):
        force_control(masks[j], force)
        cuts.c[j, K] = case_cut(cases, c, force, unit, cuts.slopes[j, K])
    cuts.filled[0] = K + 1
    return True


@compiled
def _heed(j: int, caps: Array, cuts: Cuts) -> float:
    """Let set j heed all cuts: its next trial and its bound on z, which is returned."""
    nf = len(caps)
    which, weights = np.empty(1 + nf, np.int64), np.empty(1 + nf)
    z = next_trial(j, caps, cuts, which, weights)
    constant, h, slopes = 0.0, 0.0, np.zeros(nf)
    for k in range(1 + nf):
        if which[k] >= 0:
            constant += weights[k] * cuts.c[j, which[k]]
            h += weights[k] * cuts.h[which[k]]
            for i in range(nf):
                slopes[i] += weights[k] * cuts.slopes[j, which[k], i]
    for i in range(nf):
        constant += caps[i] * max(slopes[i], 0.0)
    if h > 0.0:
        cuts.proven[j] = min(cuts.proven[j], constant / h)
    return z


@compiled
def _try_trial(
    cases: Cases, j: int, force: BoolArray, sets: ModeSets, cuts: Cuts, pad: Pad
) -> tuple[int, int]:
    """Put set j's f_com to all cases, first the one in which the last f_com failed.

    Returns:
        SOLVED where z is proven to reach the bound in all of them, else how it ended in which case:
        the pad's duals prove less.
    """
    bound, mask, first, commands = cuts.bounds[j], sets.masks[j], pad.last[j], sets.commands[j]
    cuts.passes[j] += 1
    cuts.held[j] = np.inf
    for step in range(-1, count_of(cases)):
        c = first if step < 0 else step
        if not matters(cases, c, mask) or step == first:
            continue
        end, _, _, v = try_case(cases, c, j, force, commands, aim_at(bound), pad)
        if end != SOLVED or not bound < np.inf:
            pad.last[j] = c
            return end if end != SOLVED else -1, c
        cuts.held[j] = min(cuts.held[j], v)
    return SOLVED, first


@compiled
def common_commands(
    cases: Cases, separation: Separation, below: float, sets: ModeSets, first: Array, of: int
) -> tuple[int, float]:
    """Find the largest z in the worst case among sets of modes, each with some force control.

    Args:
        cases: the family.
        separation: of the columns of all cases.
        below: a threshold; where all z are proven smaller, stop.
        sets: output, with their masks.
        first: (6,), a wrench whose cut in case ``of`` may help, or zero.
        of: that case.

    Returns:
        REACHED, BELOW, UNBOUNDED or FAILED, with an upper bound on all z, as ``best_commands``.
    """
    n, N, masks, zs = len(cases.f_max), count_of(cases), sets.masks, sets.zs
    most = cases.f_max / cases.press[-1]  # whatever the errors: within the limits
    pad, cuts = new_pad(len(masks), cases), no_cuts(MOST_CUTS + 2 * N, most, sets)
    force, caps, scores = np.empty(n, np.bool_), np.empty(n), np.empty(N)
    _add_cut(cases, of, separation, first, masks, cuts)
    while True:
        j = next_set(zs, cuts.bounds, below)
        if j == len(masks):
            break
        nf = take_up(j, most, sets, cuts, force, caps)
        if cuts.heeded[j] < cuts.filled[0]:
            if _heed(j, caps[:nf], cuts) <= ZERO:
                if not proven(0.0, max(cuts.proven[j], 0.0)):
                    return FAILED, np.inf
                zs[j], cuts.bounds[j], sets.limiting[j] = 0.0, 0.0, cuts.met[cuts.filled[0] - 1]
            continue
        if cuts.passes[j] == MOST_TRIALS or len(cuts.h) < cuts.filled[0] + 2:
            return FAILED, np.inf
        end, c = _try_trial(cases, j, force, sets, cuts, pad)
        if end == TROUBLE:
            return FAILED, np.inf
        if end == SOLVED:
            settle(j, nf, sets, cuts)
            continue
        if not _add_cut(cases, c, separation, pad.work.y, masks, cuts):
            return UNBOUNDED, np.inf
        y, trial = cuts.wrenches[cuts.filled[0] - 1], cuts.trials[j, :nf]
        worst, _ = look_at(cases, c, masks[j], force, y, trial, scores)
        if worst != c:
            _add_cut(cases, worst, separation, y, masks, cuts)
        if not cuts_off(j, nf, cuts):
            return FAILED, np.inf
    return all_proven(zs, cuts, below)
