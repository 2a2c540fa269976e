"""Sec. 3.4, compiled: the best combination of control modes at an instant.

Mode sets are ordered: a force-controlled finger's forces are among those of the same finger under
position control, so z can only fall from position to force control; and a set of
position-controlled fingers that can build up internal force still can with one finger more. The
best combination is therefore among the largest sets of position-controlled fingers that pass (5).
A set is a bit mask: bit i is set where finger i is position-controlled.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.certificate import Record, separates_environment, write_down
from gm_ompl.mechanics.commands import TIE, best_commands
from gm_ompl.mechanics.equilibrium import equilibrium
from gm_ompl.mechanics.internal_force import FAILS, MARGINAL, PASSES, separate
from gm_ompl.mechanics.kelley import UNUSED
from gm_ompl.mechanics.stability import (
    BELOW,
    REACHED,
    Tableau,
    new_tableau,
    position_margin,
)

STABLE, INTERNAL_FORCE, NO_EQUILIBRIUM, UNDER, UNPROVEN = 0, 1, 2, 3, 4
"""Ends of a decision, all proven but the last: UNDER: z is smaller than the threshold, and a bound
is returned; UNPROVEN: no answer came with a proof."""


@compiled
def at_placements(
    table: Array, hand: IntArray, rows: IntArray, f_max: Array
) -> tuple[Array, Array]:
    """Return a hand's columns (k, s, 6) at its placements, and its limits (k,)."""
    s = table.shape[2]
    tips, limits = np.empty((len(hand), s, 6)), np.empty(len(hand))
    for i in range(len(hand)):
        limits[i] = f_max[hand[i]]
        for k in range(s):
            for t in range(6):
                tips[i, k, t] = table[hand[i], rows[i], k, t]
    return tips, limits


@compiled
def unit_columns(env: Array, tips: Array, mask: int, P: Array) -> int:
    """Write the columns of Problem (5) for a set, each of unit norm in (7); return their number."""
    K = 0
    for j in range(len(env)):
        for t in range(6):
            P[K, t] = env[j, t]
        K += 1
    for i in range(len(tips)):
        if (mask >> i) & 1:
            for k in range(tips.shape[1]):
                for t in range(6):
                    P[K, t] = tips[i, k, t]
                K += 1
    for j in range(K):
        square = 0.0
        for t in range(6):
            square += P[j, t] * P[j, t]
        norm = np.sqrt(square)
        for t in range(6):
            P[j, t] /= norm
    return K


@compiled
def preference(n: int, previous: int) -> IntArray:
    """Return all masks, preferred first: more bits, then ``previous``, then lexicographic."""
    order = np.empty(1 << n, dtype=np.int64)
    count = 0
    for bits in range(n, -1, -1):
        first = count
        # Lexicographic with position before force: finger 0 weighs most.
        for code in range((1 << n) - 1, -1, -1):
            mask, ones = 0, 0
            for i in range(n):
                if (code >> (n - 1 - i)) & 1:
                    mask |= 1 << i
                    ones += 1
            if ones == bits:
                order[count] = mask
                if mask == previous:
                    for j in range(count, first, -1):
                        order[j] = order[j - 1]
                    order[first] = mask
                count += 1
    return order


@compiled
def passing_sets(
    env: Array, tips: Array, previous: int, not_all: bool, passed: IntArray, w: Array
) -> tuple[int, float]:
    """Write the largest sets that pass Problem (5), preferred first; return their number.

    Args:
        env: (e, 6), the environment's columns.
        tips: (n, s, 6), the fingers' columns.
        previous: mask of the previous segment, preferred among equals; -1 for none.
        not_all: all fingers together are known not to pass.
        passed: output (sets,).
        w: output (6,), a wrench that separates the columns of one of these sets, the environment's
            among them.

    Returns:
        How many pass, -1 where Problem (5) is too close to call for some set; and the margin by
        which ``w`` separates, see ``into_polar``.
    """
    n = len(tips)
    order = preference(n, previous)
    P, x = np.empty((len(env) + n * tips.shape[1], 6)), np.empty(6)
    passes, widest = 0, 0.0
    for mask in order:
        covered = not_all and mask == (1 << n) - 1
        for j in range(passes):
            covered = covered or (mask & passed[j]) == mask
        if covered:
            continue
        end, margin = separate(P, unit_columns(env, tips, mask, P), x)
        if end == MARGINAL:
            return -1, 0.0
        if end == FAILS:
            continue
        passed[passes] = mask
        passes += 1
        if margin > widest:
            widest = margin
            for t in range(6):
                w[t] = x[t]
    return passes, widest


@inlined
def _best_set(
    env: Array, q: Array, tips: Array, f_max: Array, L: Array, below: float,
    passed: IntArray, first: Array, w: Array, margin: float, seed: Tableau, record: Record,
    f_com: Array,
) -> tuple[int, float, int, int]:  # fmt: skip
    """Return (end, z or its bound, direction, mask) of the best of the passing sets."""
    count = len(passed)
    zs, limiting = np.empty(count), np.empty(count, dtype=np.int64)
    commands = np.empty((count, len(tips)))
    end, bound = best_commands(
        env, q, tips, f_max, L, below, passed, first, w, margin, seed, record, zs,
        limiting, commands,
    )  # fmt: skip
    if end == BELOW:
        return UNDER, max(bound, 0.0), -1, 0
    if end == REACHED:
        top = 0.0
        for j in range(count):
            top = max(top, zs[j])
        for j in range(count):
            if zs[j] >= top * (1.0 - TIE):
                for i in range(len(f_com)):
                    f_com[i] = commands[j, i]
                return STABLE, zs[j], limiting[j], passed[j]
    return UNPROVEN, np.inf, -1, 0


@compiled
def decide(
    env: Array, q: Array, table: Array, hand: IntArray, rows: IntArray, f_max: Array, L: Array,
    below: float, previous: int, only: int, record: Record, f_com: Array, y: Array,
) -> tuple[int, float, int, int]:  # fmt: skip
    """Decide Sec. 3.4 for fingers at some of their placements, and prove it.

    Args:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        table: (N, P, s, 6), all fingers' columns for unit normal force at all placements.
        hand: (n,), the fingers that touch.
        rows: (n,), where.
        f_max: (N,), over force_scale, as all forces here.
        L: (76, 6), the directions.
        below: threshold; 0 decides exactly.
        previous: mask of the previous segment, preferred among ties; -1 for none.
        only: mask of the one set to consider, which must pass (5); -1 for all.
        record: output, what proves it; ``certificate.NO_RECORD`` keeps nothing.
        f_com: output (n,): commands of the force-controlled fingers.
        y: output (6,): the wrench of a cut on z under position control of all fingers, valid for
            any modes and, as a cut, for any placements; zero where there is none.

    Returns:
        How it ended, z (UNDER: an upper bound on z), the limiting direction, the mask.
    """
    n = len(hand)
    everyone = (1 << n) - 1
    tips, limits = at_placements(table, hand, rows, f_max)
    P, w = np.empty((len(env) + n * tips.shape[1], 6)), np.empty(6)
    end, margin = separate(P, unit_columns(env, tips, everyone if only < 0 else only, P), w)
    for i in range(n):
        f_com[i] = 0.0
    for t in range(6):
        y[t] = 0.0
    if end == MARGINAL or (end == FAILS and only >= 0):
        return UNPROVEN, np.inf, -1, 0
    tight = end == PASSES and (only < 0 or only == everyone)
    if end == FAILS:
        margin = separates_environment(env, w)
    z, direction, mask = 0.0, -1, everyone
    tableau = new_tableau(n, len(env), tips.shape[1])
    tableau.basis[0] = UNUSED
    if only < 0 or tight:
        end, z, direction = position_margin(
            env, q, tips, limits, L, below, tight, tableau, w, margin, y
        )
        solved = tight and end == REACHED and z > 0.0
        write_down(record, 0, everyone, y.reshape(1, 6), tableau.found, solved)
        if end == BELOW:
            return UNDER, z, direction, everyone
        if tight and end != REACHED:
            return UNPROVEN, np.inf, -1, 0
    if not tight:
        record.sets[:] = -1
        passed, passes = np.empty(1 << n, dtype=np.int64), 1
        passed[0] = only
        if only < 0:
            passes, margin = passing_sets(env, tips, previous, True, passed, w)
        if passes <= 0:
            return INTERNAL_FORCE if passes == 0 else UNPROVEN, -np.inf, -1, 0
        hint = y.copy()
        for _ in range(2):
            end, z, direction, mask = _best_set(
                env, q, tips, limits, L, below, passed[:passes], hint, w, margin, tableau, record,
                f_com,
            )  # fmt: skip
            if end != UNPROVEN:
                break
            # What position control has left may be what leads astray.
            tableau.basis[0] = UNUSED
            record.sets[:], hint[:] = -1, 0.0
        if end != STABLE:
            return end, z, direction, mask
    if z < 0.0:
        return NO_EQUILIBRIUM, -np.inf, -1, 0
    if z <= 0.0:
        end = equilibrium(env, q, tips, limits, L, w, margin, record, f_com)
        if end != REACHED:
            return NO_EQUILIBRIUM if end == BELOW else UNPROVEN, -np.inf, -1, 0
    return STABLE, max(z, 0.0), direction, mask
