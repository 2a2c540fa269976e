"""Steady control: of all ways to control a plan's fingers, the one that changes least.

A robot cannot flip control modes at every step. Along the moves of a plan, among modes and f_com
whose z is within 1e-6 (relative) of Sec. 3.4's best, this chooses those whose junctions hold, then
the fewest mode switches and, for these modes, the least total change of f_com. Placements, poses
and (up to that tolerance) costs stay as they are.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.junction import JunctionVerdict
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.steady_modes import Broken, spread, switches
from gm_ompl.holds.cost import displacement_cost
from gm_ompl.planners.choosing import Chooser, instants_of
from gm_ompl.problem import Displacement, Move, Problem, Regrasp

TRIES = 8
"""Combinations of modes tried along a plan until all junctions hold."""


class Steady(NamedTuple):
    """Moves under steady control.

    Attributes:
        moves: the plan.
        passages: of its junctions that do not simply hold; None where they are not known.
    """

    moves: tuple[Move, ...]
    passages: tuple[JunctionVerdict, ...] | None

    @property
    def fails(self) -> bool:
        """Whether it is known that a junction does not hold, not even at rest."""
        return JunctionVerdict.FAILS in (self.passages or ())

    @property
    def stands(self) -> bool:
        """Whether there is a plan and it is known that all junctions hold, if only at rest."""
        return bool(self.moves) and self.passages is not None and not self.fails

    def statistics(self) -> dict[str, int | None]:
        """Return how many junctions hold only while the object rests, and how many fail."""
        if not self.moves:
            return {}
        names = {
            "resting_junctions": JunctionVerdict.RESTS,
            "failing_junctions": JunctionVerdict.FAILS,
        }
        found = self.passages
        return {k: None if found is None else found.count(v) for k, v in names.items()}


def steady_moves(judge: Judge, moves: Sequence[Move]) -> Steady:
    """Return ``moves`` under steady control.

    Args:
        judge: of the problem; with another back end than the kernel, which alone knows the
            alternatives, it is left aside.
        moves: with Sec. 3.4's best decisions.
    """
    problem = judge.problem
    if not moves or problem.fingers.count == 0:
        return Steady(tuple(moves), ())
    if not isinstance(judge.backend, KernelBackend):
        judge = Judge(problem, KernelBackend(problem))
    chooser = Chooser(judge, moves)
    broken: set[Broken] = set()
    chosen, failing = chooser.choose(broken)
    best = chosen, failing
    passages = None
    try:
        for _ in range(TRIES):
            if failing <= broken:  # none, or there is no way around
                break
            broken |= failing
            chosen, failing = chooser.choose(broken)
            if len(failing) < len(best[1]):
                best = chosen, failing
        numbers = sorted(k for k, *_ in best[1])
        passages = tuple(chooser.passage(number, best[0]) for number in numbers)
    except LimitError:
        pass  # what was chosen first is steady, too
    return Steady(tuple(_with_decisions(problem, moves, best[0])), passages)


def mode_switches(problem: Problem, moves: Sequence[Move]) -> int:
    """Return how often a finger's mode changes along ``moves`` while it stays in contact."""
    modes = [
        spread(instant.decision, instant.fingers, problem.fingers.count)
        for instant in instants_of(problem, moves)
    ]
    return sum(switches(a, b) for a, b in pairwise(modes))


def _with_decisions(
    problem: Problem, moves: Sequence[Move], decisions: Sequence[ModeDecision]
) -> Iterator[Move]:
    """Yield the moves with the decisions put in, and what they cost then."""
    left = iter(decisions)
    for move in moves:
        if isinstance(move, Regrasp):
            yield dataclasses.replace(move, rest=next(left))
            continue
        segments = tuple(next(left) for _ in move.segments)
        if segments == move.segments:
            yield move
            continue
        cost = move.cost
        z = [decision.z for decision in segments]
        if z != [decision.z for decision in move.segments]:
            lengths = _lengths(problem, move)
            cost = displacement_cost(lengths, z, problem.cost.stability, problem.z_floor)
        yield dataclasses.replace(move, segments=segments, cost=cost)


def _lengths(problem: Problem, move: Displacement) -> list[list[float]]:
    """Return per finger, per segment, |dq_finger i,j| of Eq. (9)."""
    centres = problem.fingers.centres(move.placements)
    lengths: list[list[float]] = move.arc.chords(centres, len(move.segments)).T.tolist()
    return lengths
