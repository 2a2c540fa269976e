"""Many mode decisions in one call, compiled: contact states and sets of placements by number."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import Record
from gm_ompl.mechanics.modes import decide
from gm_ompl.mechanics.program import Touch


class States(NamedTuple):
    """Contact states, one after the other, and the hand that is asked about at them.

    Attributes:
        env: (columns of all states, 6), the environments' columns.
        first: (states + 1,), where each state's columns begin.
        loads: (states, 6).
        tips: (n, P, s, 6), the fingers' columns for unit normal force at every placement.
        f_max: (n,), over force_scale, as all forces here.
        L: (76, 6), the directions.
    """

    env: Array
    first: IntArray
    loads: Array
    tips: Array
    f_max: Array
    L: Array


class Decisions(NamedTuple):
    """The answers of ``decide``, one row per decision.

    Attributes:
        ends: (K,), how each ended.
        zs: (K,), z or a bound on it.
        directions: (K,), limiting directions.
        masks: (K,), position-controlled fingers as bits.
        commands: (K, n), f_com.
        wrenches: (K, 6), wrenches of cuts; zero where there is none.
        loads: (K,), of several loads the number of the one that a cut is for.
    """

    ends: IntArray
    zs: Array
    directions: IntArray
    masks: IntArray
    commands: Array
    wrenches: Array
    loads: IntArray

    def part(self, rows: slice) -> Decisions:
        """Return some of the answers, to be written into."""
        return Decisions._make(each[rows] for each in self)


def unanswered(count: int, fingers: int) -> Decisions:
    """Return room for ``count`` decisions."""
    return Decisions(
        np.zeros(count, dtype=np.int64),
        np.zeros(count),
        np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.zeros((count, fingers)),
        np.zeros((count, 6)),
        np.zeros(count, dtype=np.int64),
    )


@compiled
def decide_rows(
    states: States, below: float, which: IntArray, rows: IntArray, answers: Decisions
) -> None:
    """Decide some rows; other threads may treat others meanwhile.

    Args:
        states: the contact states and the hand.
        below: threshold; 0 decides exactly.
        which: (K,), the contact state of each decision.
        rows: (K, n), its placements.
        answers: output.
    """
    # Taken apart once: numba counts every use of every array of a tuple.
    env, first, loads, tips, f_max, L = states
    ends, zs, directions, masks, commands, wrenches, _ = answers
    hand = np.arange(len(f_max))
    record = Record(np.empty(0, np.int64), np.empty((0, 0, 6)), np.empty((0, 0, 0)))
    for k in range(len(which)):
        begin, end = first[which[k]], first[which[k] + 1]
        touch = Touch(env[begin:end], loads[which[k]], tips, f_max, L, hand, rows[k])
        ends[k], zs[k], directions[k], masks[k] = decide(
            touch, below, -1, -1, record, commands[k], wrenches[k]
        )
