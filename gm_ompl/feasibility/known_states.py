"""The contact states that mode decisions were asked for, numbered."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Final, TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.state import ContactState
from gm_ompl.cores import share_out
from gm_ompl.feasibility.arc_states import ArcStates
from gm_ompl.feasibility.keys import contact_key
from gm_ompl.feasibility.state_store import StateStore
from gm_ompl.motion.arc import Arc
from gm_ompl.problem import Problem

if TYPE_CHECKING:
    from gm_ompl.feasibility.course_states import CourseStates, StatesFound
    from gm_ompl.motion.courses import Courses

Told: TypeAlias = Callable[[int, ContactState], object] | None
"""Who is told of a new contact state."""

AT_ONCE: Final = 1000
"""Screws between two looks at the limits in force."""

A_THREAD: Final = 100
"""Screws that take longer than it takes to start a thread."""

NONE: Final = -1
"""No state's number."""


@final
class KnownStates:
    """Numbers contact states; equal ones get the same number.

    Args:
        problem: the problem.
        U: (6, 6), of the norm (7).
        weight: the object's, over the unit of force.

    Attributes:
        store: the states by their numbers, as they were first registered.
    """

    def __init__(self, problem: Problem, U: Array, weight: float) -> None:
        self._problem = problem
        self._arc = ArcStates(problem)
        self._numbers: dict[bytes, int] = {}
        self.store = StateStore(problem, U, weight)

    @cached_property
    def _courses(self) -> CourseStates:
        from gm_ompl.feasibility.course_states import CourseStates  # free motion alone asks

        return CourseStates(self._problem)

    def number(self, contacts: ContactState, told: Told) -> int:
        """Return a contact state's number."""
        key = contact_key(contacts, self._problem.body.diagonal)
        known = self._numbers.get(key)
        return self._register(key, contacts, told) if known is None else known

    def along(self, arc: Arc, parts: int, told: Told) -> list[int] | None:
        """Return the numbers of the states in the middles of an arc's segments.

        None where ``ArcStates`` does not find them.
        """
        found, numbers = self._arc.along(arc, parts), list[int]()
        if found is None:
            return None
        for k, key in enumerate(found):
            known = self._numbers.get(key)
            if known is None:
                known = self._register(key, self._arc.state(k), told)
            numbers.append(known)
        return numbers

    def _register(self, key: bytes, contacts: ContactState, told: Told) -> int:
        number = len(self.store)
        self.store.add(contacts)
        if told is not None:
            told(number, contacts)
        self._numbers[key] = number  # last: Ctrl-C may come before
        return number

    def along_courses(self, courses: Courses, told: Told) -> IntArray:
        """Return the numbers (m, parts) of the states in the middles of screws' segments.

        Behind the last of a screw, and of one whose states compiled code does not tell, they are
        -1.

        Raises:
            LimitError: a limit in force is reached.
        """
        numbers = np.full((len(courses.parts), courses.parts.max(initial=0)), NONE)
        found: dict[int, StatesFound] = {}
        finder = self._courses

        def work(part: slice) -> None:
            found[part.start] = finder.along(courses.some(part))

        share_out(work, len(numbers), A_THREAD, AT_ONCE)
        for first, states in sorted(found.items()):
            into = numbers[first : first + len(states.counts)]
            into[np.arange(into.shape[1]) < states.counts[:, None]] = self._enter(states, told)
        return numbers

    def _enter(self, found: StatesFound, told: Told) -> list[int]:
        """Return the numbers of states; new ones are registered."""
        before, numbers, new = len(self.store), list[int](), list[int]()
        fresh = dict[bytes, int]()
        for k, key in enumerate(found.keys()):
            known = self._numbers.get(key)
            number = fresh.setdefault(key, before + len(new)) if known is None else known
            if number == before + len(new):
                new.append(k)
            numbers.append(number)
        if new:
            self.store.add_some(found, np.array(new))
        if told is not None:
            for number in range(before, len(self.store)):
                told(number, self.store.contacts(number))
        self._numbers.update(fresh)  # last: Ctrl-C may come before
        return numbers
