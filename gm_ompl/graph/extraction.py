"""From nodes of the graph to moves of physical fingers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.graph.arcs import ObjectArc
from gm_ompl.graph.cost import displacement_cost
from gm_ompl.graph.feasibility_graph import FeasibilityGraph
from gm_ompl.graph.sets import LIFTED, Groups
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.moves import Displacement, Move, Regrasp
from gm_ompl.problem import Placements, Problem


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


@final
class ObjectTrack:
    """Follows the object's coordinates, unwrapped, while lattice nodes wrap them.

    Args:
        problem: the problem.
        config: the lattice node of the start.

    Attributes:
        q: coordinates now.
    """

    def __init__(self, problem: Problem, config: int) -> None:
        self._lattice = problem.lattice
        near = problem.lattice.coordinates(config)
        self.q = self._shifted(near, near, problem.start)

    def advance(self, arc: ObjectArc) -> None:
        """Follow ``arc``."""
        self.q = self._shifted(arc.end, arc.start, self.q)

    def _shifted(self, q: Coordinates, tail: Coordinates, unwrapped: Coordinates) -> Coordinates:
        """Return ``q`` moved by the whole periods that take ``tail`` next to ``unwrapped``."""
        return tuple(
            value if period is None else value + period * round((there - here) / period)
            for value, here, there, period in zip(
                q, tail, unwrapped, self._lattice.periods, strict=True
            )
        )


def extract_moves(
    problem: Problem, graph: FeasibilityGraph, path: Sequence[int]
) -> tuple[Move, ...]:
    """Return the moves along ``path`` (nodes, hubs included), for physical fingers."""
    parts = [graph.parts(node) for node in path]
    hand = PhysicalHand(graph.sets.groups, parts[0][1])
    track = ObjectTrack(problem, parts[0][0])
    moves: list[Move] = []
    for k in range(1, len(parts)):
        (config, before), (end, after) = parts[k - 1], parts[k]
        if LIFTED in after:
            continue
        if LIFTED in before:
            rest = graph.rest(config, before)
            moves.append(_regrasp(hand, track.q, before, after, rest, problem.cost.regrasp))
        else:
            arc = graph.arcs_of_object.between(config, end)
            start = track.q
            track.advance(arc)
            decisions = graph.decisions(arc, after)
            lengths = arc.finger_lengths(after)
            cost = displacement_cost(lengths, [d.z for d in decisions], problem.cost.stability)
            slots = [hand.slot(i, after) for i in range(len(after))]
            segments = tuple(_reordered(decision, slots) for decision in decisions)
            moves.append(Displacement(start, track.q, hand.placements, segments, cost))
    return tuple(moves)


def _regrasp(
    hand: PhysicalHand,
    at: Coordinates,
    hub: Placements,
    after: Placements,
    rest: ModeDecision,
    cost: float,
) -> Regrasp:
    finger, target = hand.regrasped(hub, after)
    touching = [i for i, row in enumerate(hub) if row != LIFTED]
    others = [i for i in range(len(hub)) if i != finger]
    slots = [touching.index(hand.slot(i, hub)) for i in others]
    move = Regrasp(at, finger, target, hand.placements, _reordered(rest, slots), cost)
    hand.move(finger, target)
    return move


def _reordered(decision: ModeDecision, slots: Sequence[int]) -> ModeDecision:
    """Return a decision made for canonical slots with its fingers in the order of ``slots``."""
    return ModeDecision(
        decision.outcome,
        decision.z,
        tuple(decision.modes[i] for i in slots),
        tuple(decision.f_com[i] for i in slots),
        decision.direction,
    )
