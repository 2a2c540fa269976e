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
from gm_ompl.mechanics.cases import Cases, at_shifts, count_of, pressures, program_of
from gm_ompl.mechanics.certificate import Record
from gm_ompl.mechanics.common import common_commands
from gm_ompl.mechanics.each_case import position_margins
from gm_ompl.mechanics.equilibrium import equilibrium
from gm_ompl.mechanics.internal_force import FAILS, MARGINAL, PASSES
from gm_ompl.mechanics.kelley import mode_sets
from gm_ompl.mechanics.modes import (
    INTERNAL_FORCE,
    NO_EQUILIBRIUM,
    STABLE,
    UNDER,
    UNPROVEN,
    ask_squeeze,
    at_placements,
    chosen,
    passing_sets,
)
from gm_ompl.mechanics.program import Separation
from gm_ompl.mechanics.stability import BELOW, REACHED


class Surroundings(NamedTuple):
    """What the cases of one contact state have, forces over force_scale.

    Attributes:
        envs: (V, e, 6), the environment's columns, static contacts at their lowest friction.
        loads: (D, 6).
        squeeze: (e', 6), the columns of all worlds, with which (5) is asked.
        L: (76, 6), the directions.
    """

    envs: Array
    loads: Array
    squeeze: Array
    L: Array


class Tips(NamedTuple):
    """What the cases of a hand have.

    Attributes:
        tables: (Q, N, P, s, 6), all fingers' columns for unit normal force at all placements, at
            their lowest friction, per corner of a shift on the face.
        squeeze: (N, P, s', 6), those with which (5) is asked.
        f_max: (N,), over force_scale.
        command: the relative error of a command.
    """

    tables: Array
    squeeze: Array
    f_max: Array
    command: float


@compiled
def cases_at(around: Surroundings, tips: Tips, hand: IntArray, rows: IntArray) -> Cases:
    """Return the cases of fingers ``hand`` (n,) at their placements ``rows`` (n,)."""
    shifted, press = at_shifts(tips.tables, hand, rows), pressures(tips.command, len(hand))
    squeeze = at_placements(tips.squeeze, hand, rows)
    return Cases(
        around.envs, around.loads, shifted, press, tips.f_max[hand], around.L, around.squeeze,
        squeeze,
    )  # fmt: skip


@compiled
def decide_cases(
    cases: Cases, below: float, previous: int, only: int, f_com: Array, y: Array
) -> tuple[int, float, int, int, int]:
    """Decide Sec. 3.4 for all cases of fingers at some of their placements, and prove it.

    Arguments and answers are those of ``modes.decide``, and the number of the load under which
    ``y`` is a cut, with the first of the fingertips' tables.
    """
    n, loads = len(cases.f_max), len(cases.loads)
    everyone = (1 << n) - 1
    f_com[:], y[:] = 0.0, 0.0
    end, separation = ask_squeeze(cases.around, cases.squeeze, everyone if only < 0 else only)
    if end == MARGINAL or (end == FAILS and only >= 0):
        return UNPROVEN, np.inf, -1, 0, 0
    tight = end == PASSES and (only < 0 or only == everyone)
    z, direction, mask, of = 0.0, -1, everyone, 0
    if only < 0 or tight:
        end, z, direction, of = position_margins(cases, separation, below, tight, y)
        if end == BELOW:
            return UNDER, z, direction, everyone, of % loads
        if tight and end != REACHED:
            return UNPROVEN, np.inf, -1, 0, of % loads
    if not tight:
        passed, passes = np.empty(1 << n, dtype=np.int64), 1
        passed[0] = only
        if only < 0:
            passes, separation = passing_sets(cases.around, cases.squeeze, previous, True, passed)
        if passes <= 0:
            return INTERNAL_FORCE if passes == 0 else UNPROVEN, -np.inf, -1, 0, of % loads
        sets = mode_sets(passed[:passes], n)
        end, z = common_commands(cases, separation, below, sets, y.copy(), of)
        end, z, direction, mask = chosen(end, z, sets, f_com)
        if end != STABLE:
            return end, z, direction, mask, of % loads
    if z < 0.0:
        return NO_EQUILIBRIUM, -np.inf, -1, 0, of % loads
    if z <= 0.0:
        end = _equilibrium(cases, separation)
        if end != REACHED or mask != everyone:
            return NO_EQUILIBRIUM if end == BELOW else UNPROVEN, -np.inf, -1, 0, of % loads
    return STABLE, max(z, 0.0), direction, mask, of % loads


@compiled
def _equilibrium(cases: Cases, separation: Separation) -> int:
    """Whether some forces balance the load in every case, whatever is commanded."""
    record = Record(np.empty(0, np.int64), np.empty((0, 0, 6)), np.empty((0, 0, 0)))
    free = np.empty(len(cases.f_max))
    one = len(cases.envs) * len(cases.loads) * len(cases.tips)
    for c in range(min(count_of(cases), one)):
        end = equilibrium(program_of(cases, c), separation, record, free)
        if end != REACHED:
            return end
    return REACHED


@compiled
def decide_case_rows(
    around: Surroundings, tips: Tips, below: float, rows: IntArray, which: IntArray,
    answers: Decisions,
) -> None:  # fmt: skip
    """Decide some rows at one contact state; other threads may treat other rows meanwhile.

    Args:
        around: the contact state.
        tips: the hand.
        below: threshold; 0 decides exactly.
        rows: (K, n), placements.
        which: the rows to decide.
        answers: output, per row.
    """
    hand = np.arange(len(tips.f_max))
    for k in which:
        cases = cases_at(around, tips, hand, rows[k])
        how, answers.zs[k], answers.directions[k], answers.masks[k], answers.loads[k] = (
            decide_cases(cases, below, -1, -1, answers.commands[k], answers.wrenches[k])
        )
        answers.ends[k] = how
