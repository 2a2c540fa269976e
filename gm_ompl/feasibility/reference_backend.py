"""The back end that decides with the reference's linear programs in HiGHS."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import final

from gm_ompl.contact.decision import ModeDecision, undecided
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.errors import SolverError
from gm_ompl.feasibility.keys import contact_key, finger_kinds
from gm_ompl.motion.arc import Arc
from gm_ompl.problem import Placements, Problem
from gm_ompl.reference.proof import proven_decision
from gm_ompl.reference.strongest import decision_for


@final
class ReferenceBackend:
    """Mode decisions from ``gm_ompl.reference``, remembered.

    Attributes:
        decisions: mode decisions computed so far; answers from the memo are not counted.
        fallbacks: none.
        undecided: those among them that neither HiGHS nor exact arithmetic could prove.
        optimistic: see ``Backend``.
    """

    def __init__(
        self, problem: Problem, decide: Callable[[Instant], ModeDecision] | None = None
    ) -> None:
        self.decisions = self.fallbacks = self.undecided = 0
        self.optimistic = False
        self._problem = problem
        self._decide = decide or decision_for(problem.mechanics.strong)
        self._diagonal = problem.body.diagonal
        self._kinds = finger_kinds(problem)
        self._numbers: dict[bytes, int] = {}
        self._contacts: list[ContactState] = []
        self._memo: dict[tuple[int, Placements, Placements], ModeDecision] = {}

    def environment(self, contacts: ContactState) -> int:
        """Register a contact state; equal states get the same number."""
        key = contact_key(contacts, self._diagonal)
        number = self._numbers.setdefault(key, len(self._contacts))
        if number == len(self._contacts):
            self._contacts.append(contacts)
        return number

    def environments(self, arc: Arc, parts: int) -> None:
        """Leave contact states to the judge."""

    def decide(
        self,
        environment: int,
        fingers: tuple[int, ...],
        placements: Placements,
        below: float = 0.0,  # noqa: ARG002 (the programs are solved to the end)
    ) -> ModeDecision:
        """Return the best modes for ``fingers`` at ``placements`` (same length)."""
        key = self._key(environment, fingers, placements)
        known = self._memo.get(key)
        if known is None:
            contacts = self._contacts[environment]
            known = self._made(self._problem.instant(contacts, fingers, placements))
            self._memo[key] = known
            self.decisions += 1
        return known

    def _made(self, instant: Instant) -> ModeDecision:
        try:
            return self._decide(instant)
        except SolverError:
            strong = self._problem.mechanics.strong
            decision = None if strong else proven_decision(instant)
        if decision is not None:
            return decision
        self.undecided += 1
        return undecided(len(instant.points), self.optimistic)

    def bound(self, environment: int, fingers: tuple[int, ...], placements: Placements) -> float:
        """Return z where it was decided before, else +inf."""
        known = self._memo.get(self._key(environment, fingers, placements))
        return math.inf if known is None else known.z

    def forget(self) -> None:
        """Empty the memo; the numbers of contact states stay valid."""
        self._memo.clear()

    def _key(
        self, environment: int, fingers: tuple[int, ...], placements: Placements
    ) -> tuple[int, Placements, Placements]:
        return environment, tuple(self._kinds[i] for i in fingers), placements
