"""From legs along a route to moves of physical fingers."""

from __future__ import annotations

from collections.abc import Sequence

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.cost import displacement_cost
from gm_ompl.graph.extraction import PhysicalHand
from gm_ompl.graph.sets import LIFTED
from gm_ompl.moves import Displacement, Move, Regrasp
from gm_ompl.problem import Placements
from gm_ompl.sampling.lane_store import LaneStore
from gm_ompl.sampling.tree import Leg


def moves_of(judge: Judge, store: LaneStore, legs: Sequence[Leg]) -> tuple[Move, ...]:
    """Return the moves of ``legs``: a displacement per stride, a regrasp between two legs.

    Args:
        judge: answers about the problem.
        store: what is known along the route.
        legs: each starts where the last ended, with all but one finger in place.
    """
    if not legs:
        return ()
    hand = PhysicalHand(judge.problem.fingers.groups(), legs[0][0])
    moves: list[Move] = []
    for m, (lane, first, last) in enumerate(legs):
        if m:
            moves.append(_regrasp(judge, store, hand, legs[m - 1][0], lane, first))
        moves.extend(_stride(judge, store, hand, lane, k) for k in range(first, last))
    return tuple(moves)


def _stride(
    judge: Judge, store: LaneStore, hand: PhysicalHand, lane: Placements, k: int
) -> Displacement:
    problem, route = judge.problem, store.route
    fingers, z_min = tuple(range(len(lane))), problem.mechanics.z_min
    decisions = [
        judge.backend.decide(route.state(k, p), fingers, lane, z_min)
        for p in range(route.states.shape[1])
    ]
    lengths = route.stride_lengths(k, lane)
    slots = [hand.slot(i, lane) for i in fingers]
    return Displacement(
        start=route.vertices[k],
        end=route.vertices[k + 1],
        placements=hand.placements,
        segments=tuple(_reordered(decision, slots) for decision in decisions),
        cost=displacement_cost(lengths, [d.z for d in decisions], problem.cost.stability),
    )


def _regrasp(
    judge: Judge,
    store: LaneStore,
    hand: PhysicalHand,
    before: Placements,
    after: Placements,
    vertex: int,
) -> Regrasp:
    problem = judge.problem
    hub = shared_hub(store, before, after)
    touching = [i for i, row in enumerate(hub) if row != LIFTED]
    rows = tuple(hub[i] for i in touching)
    state = store.route.rest_state(vertex)
    rest = judge.backend.decide(state, tuple(touching), rows, problem.mechanics.z_min)
    finger, target = hand.regrasped(hub, after)
    others = [i for i in range(len(hub)) if i != finger]
    slots = [touching.index(hand.slot(i, hub)) for i in others]
    at, cost = store.route.vertices[vertex], problem.cost.regrasp
    move = Regrasp(at, finger, target, hand.placements, _reordered(rest, slots), cost)
    hand.move(finger, target)
    return move


def shared_hub(store: LaneStore, before: Placements, after: Placements) -> Placements:
    """Return the hub that joins two canonical sets."""
    hubs = {store.lifted(before, slot) for slot in range(len(before))}
    return next(
        hub for hub in (store.lifted(after, slot) for slot in range(len(after))) if hub in hubs
    )


def _reordered(decision: ModeDecision, slots: Sequence[int]) -> ModeDecision:
    """Return a decision made for canonical slots with its fingers in the order of ``slots``."""
    return ModeDecision(
        decision.outcome,
        decision.z,
        tuple(decision.modes[i] for i in slots),
        tuple(decision.f_com[i] for i in slots),
        decision.direction,
    )
