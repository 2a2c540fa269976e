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
from gm_ompl.mechanics.commands import TIE, best_commands
from gm_ompl.mechanics.internal_force import excessive
from gm_ompl.mechanics.stability import BELOW, REACHED, equilibrium, position_margin

STABLE, INTERNAL_FORCE, NO_EQUILIBRIUM, UNDER, TROUBLE = 0, 1, 2, 3, 4
"""Ends of a decision; UNDER: z is proven smaller than the threshold, and a bound is returned."""


@compiled
def unit_columns(env: Array, tips: Array, mask: int, P: Array) -> int:
    """Write the columns of Problem (5) for a set, each of unit norm in (7); return their number."""
    K = 0
    for j in range(len(env)):
        norm = np.sqrt((env[j] * env[j]).sum())
        for t in range(6):
            P[K, t] = env[j, t] / norm
        K += 1
    for i in range(len(tips)):
        if (mask >> i) & 1:
            for k in range(tips.shape[1]):
                norm = np.sqrt((tips[i, k] * tips[i, k]).sum())
                for t in range(6):
                    P[K, t] = tips[i, k, t] / norm
                K += 1
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
def passing_sets(env: Array, tips: Array, previous: int, passed: IntArray) -> int:
    """Write the largest sets that pass Problem (5), preferred first; return their number."""
    n = len(tips)
    order = preference(n, previous)
    P = np.empty((len(env) + n * tips.shape[1], 6))
    passes = 0
    for mask in order:
        covered = False
        for j in range(passes):
            covered = covered or (mask & passed[j]) == mask
        if covered:
            continue
        if excessive(P, unit_columns(env, tips, mask, P)):
            continue
        passed[passes] = mask
        passes += 1
    return passes


@inlined
def _best_set(
    env: Array, q: Array, tips: Array, f_max: Array, L: Array, below: float,
    passed: IntArray, first: Array, f_com: Array,
) -> tuple[int, float, int, int]:  # fmt: skip
    """Return (end, z or its bound, direction, mask) of the best of the passing sets."""
    count = len(passed)
    zs, limiting = np.empty(count), np.empty(count, dtype=np.int64)
    commands = np.empty((count, len(tips)))
    end, bound = best_commands(env, q, tips, f_max, L, below, passed, first, zs, limiting, commands)
    if end == BELOW:
        return UNDER, max(bound, 0.0), -1, 0
    if end == REACHED:
        top = zs.max()
        for j in range(count):
            if zs[j] >= top * (1.0 - TIE):
                f_com[:] = commands[j]
                return STABLE, zs[j], limiting[j], passed[j]
    return TROUBLE, 0.0, -1, 0


@compiled
def decide(
    env: Array, q: Array, tips: Array, f_max: Array, L: Array, below: float, previous: int,
    f_com: Array, y: Array,
) -> tuple[int, float, int, int]:  # fmt: skip
    """Decide Sec. 3.4.

    Args:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale, as all forces here.
        L: (76, 6), the directions.
        below: threshold; 0 decides exactly.
        previous: mask of the previous segment, preferred among ties; -1 for none.
        f_com: output (n,): commands of the force-controlled fingers.
        y: output (6,): the wrench of a cut on z under position control of all fingers, valid for
            any modes and, as a cut, for any placements; zero where there is none.

    Returns:
        How it ended, z (UNDER: an upper bound on z), the limiting direction, the mask.
    """
    n = len(tips)
    everyone = (1 << n) - 1
    P = np.empty((len(env) + n * tips.shape[1], 6))
    tight = not excessive(P, unit_columns(env, tips, everyone, P))
    end, z, direction = position_margin(env, q, tips, f_max, L, below, tight, y)
    if end == BELOW:
        return UNDER, z, direction, everyone
    if tight and end != REACHED:
        return TROUBLE, 0.0, -1, 0
    if tight:
        f_com[:] = 0.0
        mask = everyone
    else:
        passed = np.empty(1 << n, dtype=np.int64)
        passes = passing_sets(env, tips, previous, passed)
        if passes == 0:
            return INTERNAL_FORCE, -np.inf, -1, 0
        end, z, direction, mask = _best_set(
            env, q, tips, f_max, L, below, passed[:passes], y, f_com
        )
        if end != STABLE:
            return end, z, direction, mask
    if z <= 0.0 and not equilibrium(env, q, tips, f_max, L, f_com):
        return NO_EQUILIBRIUM, -np.inf, -1, 0
    return STABLE, max(z, 0.0), direction, mask
