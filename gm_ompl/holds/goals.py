"""Which placements start and goal allow."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import BoolArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose
from gm_ompl.holds.sets import ordered_sets
from gm_ompl.holds.watch import Stop, never, watched
from gm_ompl.problem import Placements

Requirement: TypeAlias = tuple[int | None, ...]
"""Per finger, its placement, or None for any."""


def valid_goals(judge: Judge, stop: Stop = never) -> tuple[int, ...] | None:
    """Return the goal's nodes at which some set of placements is geometrically valid.

    None where the goal's nodes cannot be listed.

    Raises:
        LimitError: ``stop`` said so.
    """
    graph, wanted = judge.problem.object_graph, judge.problem.fingers.goal
    if graph.goal_nodes is None:
        return None
    nodes = watched(graph.goal_nodes, stop)
    return tuple(node for node in nodes if has_set(judge, graph.pose(node), wanted))


def has_set(judge: Judge, pose: Pose, required: Requirement) -> bool:
    """Whether some set of placements is geometrically valid at ``pose``."""
    geometry = judge.node(pose)
    return geometry.object_free and some_set(judge, geometry.free, required)


def some_set(judge: Judge, free: tuple[BoolArray, ...], required: Requirement) -> bool:
    """Whether fingertips that are ``free`` there, (P,) each, can touch together as required."""
    allowed = restricted(free, required)
    keys = [np.zeros(len(mask)) for mask in allowed]
    sets = ordered_sets(judge.problem.fingers.groups(), allowed, keys, judge.clear)
    return next(sets, None) is not None


def blocked_at_all(judge: Judge, goals: tuple[int, ...]) -> tuple[BoolArray, ...]:
    """Return per finger (P,) the placements that are blocked at every one of these goal nodes."""
    hand, graph = judge.problem.fingers, judge.problem.object_graph
    blocked = tuple(np.ones(len(hand.placements), dtype=bool) for _ in range(hand.count))
    for node in goals:
        geometry = judge.node(graph.pose(node))
        for mask, free in zip(blocked, restricted(geometry.free, hand.goal), strict=True):
            mask &= ~free
    return blocked


def fits(placements: Placements, required: Requirement) -> bool:
    """Whether the fingers are where they are wanted."""
    pairs = zip(placements, required, strict=True)
    return all(want is None or have == want for have, want in pairs)


def restricted(free: tuple[BoolArray, ...], required: Requirement) -> tuple[BoolArray, ...]:
    """Return the masks ``free``, a finger with a required placement limited to that one."""
    masks = []
    for mask, row in zip(free, required, strict=True):
        if row is None:
            masks.append(mask)
        else:
            only = np.zeros_like(mask)
            only[row] = mask[row]
            masks.append(only)
    return tuple(masks)
