"""Sec. 3.4 for all cases at once, compiled: modes and f_com are chosen before the world is known.

Problem (5) is asked once, of the columns of all cases together. z is the least of the cases; the
order of mode sets by z holds in each of them, and so for the least.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.batch import Decisions
from gm_ompl.mechanics.cases import Cases, at_shifts, count_of, parts_of, pressures
from gm_ompl.mechanics.certificate import Record, separates_environment
from gm_ompl.mechanics.commands import TIE
from gm_ompl.mechanics.common import common_commands
from gm_ompl.mechanics.each_case import position_margins
from gm_ompl.mechanics.equilibrium import equilibrium
from gm_ompl.mechanics.internal_force import FAILS, MARGINAL, PASSES, separate
from gm_ompl.mechanics.modes import (
    INTERNAL_FORCE,
    NO_EQUILIBRIUM,
    STABLE,
    UNDER,
    UNPROVEN,
    at_placements,
    passing_sets,
    unit_columns,
)
from gm_ompl.mechanics.stability import BELOW, REACHED


class Surroundings(NamedTuple):
    """What the cases of one contact state have, forces over force_scale.

    Attributes:
        envs: (V, e, 6), the environment's columns, static contacts at their lowest friction.
        loads: (D, 6).
        squeeze: (e', 6), the columns of all worlds, with which (5) is asked.
    """

    envs: Array
    loads: Array
    squeeze: Array


class Tips(NamedTuple):
    """What the cases of a hand have.

    Attributes:
        tables: (Q, N, P, s, 6), all fingers' columns for unit normal force at all placements, at
            their lowest friction, per corner of a shift on the face.
        squeeze: (N, P, s', 6), those with which (5) is asked.
        command: the relative error of a command.
    """

    tables: Array
    squeeze: Array
    command: float


@compiled
def _best_common(
    cases: Cases, f_max: Array, most: Array, L: Array, below: float, passed: IntArray,
    first: Array, of: int, w: Array, margin: float, f_com: Array,
) -> tuple[int, float, int, int]:  # fmt: skip
    """Return (end, z or its bound, direction, mask) of the best of the passing sets."""
    count = len(passed)
    zs, limiting = np.empty(count), np.empty(count, dtype=np.int64)
    commands = np.empty((count, len(f_max)))
    end, bound = common_commands(
        cases, f_max, most, L, below, passed, first, of, w, margin, zs, limiting, commands
    )
    if end == BELOW:
        return UNDER, max(bound, 0.0), -1, 0
    if end == REACHED:
        top = zs.max()
        for j in range(count):
            if zs[j] >= top * (1.0 - TIE):
                f_com[:] = commands[j]
                return STABLE, zs[j], limiting[j], passed[j]
    return UNPROVEN, np.inf, -1, 0


@compiled
def decide_cases(
    around: Surroundings, tips: Tips, hand: IntArray, rows: IntArray, f_max: Array, L: Array,
    below: float, previous: int, only: int, f_com: Array, y: Array,
) -> tuple[int, float, int, int, int]:  # fmt: skip
    """Decide Sec. 3.4 for all cases of fingers at some of their placements, and prove it.

    Arguments and answers are those of ``modes.decide``, and the number of the load under which
    ``y`` is a cut, with the first of the fingertips' tables.
    """
    n, loads = len(hand), len(around.loads)
    everyone = (1 << n) - 1
    squeeze, limits = at_placements(tips.squeeze, hand, rows, f_max)
    P, w = np.empty((len(around.squeeze) + n * squeeze.shape[1], 6)), np.empty(6)
    asked = everyone if only < 0 else only
    end, margin = separate(P, unit_columns(around.squeeze, squeeze, asked, P), w)
    f_com[:], y[:] = 0.0, 0.0
    if end == MARGINAL or (end == FAILS and only >= 0):
        return UNPROVEN, np.inf, -1, 0, 0
    tight = end == PASSES and (only < 0 or only == everyone)
    if end == FAILS:
        margin = separates_environment(around.squeeze, w)
    cases = Cases(
        around.envs, around.loads, at_shifts(tips.tables, hand, rows), pressures(tips.command, n)
    )
    z, direction, mask, of = 0.0, -1, everyone, 0
    if only < 0 or tight:
        end, z, direction, of = position_margins(cases, limits, L, below, tight, w, margin, y)
        if end == BELOW:
            return UNDER, z, direction, everyone, of % loads
        if tight and end != REACHED:
            return UNPROVEN, np.inf, -1, 0, of % loads
    if not tight:
        passed, passes = np.empty(1 << n, dtype=np.int64), 1
        passed[0] = only
        if only < 0:
            passes, margin = passing_sets(around.squeeze, squeeze, previous, True, passed, w)
        if passes <= 0:
            return INTERNAL_FORCE if passes == 0 else UNPROVEN, -np.inf, -1, 0, of % loads
        most = limits / (1.0 + tips.command)
        end, z, direction, mask = _best_common(
            cases, limits, most, L, below, passed[:passes], y.copy(), of, w, margin, f_com
        )
        if end != STABLE:
            return end, z, direction, mask, of % loads
    if z < 0.0:
        return NO_EQUILIBRIUM, -np.inf, -1, 0, of % loads
    if z <= 0.0:
        end = _equilibrium(cases, limits, L, w, margin)
        if end != REACHED or mask != everyone:
            return NO_EQUILIBRIUM if end == BELOW else UNPROVEN, -np.inf, -1, 0, of % loads
    return STABLE, max(z, 0.0), direction, mask, of % loads


@compiled
def _equilibrium(cases: Cases, f_max: Array, L: Array, w: Array, margin: float) -> int:
    """Whether some forces balance the load in every case, whatever is commanded."""
    record = Record(np.empty(0, np.int64), np.empty((0, 0, 6)), np.empty((0, 0, 0)))
    free, one = np.empty(len(f_max)), len(cases.envs) * len(cases.loads) * len(cases.tips)
    for c in range(min(count_of(cases), one)):
        env, load, tip, _ = parts_of(cases, c)
        end = equilibrium(
            cases.envs[env], cases.loads[load], cases.tips[tip], f_max, L, w, margin, record, free
        )
        if end != REACHED:
            return end
    return REACHED


@compiled
def decide_case_rows(
    around: Surroundings, tips: Tips, f_max: Array, L: Array, below: float, rows: IntArray,
    which: IntArray, answers: Decisions, loads: IntArray,
) -> None:  # fmt: skip
    """Decide some rows at one contact state; other threads may treat other rows meanwhile.

    Args:
        around: the contact state.
        tips: the hand.
        f_max: (n,), over force_scale, as all forces here.
        L: (76, 6), the directions.
        below: threshold; 0 decides exactly.
        rows: (K, n), placements.
        which: the rows to decide.
        answers: output, per row.
        loads: output (K,): the number of the load of each answer's cut.
    """
    hand = np.arange(len(f_max))
    for k in which:
        how, answers.zs[k], answers.directions[k], answers.masks[k], loads[k] = decide_cases(
            around, tips, hand, rows[k], f_max, L, below, -1, -1, answers.commands[k],
            answers.wrenches[k],
        )  # fmt: skip
        answers.ends[k] = how
