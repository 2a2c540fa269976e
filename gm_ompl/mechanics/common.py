"""Problem (6) for all cases at once, compiled: one f_com, and z the least of theirs.

The cuts of all cases bound one z over one f_com, as those of all directions do in one case.
"""

from __future__ import annotations

from typing import NamedTuple

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
    FIRST_LOOK,
    GAP,
    force_control,
    limiting_direction,
    take_up,
    tightest,
    unit_wrench,
)
from gm_ompl.mechanics.master import best_command
from gm_ompl.mechanics.simplex import SOLVED, TROUBLE
from gm_ompl.mechanics.stability import FAILED, UNBOUNDED
from gm_ompl.mechanics.tableau import NEVER

MOST_CUTS = 160
"""Cuts, and two more per case; and"""
MOST_TRIALS = 80
"""trials of one set of modes, before the reference is asked."""


class CommonCuts(NamedTuple):
    """Kelley's cuts h z <= c + slopes . f_com of all cases, each with its form for every set.

    Attributes:
        wrenches: (K, 6).
        h: (K,).
        met: (K,), the directions with l_i . y = h.
        c: (sets, K).
        slopes: (sets, K, n), a column per force-controlled finger, the rest unused.
        bounds: (sets,), the largest z that they allow.
        proven: (sets,), the same, as the wrenches prove it.
        held: (sets,), what z is at least at the f_com found.
        trials: (sets, n), f_com that allows it, an entry per force-controlled finger.
        heeded: (sets,), how many cuts the set's bound and trial heed.
        tried: (sets,), how many trials were put to the cases.
        last: (sets,), the case in which the last one failed.
    """

    wrenches: Array
    h: Array
    met: IntArray
    c: Array
    slopes: Array
    bounds: Array
    proven: Array
    held: Array
    trials: Array
    heeded: IntArray
    tried: IntArray
    last: IntArray


@compiled
def _no_cuts(cases: Cases, most: Array, masks: IntArray, zs: Array, commands: Array) -> CommonCuts:
    """Return no cuts; every set's first trial is in the middle of its range; zs gets -1."""
    sets, n, K = len(masks), len(most), MOST_CUTS + 2 * count_of(cases)
    trials, force = np.empty((sets, n)), np.empty(n, dtype=np.bool_)
    for j in range(sets):
        force_control(masks[j], force)
        zs[j], nf = -1.0, 0
        for i in range(n):
            commands[j, i] = most[i]
            if force[i]:
                trials[j, nf] = 0.5 * most[i]
                nf += 1
    none = np.zeros(sets, dtype=np.int64)
    return CommonCuts(
        np.empty((K, 6)), np.empty(K), np.empty(K, dtype=np.int64), np.empty((sets, K)),
        np.empty((sets, K, n)), np.full(sets, np.inf), np.full(sets, np.inf), np.zeros(sets),
        trials, none, none.copy(), none.copy(),
    )  # fmt: skip


@compiled
def _add_cut(
    cases: Cases, c: int, f_max: Array, masks: IntArray, L: Array, w: Array, margin: float,
    y: Array, cuts: CommonCuts, K: int,
) -> bool:  # fmt: skip
    """Add y's cut in case ``c`` as number K for all sets; False where y is nothing: z = +inf."""
    force, unit = np.empty(len(f_max), dtype=np.bool_), cuts.wrenches[K]
    if not unit_wrench(cases.envs[parts_of(cases, c)[0]], w, margin, y, unit):
        return False
    cuts.h[K], cuts.met[K] = limiting_direction(L, unit)
    for j in range(len(masks)):
        force_control(masks[j], force)
        cuts.c[j, K] = case_cut(cases, c, f_max, force, unit, cuts.slopes[j, K])
    return True


@compiled
def _heed(j: int, K: int, caps: Array, cuts: CommonCuts) -> float:
    """Let set j heed K cuts: its next trial and its bound on z, which is returned."""
    nf = len(caps)
    which, weights = np.empty(1 + nf, np.int64), np.empty(1 + nf)
    z = best_command(cuts.h, cuts.c[j], cuts.slopes[j], K, caps, nf, cuts.trials[j], which, weights)
    constant, h, slopes = 0.0, 0.0, np.zeros(nf)
    for k in range(1 + nf):
        if which[k] >= 0:
            constant += weights[k] * cuts.c[j, which[k]]
            h += weights[k] * cuts.h[which[k]]
            for i in range(nf):
                slopes[i] += weights[k] * cuts.slopes[j, which[k], i]
    for i in range(nf):
        constant += caps[i] * max(slopes[i], 0.0)
    cuts.bounds[j], cuts.heeded[j] = min(cuts.bounds[j], z), K
    if h > 0.0:
        cuts.proven[j] = min(cuts.proven[j], constant / h)
    return z


@compiled
def _try_trial(
    cases: Cases, j: int, mask: int, f_max: Array, force: BoolArray, L: Array, cuts: CommonCuts,
    commands: Array, pad: Pad,
) -> tuple[int, int]:  # fmt: skip
    """Put set j's f_com to all cases, first the one in which the last f_com failed.

    Returns:
        SOLVED where z is proven to reach the bound in all of them, else how it ended in which case:
        ``pad.y`` proves less.
    """
    bound = cuts.bounds[j]
    aim = bound - GAP * max(bound, 1e-3) if bound < np.inf else 0.0
    limit, enough = (1.0 / aim, 1.0 / aim) if aim > 0.0 else (np.inf, 0.0)
    patience = NEVER if bound < np.inf else FIRST_LOOK
    cuts.tried[j] += 1
    cuts.held[j] = np.inf
    for step in range(-1, count_of(cases)):
        c = cuts.last[j] if step < 0 else step
        if not matters(cases, c, mask) or (step >= 0 and step == cuts.last[j]):
            continue
        end, _, _, v = try_case(
            cases, c, j, f_max, force, commands[j], L, limit, enough, patience, pad
        )
        if end != SOLVED or not bound < np.inf:
            cuts.last[j] = c
            return end if end != SOLVED else -1, c
        cuts.held[j] = min(cuts.held[j], v)
    return SOLVED, cuts.last[j]


@compiled
def common_commands(
    cases: Cases, f_max: Array, most: Array, L: Array, below: float, masks: IntArray, first: Array,
    of: int, w: Array, margin: float, zs: Array, limiting: IntArray, commands: Array,
) -> tuple[int, float]:  # fmt: skip
    """Find the largest z in the worst case among sets of modes, each with some force control.

    Args:
        cases: the family.
        f_max: (n,), over force_scale.
        most: (n,), the largest commands.
        L: (76, 6), the directions.
        below: a threshold; where all z are proven smaller, stop.
        masks: (sets,), position-controlled fingers as bits, in order of preference.
        first: (6,), a wrench whose cut in case
        of: may help, or zero.
        w: (6,), a wrench that separates the columns of all cases, with its
        margin: see ``into_polar``.
        zs: output (sets,): z where it may be the largest or tie with it, else -1.
        limiting: output (sets,): the directions that limit z.
        commands: output (sets, n): f_com.

    Returns:
        REACHED, BELOW, UNBOUNDED or FAILED, with an upper bound on all z, as ``best_commands``.
    """
    sets, n, top, K = len(masks), len(f_max), -1.0, 0
    pad, cuts = new_pad(sets, cases), _no_cuts(cases, most, masks, zs, commands)
    force, caps, scores = np.empty(n, np.bool_), np.empty(n), np.empty(count_of(cases))
    if _add_cut(cases, of, f_max, masks, L, w, margin, first, cuts, 0):
        K = 1
    while True:
        j = next_set(zs, cuts.bounds, below)
        if j == sets:
            break
        nf = take_up(j, masks[j], most, force, cuts.trials, commands, caps)
        if cuts.heeded[j] < K:
            z = _heed(j, K, caps[:nf], cuts)
            if z <= ZERO:
                if not proven(0.0, max(cuts.proven[j], 0.0)):
                    return FAILED, np.inf
                zs[j], cuts.bounds[j], limiting[j], top = 0.0, 0.0, cuts.met[K - 1], max(top, 0.0)
            continue
        if cuts.tried[j] == MOST_TRIALS or len(cuts.h) < K + 2:
            return FAILED, np.inf
        end, c = _try_trial(cases, j, masks[j], f_max, force, L, cuts, commands, pad)
        if end == TROUBLE:
            return FAILED, np.inf
        trial = cuts.trials[j, :nf]
        if end == SOLVED:
            z, which = tightest(cuts.h, cuts.c[j], cuts.slopes[j], K, trial)
            zs[j] = min(max(z, cuts.held[j]), cuts.proven[j])
            limiting[j], top = cuts.met[which], max(top, zs[j])
            continue
        if not _add_cut(cases, c, f_max, masks, L, w, margin, pad.y, cuts, K):
            return UNBOUNDED, np.inf
        worst, _ = look_at(cases, c, masks[j], f_max, force, cuts.wrenches[K], trial, scores)
        K += 1
        if worst != c and _add_cut(
            cases, worst, f_max, masks, L, w, margin, cuts.wrenches[K - 1], cuts, K
        ):
            K += 1
        z, _ = tightest(cuts.h, cuts.c[j], cuts.slopes[j], K, trial)
        if z > cuts.bounds[j] - GAP * max(cuts.bounds[j], 1e-3):  # it cuts nothing off
            return FAILED, np.inf
    return all_proven(zs, cuts.proven, cuts.held, top, below)
