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
from gm_ompl.mechanics.kelley import ModeSets, mode_sets
from gm_ompl.mechanics.program import Program, Separation, Touch
from gm_ompl.mechanics.stability import BELOW, FAILED, REACHED, position_margin
from gm_ompl.mechanics.tau import UNUSED, Tableau, new_tableau

STABLE, INTERNAL_FORCE, NO_EQUILIBRIUM, UNDER, UNPROVEN = 0, 1, 2, 3, 4
"""Ends of a decision, all proven but the last: UNDER: z is smaller than the threshold, and a bound
is returned; UNPROVEN: no answer came with a proof."""


@compiled
def at_placements(table: Array, hand: IntArray, rows: IntArray) -> Array:
    """Return a hand's columns (k, s, 6) at its placements, of a table (n, P, s, 6)."""
    s = table.shape[2]
    tips = np.empty((len(hand), s, 6))
    for i in range(len(hand)):
        for k in range(s):
            for t in range(6):
                tips[i, k, t] = table[hand[i], rows[i], k, t]
    return tips


@inlined
def _program_of(touch: Touch) -> Program:
    """Return the data of fingers at their placements."""
    env, q, table, f_max, L, hand, rows = touch
    limits = np.empty(len(hand))
    for i in range(len(hand)):
        limits[i] = f_max[hand[i]]
    return Program(env, q, at_placements(table, hand, rows), limits, L)


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
    env: Array, tips: Array, previous: int, not_all: bool, passed: IntArray
) -> tuple[int, Separation]:
    """Write the largest sets that pass Problem (5), preferred first; return their number.

    Args:
        env: (e, 6), the environment's columns.
        tips: (n, s, 6), the fingers' columns.
        previous: mask of the previous segment, preferred among equals; -1 for none.
        not_all: all fingers together are known not to pass.
        passed: output (sets,).

    Returns:
        How many pass, -1 where Problem (5) is too close to call for some set; and a separation of
        the columns of one of these sets, the environment's among them.
    """
    n = len(tips)
    order = preference(n, previous)
    P, x, w = np.empty((len(env) + n * tips.shape[1], 6)), np.empty(6), np.zeros(6)
    passes, widest = 0, 0.0
    for mask in order:
        covered = not_all and mask == (1 << n) - 1
        for j in range(passes):
            covered = covered or (mask & passed[j]) == mask
        if covered:
            continue
        end, margin = separate(P, unit_columns(env, tips, mask, P), x)
        if end == MARGINAL:
            return -1, Separation(w, 0.0)
        if end == FAILS:
            continue
        passed[passes] = mask
        passes += 1
        if margin > widest:
            widest = margin
            for t in range(6):
                w[t] = x[t]
    return passes, Separation(w, widest)


@inlined
def ask_squeeze(env: Array, tips: Array, mask: int) -> tuple[int, Separation]:
    """Ask Problem (5) of a set; the separation is of its columns, or of the environment's alone."""
    P, w = np.empty((len(env) + len(tips) * tips.shape[1], 6)), np.empty(6)
    end, margin = separate(P, unit_columns(env, tips, mask, P), w)
    return end, separates_environment(env) if end == FAILS else Separation(w, margin)


@inlined
def chosen(end: int, bound: float, sets: ModeSets, f_com: Array) -> tuple[int, float, int, int]:
    """Return (end, z or its bound, direction, mask) of the best of sets; write its f_com (n,).

    ``end`` and ``bound`` are what ``best_commands`` returned.
    """
    if end == BELOW:
        return UNDER, max(bound, 0.0), -1, 0
    if end == REACHED:
        top = sets.zs.max()
        for j in range(len(sets.zs)):
            if sets.zs[j] >= top * (1.0 - TIE):
                for i in range(len(f_com)):
                    f_com[i] = sets.commands[j, i]
                return STABLE, sets.zs[j], sets.limiting[j], sets.masks[j]
    return UNPROVEN, np.inf, -1, 0


@inlined
def _commanded(
    program: Program, separation: Separation, below: float, sets: ModeSets, first: Array,
    seed: Tableau, record: Record,
) -> tuple[int, float]:  # fmt: skip
    """Do as ``best_commands``, a second time without what position control has left."""
    end, bound = FAILED, np.inf
    for _ in range(2):
        end, bound = best_commands(program, separation, below, sets, first, seed, record)
        if end in (BELOW, REACHED):
            break
        # It may be what leads astray.
        seed.basis[0], record.sets[:], first[:] = UNUSED, -1, 0.0
    return end, bound


@compiled
def decide(
    touch: Touch, below: float, previous: int, only: int, record: Record, f_com: Array, y: Array
) -> tuple[int, float, int, int]:
    """Decide Sec. 3.4 for fingers at some of their placements, and prove it.

    Args:
        touch: what acts, and the fingers.
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
    program = _program_of(touch)
    env, _, tips, _, _ = program
    n, everyone = len(tips), (1 << len(tips)) - 1
    f_com[:], y[:] = 0.0, 0.0
    end, separation = ask_squeeze(env, tips, everyone if only < 0 else only)
    if end == MARGINAL or (end == FAILS and only >= 0):
        return UNPROVEN, np.inf, -1, 0
    tight = end == PASSES and (only < 0 or only == everyone)
    z, direction, mask, tableau = 0.0, -1, everyone, new_tableau(n, len(env), tips.shape[1])
    if only < 0 or tight:
        end, z, direction = position_margin(program, separation, below, tight, tableau, y)
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
            passes, separation = passing_sets(env, tips, previous, True, passed)
        if passes <= 0:
            return INTERNAL_FORCE if passes == 0 else UNPROVEN, -np.inf, -1, 0
        sets = mode_sets(passed[:passes], n)
        end, z = _commanded(program, separation, below, sets, y.copy(), tableau, record)
        end, z, direction, mask = chosen(end, z, sets, f_com)
        if end != STABLE:
            return end, z, direction, mask
    if z < 0.0:
        return NO_EQUILIBRIUM, -np.inf, -1, 0
    if z <= 0.0:
        end = equilibrium(program, separation, record, f_com)
        if end != REACHED:
            return NO_EQUILIBRIUM if end == BELOW else UNPROVEN, -np.inf, -1, 0
    return STABLE, max(z, 0.0), direction, mask
