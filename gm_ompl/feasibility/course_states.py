"""Contact states along many screws, compiled: those that ``ArcStates`` finds of one."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple, final

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.compilation import compiled_as_written, inlined
from gm_ompl.contact.touching import NO_ROOM, Sheet, Solids, solids
from gm_ompl.feasibility.arc_states import PackedScrew, StateRoom, state_room, states_along
from gm_ompl.motion.arc import INSIDE
from gm_ompl.motion.courses import Courses
from gm_ompl.problem import Problem

USUAL = 8
"""Contacts of a state, about."""


class StatesFound(NamedTuple):
    """Contact states of screws, one behind the other.

    Attributes:
        counts: (m,), how many each screw has; 0: compiled code does not tell.
        room: where they are.
    """

    counts: IntArray
    room: StateRoom

    def keys(self) -> Iterator[bytes]:
        """Yield the states' keys, as ``contact_key`` has them."""
        ends = (8 * self.room.past[: self.counts.sum(), 1]).tolist()
        keys = self.room.keys[: ends[-1] // 8 if ends else 0].tobytes()
        return (keys[a:b] for a, b in itertools.pairwise([0, *ends]))


@final
class CourseStates:
    """Finds the contact states along screws.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: Problem) -> None:
        self._world = solids(problem.body, problem.environment)
        self._inside, self._D = problem.environment.patch_points, problem.body.diagonal
        self._ends = problem.motion.ends

    def along(self, courses: Courses) -> StatesFound:
        """Return the states in the middles of the segments of screws."""
        m, states = len(courses.parts), int(courses.parts.sum())
        contacts, counts, done = USUAL * (states + USUAL), np.zeros(m, dtype=np.int64), 0
        room = state_room(contacts, states)
        while done < m and not self._inside:
            done = states_of(courses, done, counts, self._ends, self._world, room, self._D)
            if done < m:
                contacts *= 2
                room = _larger(room, contacts, int(counts.sum()))
        return StatesFound(counts, room)


def _larger(old: StateRoom, contacts: int, states: int) -> StateRoom:
    """Return room for more contacts, the first states in it."""
    new = state_room(contacts, len(old.past))
    past, end = old.past[states - 1].tolist() if states else (0, 0)
    for name in ("points", "normals", "surfaces"):
        getattr(new.at, name)[:past] = getattr(old.at, name)[:past]
    new.slip[:past], new.keys[:end] = old.slip[:past], old.keys[:end]
    new.rotations[:states], new.past[:states] = old.rotations[:states], old.past[:states]
    return new


@compiled_as_written
def states_of(
    courses: Courses, first: int, counts: IntArray, ends: bool, world: Solids, found: StateRoom,
    D: float,
) -> int:  # fmt: skip
    """Write the contact states of screws from row ``first`` on, behind those of earlier rows.

    Returns:
        The first row for which there was no room; the number of rows where there was for all.
    """
    rotations, positions, by, axes, angles, _, _, parts, pitches = courses
    (points, normals, surfaces), slip, turned, marks, keys = found
    k, past, end, looks = 0, 0, 0, np.empty(parts.max() if len(parts) else 0)
    for i in range(first):
        k += counts[i]
    if k > 0:
        past, end = marks[k - 1, 0], marks[k - 1, 1]
    for i in range(first, len(parts)):
        for j in range(parts[i]):
            looks[j] = _look(j, parts[i], pitches[i], ends)
        screw = PackedScrew(rotations[i], positions[i], by[i], axes[i], angles[i], 1.0)
        onto = Sheet(points[past:], normals[past:], surfaces[past:])
        room = StateRoom(onto, slip[past:], turned[k:], marks[k:], keys[end:])
        added = states_along(screw, looks[: parts[i]], world, room, D)
        if added == NO_ROOM:
            return i
        counts[i] = 0
        if added >= 0:
            counts[i] = parts[i]
            for j in range(k, k + parts[i]):
                marks[j, 0] += past
                marks[j, 1] += end
            k += parts[i]
            past, end = marks[k - 1, 0], marks[k - 1, 1]
    return len(parts)


@inlined
def _look(j: int, parts: int, pitch: float, ends: bool) -> float:
    """Return the t at which segment ``j`` is judged, as ``Arc.looks`` has it."""
    if ends:
        return min(max(j / (parts - 1), INSIDE), 1.0 - INSIDE)
    if pitch == 1.0 / parts:
        return (2 * j + 1) / (2 * parts)
    return (j * pitch + (1.0 if j + 1 == parts else (j + 1) * pitch)) / 2.0
