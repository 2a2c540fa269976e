"""Many mode decisions in one call, compiled: contact states and sets of placements by number."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import Record
from gm_ompl.mechanics.modes import decide


class States(NamedTuple):
    """Contact states, one after the other.

    Attributes:
        env: (columns of all states, 6), the environments' columns.
        first: (states + 1,), where each state's columns begin.
        loads: (states, 6).
    """

    env: Array
    first: IntArray
    loads: Array


class Decisions(NamedTuple):
    """The answers of ``decide``, one row per decision.

    Attributes:
        ends: (K,), how each ended.
        zs: (K,), z or a bound on it.
        directions: (K,), limiting directions.
        masks: (K,), position-controlled fingers as bits.
        commands: (K, n), f_com.
        wrenches: (K, 6), wrenches of cuts; zero where there is none.
    """

    ends: IntArray
    zs: Array
    directions: IntArray
    masks: IntArray
    commands: Array
    wrenches: Array


def unanswered(count: int, fingers: int) -> Decisions:
    """Return room for ``count`` decisions."""
    return Decisions(
        np.zeros(count, dtype=np.int64),
        np.zeros(count),
        np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.zeros((count, fingers)),
        np.zeros((count, 6)),
    )


@compiled
def decide_rows(
    states: States, tips: Array, f_max: Array, L: Array, below: float, which: IntArray,
    rows: IntArray, begin: int, end: int, answers: Decisions,
) -> None:  # fmt: skip
    """Decide rows ``begin`` to ``end``; other threads may treat other rows meanwhile.

    Args:
        states: the contact states.
        tips: (n, P, s, 6), the fingers' columns for unit normal force at every placement.
        f_max: (n,), over force_scale, as all forces here.
        L: (76, 6), the directions.
        below: threshold; 0 decides exactly.
        which: (K,), the contact state of each decision.
        rows: (K, n), its placements.
        begin: the first row.
        end: one past the last row.
        answers: output.
    """
    hand = np.arange(len(f_max))
    record = Record(np.empty(0, np.int64), np.empty((0, 0, 6)), np.empty((0, 0, 0)))
    for k in range(begin, end):
        state = which[k]
        env = states.env[states.first[state] : states.first[state + 1]]
        how, answers.zs[k], answers.directions[k], answers.masks[k] = decide(
            env, states.loads[state], tips, hand, rows[k], f_max, L, below, -1, -1,
            record, answers.commands[k], answers.wrenches[k],
        )  # fmt: skip
        answers.ends[k] = how
