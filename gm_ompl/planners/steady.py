"""Steady control: of all ways to control a plan's fingers, the one that changes least.

A robot cannot flip control modes at every step. Along the moves of a plan, among modes and f_com
whose z is within 1e-6 (relative) of Sec. 3.4's best, this chooses the fewest mode switches and,
for these modes, the least total change of f_com. Placements, poses and (up to that tolerance)
costs stay as they are.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.steady_force import (
    Undecided,
    fewest_switches,
    least_change,
    spread,
    switches,
)
from gm_ompl.holds.cost import displacement_cost
from gm_ompl.mechanics.alternatives import Alternatives
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Displacement, Move, Placements, Problem, Regrasp

LEAST, AIM = 8e-7, 5e-7
"""By how much z may stay below the best, relatively, and what the cuts ask for. A check that
allows 1e-6 has the rest for the difference between two solvers."""


@dataclass(frozen=True, eq=False)
class Controlled:
    """A segment's midpoint, or a rest, with its decision.

    Attributes:
        key: equal where the mechanics is equal.
        alternatives: shared by equal instants.
        fingers: those that touch.
        decision: Sec. 3.4's best.
    """

    key: tuple[object, ...]
    alternatives: Alternatives
    fingers: tuple[int, ...]
    decision: ModeDecision


def steady_moves(judge: Judge, moves: Sequence[Move]) -> tuple[Move, ...]:
    """Return ``moves`` under steady control.

    Args:
        judge: of the problem; with another back end than the kernel, which alone knows the
            alternatives, it is left aside.
        moves: with Sec. 3.4's best decisions.
    """
    problem = judge.problem
    if not moves or problem.fingers.count == 0:
        return tuple(moves)
    instants = list(_instants(judge, moves))
    chosen = _steady_forces(problem, instants, _steady_modes(problem, instants))
    return tuple(_with_decisions(problem, moves, chosen))


def mode_switches(problem: Problem, moves: Sequence[Move]) -> int:
    """Return how often a finger's mode changes along ``moves`` while it stays in contact."""
    modes = [
        spread(decision, fingers, problem.fingers.count)
        for _, fingers, _, decision in _decisions(problem, moves)
    ]
    return sum(switches(a, b) for a, b in pairwise(modes))


def _decisions(
    problem: Problem, moves: Sequence[Move]
) -> Iterator[tuple[Moment, tuple[int, ...], Placements, ModeDecision]]:
    """Yield (instant, fingers, their placements, decision) along the plan."""
    everyone = tuple(range(problem.fingers.count))
    for move in moves:
        if isinstance(move, Regrasp):
            others = tuple(i for i in everyone if i != move.finger)
            rows = tuple(move.placements[i] for i in others)
            yield Moment(move.pose), others, rows, move.rest
            continue
        middles = move.arc.middles(len(move.segments))
        for moment, decision in zip(middles, move.segments, strict=True):
            yield moment, everyone, move.placements, decision


def _instants(judge: Judge, moves: Sequence[Move]) -> Iterator[Controlled]:
    backend = judge.backend
    if not isinstance(backend, KernelBackend):
        backend = KernelBackend(judge.problem)
        judge = Judge(judge.problem, backend)
    known: dict[tuple[object, ...], Alternatives] = {}
    for moment, fingers, placements, decision in _decisions(judge.problem, moves):
        key = (judge.environment(moment), fingers, placements)
        if key not in known:
            known[key] = backend.alternatives(*key)
        yield Controlled(key, known[key], fingers, decision)


def _least(problem: Problem, z: float) -> float:
    """Return what z must reach where ``z`` is the best: z_min is not missed for steadiness."""
    return max(z * (1.0 - LEAST), min(z, problem.mechanics.z_min))


def _steady_modes(problem: Problem, instants: Sequence[Controlled]) -> list[ModeDecision]:
    """Return per instant the decision with the modes to use and the best f_com for them."""
    count = problem.fingers.count
    own = [spread(instant.decision, instant.fingers, count) for instant in instants]
    if not any(switches(a, b) for a, b in pairwise(own)):
        return [instant.decision for instant in instants]
    known: dict[tuple[object, ...], tuple[ModeDecision, ...]] = {}
    options = []
    for instant in instants:
        if instant.key not in known:
            least = _least(problem, instant.decision.z)
            others = [
                other
                for other in instant.alternatives.modes(least)
                if other.modes != instant.decision.modes
            ]
            known[instant.key] = (instant.decision, *others)
        options.append(known[instant.key])
    return fewest_switches(options, [instant.fingers for instant in instants], count)


def _steady_forces(
    problem: Problem, instants: Sequence[Controlled], decisions: Sequence[ModeDecision]
) -> list[ModeDecision]:
    """Return per instant the decision with the modes given and the f_com to use."""
    commands: list[Undecided] = []
    which: list[int] = []
    for k, (instant, decision) in enumerate(zip(instants, decisions, strict=True)):
        same = k > 0 and instant.key == instants[k - 1].key
        if not (same and decision.modes == decisions[k - 1].modes):
            commands.append(_command(problem, instant, decision))
        which.append(len(commands) - 1)
    chosen = least_change(commands)
    return [chosen[c] for c in which]


def _command(problem: Problem, instant: Controlled, decision: ModeDecision) -> Undecided:
    best = instant.decision.z
    least = _least(problem, best)
    limits = problem.fingers.max_normal_force
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
