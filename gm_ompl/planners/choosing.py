"""Decisions along a plan: what could be chosen at each instant, and what goes together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.junction import (
    Control,
    Forces,
    Junction,
    JunctionVerdict,
    controls,
    junction,
    meeting,
    passage,
)
from gm_ompl.errors import SolverError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.links import Link, Side
from gm_ompl.feasibility.steady_force import Undecided, least_change
from gm_ompl.feasibility.steady_modes import Broken, fewest_switches, spread, switches
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Move, Placements, Problem, Regrasp

if TYPE_CHECKING:
    from gm_ompl.mechanics.case_alternatives import Choices

LEAST, AIM = 8e-7, 5e-7
"""By how much z may stay below the best, relatively, and what the cuts ask for. A check that
allows 1e-6 has the rest for the difference between two solvers."""


class PlannedInstant(NamedTuple):
    """A segment, or a rest, of a plan.

    Attributes:
        moment: where it is judged.
        first: the object where it begins.
        last: where it ends.
        fingers: those that touch.
        placements: of those fingers.
        decision: how they are controlled.
    """

    moment: Moment
    first: Moment
    last: Moment
    fingers: tuple[int, ...]
    placements: Placements
    decision: ModeDecision


@dataclass(frozen=True, eq=False)
class Controlled:
    """An instant with what else could be decided there.

    Attributes:
        instant: with Sec. 3.4's best decision.
        key: equal where the mechanics is equal.
        alternatives: shared by equal instants.
    """

    instant: PlannedInstant
    key: tuple[int, tuple[int, ...], Placements]
    alternatives: Choices

    @property
    def fingers(self) -> tuple[int, ...]:
        """Those that touch."""
        return self.instant.fingers

    @property
    def decision(self) -> ModeDecision:
        """Sec. 3.4's best."""
        return self.instant.decision


def instants_of(problem: Problem, moves: Sequence[Move]) -> Iterator[PlannedInstant]:
    """Yield the instants along the plan."""
    everyone = tuple(range(problem.fingers.count))
    for move in moves:
        if isinstance(move, Regrasp):
            others = tuple(i for i in everyone if i != move.finger)
            rows, rest = tuple(move.placements[i] for i in others), Moment(move.pose)
            yield PlannedInstant(rest, rest, rest, others, rows, move.rest)
            continue
        ends = [move.arc.moment(t) for t in move.arc.bounds(len(move.segments))]
        middles = move.arc.middles(len(move.segments))
        for moment, first, last, decision in zip(
            middles, ends, ends[1:], move.segments, strict=False
        ):
            yield PlannedInstant(moment, first, last, everyone, move.placements, decision)


class Chooser:
    """Chooses decisions along a plan; what was asked once is kept."""

    def __init__(self, judge: Judge, moves: Sequence[Move]) -> None:
        assert isinstance(judge.backend, KernelBackend)
        self.problem, self._judge, self._backend = judge.problem, judge, judge.backend
        self._known: dict[tuple[object, ...], Choices] = {}
        self._options: dict[tuple[object, ...], tuple[ModeDecision, ...]] = {}
        self.instants = [self._controlled(i) for i in instants_of(judge.problem, moves)]
        self._sides: dict[tuple[object, ...], tuple[Side, ...]] = {}

    def choose(self, broken: set[Broken]) -> tuple[list[ModeDecision], set[Broken]]:
        """Return a decision per instant, and the junctions that do not hold with them.

        Args:
            broken: combinations of modes to be kept from meeting.
        """
        instants, count = self.instants, self.problem.fingers.count
        decisions = self._modes(broken)
        commands: list[Undecided] = []
        which: list[int] = []
        for k, (instant, decision) in enumerate(zip(instants, decisions, strict=True)):
            same = k > 0 and instant.key == instants[k - 1].key
            if not (same and decision.modes == decisions[k - 1].modes):
                commands.append(_command(self.problem, instant, decision))
            which.append(len(commands) - 1)
        chosen, left = least_change(commands, self._links(commands, which))
        modes = [spread(d, i.fingers, count) for d, i in zip(decisions, instants, strict=True)]
        failing = {(link.number, modes[link.number], modes[link.number + 1]) for link in left}
        return [chosen[c] for c in which], failing

    def passage(self, number: int, decisions: Sequence[ModeDecision]) -> JunctionVerdict:
        """Judge the junction after an instant, by the reference."""
        # Imported late: it loads HiGHS, and is seldom needed.
        from gm_ompl.reference.junction import equilibrium

        problem, hands = self.problem, list[tuple[Control, ...]]()
        pair = slice(number, number + 2)
        for instant, decision in zip(self.instants[pair], decisions[pair], strict=True):
            now = decision.modes, decision.f_com, instant.fingers, problem.fingers.count
            hands.append(controls(*now))
        if hands[0] == hands[1]:
            return JunctionVerdict.HOLDS
        ramp = junction(hands[0], hands[1])
        placements = self._placements(number, ramp)

        def balanced(moment: Moment, f_com: Forces) -> bool:
            contacts = self._backend.contacts(self._judge.environment(moment))
            instant = problem.instant(contacts, ramp.fingers, placements)
            try:
                return equilibrium(instant, ramp.modes, f_com)
            except SolverError:
                return False

        before, after = (c.instant for c in self.instants[pair])
        return passage(ramp, before.last, after.first, balanced)

    def _placements(self, number: int, ramp: Junction) -> Placements:
        """Return where the fingers of a junction are."""
        rows = {
            finger: row
            for each in self.instants[number : number + 2]
            for finger, row in zip(each.fingers, each.instant.placements, strict=True)
        }
        return tuple(rows[finger] for finger in ramp.fingers)

    def _controlled(self, instant: PlannedInstant) -> Controlled:
        key = (self._judge.environment(instant.moment), instant.fingers, instant.placements)
        return Controlled(instant, key, self._alternatives(key))

    def _alternatives(self, key: tuple[int, tuple[int, ...], Placements]) -> Choices:
        if key not in self._known:
            self._known[key] = self._backend.alternatives(*key)
        return self._known[key]

    def _modes(self, broken: set[Broken]) -> list[ModeDecision]:
        """Return per instant the decision with the modes to use and the best f_com for them."""
        count, instants = self.problem.fingers.count, self.instants
        own = [spread(instant.decision, instant.fingers, count) for instant in instants]
        if not broken and not any(switches(a, b) for a, b in pairwise(own)):
            return [instant.decision for instant in instants]
        options = [self._choices(instant) for instant in instants]
        return fewest_switches(options, [i.fingers for i in instants], count, broken)

    def _choices(self, instant: Controlled) -> tuple[ModeDecision, ...]:
        """Return the decision that is best and others whose z is as good."""
        if instant.key not in self._options:
            least, best = _least(self.problem, instant.decision.z), instant.decision
            others = (
                self._strong_choices(instant.key)
                if self.problem.mechanics.strong
                else instant.alternatives.modes(least)
            )
            self._options[instant.key] = (
                best, *(d for d in others if d.modes != best.modes and d.z >= least)
            )  # fmt: skip
        return self._options[instant.key]

    def _strong_choices(
        self, key: tuple[int, tuple[int, ...], Placements]
    ) -> tuple[ModeDecision, ...]:
        from gm_ompl.mechanics.strongest import strong_choices  # few plans are made for z_strong

        contacts = self._backend.contacts(key[0])
        return strong_choices(self.problem.instant(contacts, *key[1:]))

    def _links(self, commands: Sequence[Undecided], which: Sequence[int]) -> list[Link]:
        """Return the ramps between different commands."""
        firsts = np.cumsum([0, *(len(command.forced) for command in commands)]).tolist()
        hands = [self._places(*each) for each in zip(commands, firsts, strict=False)]
        return [
            self._link(k, hands[a], hands[b]) for k, (a, b) in enumerate(pairwise(which)) if a != b
        ]

    def _places(self, command: Undecided, first: int) -> tuple[Control, ...]:
        """Return who does what, with the places of the commands, from 1, in their stead."""
        modes = command.decision.modes
        places = iter(range(first + 1, first + 1 + len(modes)))
        f_com = tuple(next(places) if m is ControlMode.FORCE else None for m in modes)
        return controls(modes, f_com, command.fingers, self.problem.fingers.count)

    def _link(self, k: int, before: tuple[Control, ...], after: tuple[Control, ...]) -> Link:
        ramp = junction(before, after)
        return Link(
            number=k,
            modes=ramp.modes,
            ends=tuple(
                np.array([place for place in end if place is not None], dtype=np.int64)
                for end in ramp.ends
            ),
            same=[control.mode for control in before] == [control.mode for control in after],
            look=partial(self._look, k, ramp),
        )

    def _look(self, k: int, ramp: Junction) -> tuple[Side, ...]:
        """Return the mechanics of the junction after an instant, under each twist."""
        key = k, ramp.fingers
        if key not in self._sides:
            before, after = (each.instant for each in self.instants[k : k + 2])
            placements, contacts = self._placements(k, ramp), self._backend.contacts
            states = map(self._judge.environment, meeting(before.last, after.first))
            self._sides[key] = tuple(
                Side(
                    self._alternatives((state, ramp.fingers, placements)),
                    partial(self.problem.instant, contacts(state), ramp.fingers, placements),
                )
                for state in states
            )
        return self._sides[key]


def _least(problem: Problem, z: float) -> float:
    """Return what z must reach where ``z`` is the best: z_min is not missed for steadiness."""
    return max(z * (1.0 - LEAST), min(z, problem.mechanics.z_min))


def _command(problem: Problem, instant: Controlled, decision: ModeDecision) -> Undecided:
    best = instant.decision.z
    least = _least(problem, best)
    limits = problem.fingers.max_normal_force / (1.0 + problem.uncertainty.command)
    forced = [
        finger
        for finger, mode in zip(instant.fingers, decision.modes, strict=True)
        if mode is ControlMode.FORCE
    ]
    return Undecided(
        alternatives=instant.alternatives,
        decision=decision,
        fingers=instant.fingers,
        least=least,
        aim=least + (best - least) * (1.0 - AIM / LEAST),
        limits=np.asarray(limits[forced], dtype=np.float64),
    )
