"""From sets of placements along the object's way to moves of physical fingers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeAlias, final

import numpy as np

from gm_ompl import limits
from gm_ompl.contact.decision import ModeDecision
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.cost import displacement_cost
from gm_ompl.holds.sets import LIFTED, Groups, PlacementSets
from gm_ompl.motion.object_graph import Way
from gm_ompl.problem import Displacement, Move, Placements, Regrasp

Leg: TypeAlias = tuple[Placements, int, int]
"""(canonical set, first place, last place), places counted along a way, or nodes of a graph."""


@final
class PhysicalHand:
    """Follows which physical finger is where while canonical sets reorder them.

    Args:
        groups: the groups of interchangeable fingers.
        placements: per physical finger, at the start.

    Attributes:
        placements: per physical finger, now.
    """

    def __init__(self, groups: Groups, placements: Placements) -> None:
        self._group_of = {i: group for group in groups for i in group}
        self.placements = placements

    def slot(self, finger: int, canonical: Placements) -> int:
        """Return where the physical ``finger`` stands in a canonical set that has it."""
        row = self.placements[finger]
        return next(i for i in self._group_of[finger] if canonical[i] == row)

    def regrasped(self, hub: Placements, after: Placements) -> tuple[int, int]:
        """Return (finger, new placement) of the regrasp through ``hub`` to the set ``after``."""
        group = self._group_of[hub.index(LIFTED)]
        kept = {hub[i] for i in group}
        finger = next(i for i in group if self.placements[i] not in kept)
        target = next(after[i] for i in group if after[i] not in kept)
        return finger, target

    def move(self, finger: int, target: int) -> None:
        """Put ``finger`` at ``target``."""
        self.placements = (
            *self.placements[:finger], target, *self.placements[finger + 1 :],
        )  # fmt: skip


def merged(legs: Iterable[Leg]) -> list[Leg]:
    """Return the legs, those in a row with the same set as one."""
    whole: list[Leg] = []
    for placements, first, last in legs:
        if whole and whole[-1][0] == placements:
            whole[-1] = (placements, whole[-1][1], last)
        else:
            whole.append((placements, first, last))
    return whole


def shared_hub(sets: PlacementSets, before: Placements, after: Placements) -> Placements:
    """Return the hub that joins two canonical sets."""
    hubs = set(sets.hubs(before))
    return next(hub for hub in sets.hubs(after) if hub in hubs)


def moves_of(judge: Judge, way: Way, legs: Sequence[Leg]) -> tuple[Move, ...]:
    """Return the moves of ``legs``: a displacement per arc, a regrasp between two legs.

    Args:
        judge: answers about the problem; what the moves rest on was decided before.
        way: the object's.
        legs: each starts where the last ended, with all but one finger in place.
    """
    if not legs:
        return ()
    with limits.lifted():  # a plan that was found is not lost
        return tuple(_moves(judge, way, legs))


def _moves(judge: Judge, way: Way, legs: Sequence[Leg]) -> Iterator[Move]:
    groups = judge.problem.fingers.groups()
    hand, sets = PhysicalHand(groups, legs[0][0]), PlacementSets(groups)
    for m, (placements, first, last) in enumerate(legs):
        if m:
            hub = shared_hub(sets, legs[m - 1][0], placements)
            yield _regrasp(judge, way, hand, hub, placements, first)
        for k in range(first, last):
            yield _displacement(judge, way, hand, placements, k)


def _displacement(
    judge: Judge, way: Way, hand: PhysicalHand, placements: Placements, k: int
) -> Displacement:
    problem, arc = judge.problem, way.arcs[k]
    fingers, z_min = tuple(range(len(placements))), problem.mechanics.z_min
    decisions = [
        judge.backend.decide(judge.environment(moment), fingers, placements, z_min)
        for moment in arc.middles()
    ]
    centres = np.array([judge.centres(i)[row] for i, row in enumerate(placements)])
    lengths = arc.lengths(centres.reshape(-1, 3)).tolist()
    slots = [hand.slot(i, placements) for i in fingers]
    return Displacement(
        arc=arc.arc,
        start=way.coordinates[k],
        end=way.coordinates[k + 1],
        placements=hand.placements,
        segments=tuple(_reordered(decision, slots) for decision in decisions),
        cost=displacement_cost(
            lengths, [d.z for d in decisions], problem.cost.stability, problem.z_floor
        ),
    )


def _regrasp(
    judge: Judge, way: Way, hand: PhysicalHand, hub: Placements, after: Placements, k: int
) -> Regrasp:
    problem, pose = judge.problem, way.poses[k]
    touching = tuple(i for i, row in enumerate(hub) if row != LIFTED)
    rows = tuple(hub[i] for i in touching)
    rest = judge.rest(pose, touching, rows, problem.mechanics.z_min)
    finger, target = hand.regrasped(hub, after)
    others = [i for i in range(len(hub)) if i != finger]
    slots = [touching.index(hand.slot(i, hub)) for i in others]
    move = Regrasp(
        pose=pose,
        at=way.coordinates[k],
        finger=finger,
        target=target,
        placements=hand.placements,
        rest=_reordered(rest, slots),
        cost=problem.cost.regrasp,
    )
    hand.move(finger, target)
    return move


def _reordered(decision: ModeDecision, slots: Sequence[int]) -> ModeDecision:
    """Return a decision made for canonical slots with its fingers in the order of ``slots``."""
    return decision._replace(
        modes=tuple(decision.modes[i] for i in slots),
        f_com=tuple(decision.f_com[i] for i in slots),
    )
