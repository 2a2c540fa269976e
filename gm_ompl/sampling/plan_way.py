"""The way of a plan that was found, in strides, and its sets of placements along it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from gm_ompl.holds.extraction import Leg, merged
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.motion.object_graph import GraphArc, Way
from gm_ompl.problem import Displacement, Move, Problem
from gm_ompl.sampling.stages import after


def way_and_legs(problem: Problem, moves: Sequence[Move]) -> tuple[Way, list[Leg]]:
    """Return a plan's way and legs; arcs of several strides become as many arcs.

    Args:
        problem: what was planned, with the table that the moves name.
        moves: the plan, at least one move.
    """
    sets = PlacementSets(problem.fingers.groups())
    first = moves[0]
    here, pose = (
        (first.start, first.arc.start)
        if isinstance(first, Displacement)
        else (first.at, first.pose)
    )
    coordinates, poses, arcs = [here], [pose], list[GraphArc]()
    placements, entered, legs = first.placements, 0, list[Leg]()
    for move in moves:
        if isinstance(move, Displacement):
            for arc, end, parts in _strides(problem, move):
                arcs.append(GraphArc(len(arcs) + 1, arc, parts))
                coordinates.append(end)
                poses.append(arc.end)
        else:
            legs.append((sets.canonical(placements), entered, len(arcs)))
            placements, entered = after(move), len(arcs)
    legs.append((sets.canonical(placements), entered, len(arcs)))
    return Way(tuple(poses), tuple(coordinates), tuple(arcs)), merged(legs)


def _strides(problem: Problem, move: Displacement) -> Iterator[tuple[Arc, Coordinates, int]]:
    """Yield the arcs that a displacement spans, their ends and in how many segments each is judged.

    Free motion's arcs span one each.
    """
    parts = problem.cost.samples_per_arc
    count = len(move.segments) // parts
    if count == 1 or not problem.motion.dimension:
        yield move.arc, move.end, len(move.segments)
        return
    places = [between(move.start, move.end, k / count) for k in range(count)]
    for start, end in itertools.pairwise([*places, move.end]):
        yield problem.motion.arc(start, end), end, parts
