"""The back end that decides with the compiled kernel, and keeps what it learns on the way."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.decision import ModeDecision, Outcome, undecided
from gm_ompl.contact.state import ContactState
from gm_ompl.cores import share_out
from gm_ompl.direct import direct
from gm_ompl.feasibility.deciders import deciders, tips_for_cuts
from gm_ompl.feasibility.keys import finger_kinds
from gm_ompl.feasibility.known_states import KnownStates
from gm_ompl.mechanics import columns, modes
from gm_ompl.mechanics.alternatives import Alternatives
from gm_ompl.mechanics.batch import Decisions, States, decide_rows, unanswered
from gm_ompl.mechanics.central import Answer, settle_commands
from gm_ompl.mechanics.certificate import NO_RECORD
from gm_ompl.mechanics.cuts import CutPool
from gm_ompl.mechanics.instant import DIRECTIONS, as_decision
from gm_ompl.mechanics.program import Program, Touch
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.free import FreeMotion
from gm_ompl.problem import Placements, Problem

if TYPE_CHECKING:
    from gm_ompl.mechanics.case_alternatives import Choices
    from gm_ompl.motion.courses import Courses

Key: TypeAlias = tuple[int, Placements, Placements]
"""Contact state, kinds of fingers, placements."""


@final
class KernelBackend:
    """Mode decisions from ``gm_ompl.mechanics``, remembered.

    Attributes:
        decisions: mode decisions computed so far; answers from the memo are not counted.
        fallbacks: those among them that the reference made, as the kernel found no proof.
        undecided: those among them that nobody could prove.
        optimistic: whether what nobody can prove counts as any z instead of none: for bounds.
        scale: the unit of force inside the kernel.
        pool: the cuts that decisions of the whole hand have left, forces over ``scale``.
        learn: told of each such cut: contact state, load, wrench. It keeps them in the pool.
    """

    def __init__(self, problem: Problem) -> None:
        self.decisions = self.fallbacks = self.undecided = 0
        self.optimistic = False
        self._problem = problem
        hand, settings = problem.fingers, problem.mechanics
        self._U = columns.wrench_norm(problem.mass, problem.inertia)
        self.scale = problem.force_scale
        self._weight = problem.mass * settings.gravity / self.scale
        self._f_max = hand.max_normal_force / self.scale
        self._kinds = finger_kinds(problem)
        self._cases, self._strong = deciders(problem, self._U)
        self._tips = tips_for_cuts(problem, self._U, self._cases)
        self._states = KnownStates(problem, self._U, self._weight)
        self._decide = direct(modes.decide)
        self._many = isinstance(problem.motion, FreeMotion)
        self._told = None if self._cases is None else self._cases.register
        self._hands: dict[tuple[int, ...], tuple[Placements, IntArray]] = {}
        self._memo: dict[Key, tuple[bool, ModeDecision]] = {}
        self.pool = CutPool(self._tips, self._f_max, DIRECTIONS)
        self.learn = self.pool.add

    def of_hand(self, problem: Problem) -> KernelBackend:
        """Return one for a problem with other placements; its contact states' numbers are ours."""
        other = KernelBackend(problem)
        other._states = self._states
        return other

    @property
    def tips(self) -> Array:
        """All fingers' columns for unit normal force at all placements (n, P, s, 6)."""
        return self._tips

    def environment(self, contacts: ContactState) -> int:
        """Register a contact state; equal states get the same number."""
        return self._states.number(contacts, self._told)

    def environments(self, arc: Arc, parts: int) -> list[int] | None:
        """Register the contact states in the middles of a screw's segments, by compiled code.

        None where that does not tell, and for prescribed ways: it takes long to compile.
        """
        return self._states.along(arc, parts, self._told) if self._many else None

    def along(self, courses: Courses) -> IntArray:
        """Register the contact states in the middles of screws' segments, (m, parts).

        Behind a screw's last, and where compiled code does not tell, numbers are -1.
        """
        return self._states.along_courses(courses, self._told)

    def contacts(self, environment: int) -> ContactState:
        """Return the contact state of a number, as it was first registered."""
        return self._states.store.contacts(environment)

    def decide(
        self,
        environment: int,
        fingers: tuple[int, ...],
        placements: Placements,
        below: float = 0.0,
    ) -> ModeDecision:
        """Return the best modes for ``fingers`` at ``placements`` (same length).

        Where z is proven smaller than ``below``, outcome BELOW and a bound will do.
        """
        kinds, hand = self._hand(fingers)
        key = (environment, kinds, placements)
        known = self._known(key, below)
        if known is None:
            answer = self._solve(environment, hand, placements, below)
            known = answer or self._fall_back(environment, fingers, placements)
            known = self._strongly(known, environment, hand, placements, below)
            self._memo[key] = known.outcome is not Outcome.BELOW, known
        return known

    def _solve(
        self, environment: int, hand: IntArray, placements: Placements, below: float
    ) -> ModeDecision | None:
        self.decisions += 1
        (env, load), f_com, y = self._states.store.at(environment), np.zeros(len(hand)), np.zeros(6)
        rows = np.array(placements, dtype=np.int64)
        if self._cases is None:
            touch = Touch(env, load, self._tips, self._f_max, DIRECTIONS, hand, rows)
            answer = self._decide(touch, below / self.scale, -1, -1, NO_RECORD, f_com, y)
        else:
            answer, number = self._cases.decide(environment, hand, rows, below, f_com, y)
            load = self._cases.load(environment, number)
        if len(hand) == len(self._f_max):
            self.learn(environment, load, y)
        return self._decision(environment, hand, placements, answer, f_com)

    def _program(self, environment: int, hand: IntArray, rows: IntArray) -> Program:
        """Return what acts on a hand (k,) at its placements (k,)."""
        tips, f_max = self._tips[hand, rows], self._f_max[hand]
        return Program(*self._states.store.at(environment), tips, f_max, DIRECTIONS)

    def _decision(
        self, environment: int, hand: IntArray, rows: Placements, answer: Answer, f_com: Array
    ) -> ModeDecision | None:
        """Return the decision that the kernel's answer is, None where it proves nothing."""
        if answer[1] == 0.0 and self._cases is None:  # f_com is left free
            program = self._program(environment, hand, np.array(rows, dtype=np.int64))
            settle_commands(program, answer, f_com)
        return as_decision(*answer, f_com.tolist(), self.scale)

    def _fall_back(
        self, environment: int, fingers: tuple[int, ...], placements: Placements
    ) -> ModeDecision:
        """Let the reference decide what the kernel cannot prove."""
        # Imported late: it loads HiGHS, and is hardly ever needed.
        from gm_ompl.reference.proof import proven_decision

        self.fallbacks += 1
        contacts = self.contacts(environment)
        decision = proven_decision(self._problem.instant(contacts, fingers, placements))
        self.undecided += decision is None
        return decision or undecided(len(fingers), self.optimistic)

    def decide_many(
        self, environments: IntArray, sets: IntArray, below: float = 0.0
    ) -> list[ModeDecision]:
        """Return what ``decide`` would for the whole hand at many sets of placements at once.

        ``environments`` (K,) are the contact states, ``sets`` (K, n) the placements.
        """
        kinds = tuple(self._kinds)
        keys = [
            (state, kinds, tuple(rows))
            for state, rows in zip(environments.tolist(), sets.tolist(), strict=True)
        ]
        open_ = list(dict.fromkeys(key for key in keys if self._known(key, below) is None))
        which = np.array([key[0] for key in open_], dtype=np.int64)
        rows = np.array([key[2] for key in open_], dtype=np.int64).reshape(len(open_), len(kinds))
        for key, answer in zip(open_, self._solve_many(which, rows, below), strict=True):
            self._memo[key] = answer.outcome is not Outcome.BELOW, answer
        return [self._memo[key][1] for key in keys]

    def margins(self, environments: IntArray, sets: IntArray, below: float) -> Array:
        """Return z (K,) as ``decide_many`` does, -inf where it is less; decisions are not kept."""
        if self._cases is not None or self._strong is not None:
            return np.array([d.z for d in self.decide_many(environments, sets, below)])
        self.decisions += len(environments)
        answers = self._answers(environments, sets, below)
        zs: Array = np.where(answers.ends == modes.STABLE, answers.zs * self.scale, -np.inf)
        for k in np.flatnonzero(answers.ends == modes.UNPROVEN).tolist():
            everyone, placements = tuple(range(sets.shape[1])), tuple(sets[k].tolist())
            zs[k] = self._fall_back(int(environments[k]), everyone, placements).z
        return zs

    def _answers(self, which: IntArray, rows: IntArray, below: float) -> Decisions:
        states = States(*self._states.store.columns(), self._tips, self._f_max, DIRECTIONS)
        answers = unanswered(*rows.shape)

        def work(part: slice) -> None:
            decide_rows(states, below / self.scale, which[part], rows[part], answers.part(part))

        share_out(work, len(which))
        return answers

    def _solve_many(self, which: IntArray, rows: IntArray, below: float) -> list[ModeDecision]:
        if len(which) == 0:
            return []
        self.decisions += len(which)
        if self._cases is not None:
            answers = self._cases.decide_many(which, rows, below)
            cut = [self._cases.load(*pair) for pair in zip(which, answers.loads, strict=True)]
        else:
            answers = self._answers(which, rows, below)
            cut = list(self._states.store.columns().loads[which])
        numbers = enumerate(which.tolist())
        return [self._answer(s, rows[k], answers, k, cut[k], below) for k, s in numbers]

    def _answer(
        self, environment: int, rows: IntArray, answers: Decisions, k: int, load: Array,
        below: float,
    ) -> ModeDecision:  # fmt: skip
        """Return decision ``k`` and keep the cut that it leaves, under the load (6,)."""
        self.learn(environment, load, answers.wrenches[k])
        answer = (
            int(answers.ends[k]), float(answers.zs[k]), int(answers.directions[k]),
            int(answers.masks[k]),
        )  # fmt: skip
        everyone, placements = np.arange(len(rows)), tuple(rows.tolist())
        decision = self._decision(environment, everyone, placements, answer, answers.commands[k])
        decision = decision or self._fall_back(environment, tuple(range(len(rows))), placements)
        return self._strongly(decision, environment, everyone, placements, below)

    def _strongly(
        self, decision: ModeDecision, environment: int, hand: IntArray, rows: Placements,
        below: float,
    ) -> ModeDecision:  # fmt: skip
        """Return the decision by z_strong where that counts; z bounds it from above."""
        if self._strong is None or decision.outcome is not Outcome.STABLE:
            return decision
        contacts, columns = self.contacts(environment), self.columns(environment)[:3]
        found = self._strong.decide(decision.z, contacts, columns, hand, rows, below)
        if found is None:
            self.undecided += 1
        return found or undecided(len(hand), self.optimistic)

    def _hand(self, fingers: tuple[int, ...]) -> tuple[Placements, IntArray]:
        """Return the fingers' kinds and their numbers as an array."""
        known = self._hands.get(fingers)
        if known is None:
            kinds = tuple(self._kinds[i] for i in fingers)
            known = self._hands[fingers] = kinds, np.array(fingers, dtype=np.int64)
        return known

    def _known(self, key: Key, below: float) -> ModeDecision | None:
        exact, known = self._memo.get(key, (False, None))
        return known if known is not None and (exact or known.z < below) else None

    def bound(self, environment: int, fingers: tuple[int, ...], placements: Placements) -> float:
        """Return an upper bound on z of ``decide``, from what was decided so far."""
        known = self._memo.get((environment, self._hand(fingers)[0], placements))
        if known is not None:
            return known[1].z
        if len(fingers) != len(self._f_max):
            return math.inf
        return self.pool.bound(environment, np.asarray(placements, dtype=np.int64)) * self.scale

    def alternatives(
        self, environment: int, fingers: tuple[int, ...], placements: Placements
    ) -> Choices:
        """Return what Sec. 3.4 could have chosen; arguments as for ``decide``."""
        hand = self._hand(fingers)[1]
        rows = np.array(placements, dtype=np.int64)
        if self._cases is not None:
            return self._cases.alternatives(environment, hand, rows)
        return Alternatives(self.scale, self._program(environment, hand, rows))

    def columns(self, environment: int) -> tuple[Array, Array, Array, Array]:
        """Return what acts at a contact state, forces over ``scale``, and f_max (n,).

        That is the environment's columns (e, 6), the load (6,), all fingers' (n, P, s, 6).
        """
        return *self._states.store.at(environment), self._tips, self._f_max

    def decided(self) -> list[Key]:
        """Return what was decided: per decision the contact state, fingers and placements.

        Fingers that are alike stand for each other.
        """
        return list(self._memo)

    def forget(self) -> None:
        """Empty memo and cuts; the numbers of contact states stay valid."""
        self._memo.clear()
        self.pool.clear()
