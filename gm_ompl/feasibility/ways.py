"""A fingertip's way through the air from one placement to another, every stretch of it swept."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.reach import Reach, Staying
from gm_ompl.feasibility.space import Space
from gm_ompl.geometry.air import FreeAir
from gm_ompl.geometry.flood import Ending, for_ever, nodes_of, straight_ways
from gm_ompl.geometry.pose import Pose
from gm_ompl.problem import Move, Regrasp

MARGINS: Final = (0.5, 0.125, 0.0)
"""How much wider than the fingertip a way is looked for first, in ``Fingers.clearance``."""

SHELL: Final = np.array([p for p in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(p)])
"""Corners, middles of edges and middles of faces of a cube."""

FAR_SHELL: Final = 3.0
"""Half the side of the farthest one, in extents of the scene."""

ROUNDS: Final = 3
"""Of halving a way's stretches and cutting its corners."""


def way_through_air(
    reach: Reach, pose: Pose, finger: int, staying: Staying, a: int, b: int
) -> Array | None:
    """Return the corners (k, 3), world frame, of a fingertip's way between two placements.

    The first and the last stretch are along the normals. None where fingers do not go through the
    air (``fingers.transit``), or no way is found.

    Args:
        reach: of the problem.
        pose: where the object rests.
        finger: who goes.
        staying: the others that are in place.
        a: from which placement.
        b: to which.
    """
    if not reach.active:
        return None
    space = reach.space(pose, finger, staying)
    ends = [reach.stubs(space, finger, row) for row in (a, b)]
    if not all(len(stubs) for stubs in ends):
        return None
    for margin in MARGINS:
        limits.check()
        found = _between(reach, space.air.wider(margin * reach.clearance(finger)), *ends)
        if found is not None:
            break
    else:
        found = _flooded(space, *ends)
        if found is None:
            found = _far_around(space, *ends)
        if found is None:
            return None
        found = shortened(space.air, found)
    tips = [reach.centre(finger, row)[None] for row in (a, b)]
    return pose.apply(np.concatenate([tips[0], found, tips[1]]))


def with_ways(reach: Reach, moves: Sequence[Move]) -> tuple[Move, ...]:
    """Return a plan's moves, each regrasp with its way through the air."""
    return tuple(_with_way(reach, move) if isinstance(move, Regrasp) else move for move in moves)


def _with_way(reach: Reach, move: Regrasp) -> Regrasp:
    i, rows = move.finger, move.placements
    staying = tuple((k, row) for k, row in enumerate(rows) if k != i)
    way = way_through_air(reach, move.pose, i, staying, rows[i], move.target)
    return replace(move, way=way)


def _between(reach: Reach, air: FreeAir, first: Array, last: Array) -> Array | None:
    """Return the shortest way from a point of ``first`` to one of ``last``, around the object."""
    i, j = (k.ravel() for k in np.indices((len(first), len(last))))
    straight = air.clear(first[i], last[j])
    if straight.any():
        lengths = np.linalg.norm(first[i] - last[j], axis=1)
        lengths += np.linalg.norm(first[i] - first[0], axis=1)
        lengths += np.linalg.norm(last[j] - last[0], axis=1)
        k = int(np.where(straight, lengths, np.inf).argmin())
        return np.array([first[i[k]], last[j[k]]])
    low, high = reach.bounds
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    more = 2.0 * air.radius
    shells = [middle + SHELL * (half + wide) for wide in (more, more + half.max())]
    away = (2.0 * float(np.linalg.norm(half)) + more) * straight_ways(air)
    exits = [_straight_on(air, points, away) for points in (first, last)]
    found = _roadmap(air, first, last, np.concatenate([*shells, *exits]))
    return None if found is None else shortened(air, found)


def _roadmap(air: FreeAir, first: Array, last: Array, others: Array) -> Array | None:
    """Return the shortest way over straight stretches between all these points."""
    from scipy.sparse import csr_matrix  # takes long to load
    from scipy.sparse.csgraph import dijkstra

    points = np.concatenate([first, last, others])
    i, j = np.triu_indices(len(points), 1)
    free = air.clear(points[i], points[j])
    if not free.any():
        return None
    lengths = np.linalg.norm(points[i] - points[j], axis=1)
    graph = csr_matrix((lengths[free], (i[free], j[free])), shape=(len(points),) * 2)
    starts = np.arange(len(first))
    length, before = dijkstra(graph, False, starts, True)
    ends = np.arange(len(first), len(first) + len(last))
    rise = np.linalg.norm(first - first[0], axis=1)[:, None]
    whole = length[:, ends] + rise + np.linalg.norm(last - last[0], axis=1)
    start, end = np.unravel_index(int(whole.argmin()), whole.shape)
    if not np.isfinite(whole[start, end]):
        return None
    return points[_traced(before[start], int(starts[start]), int(ends[end]))]


def _traced(before: IntArray, start: int, end: int) -> list[int]:
    way = [end]
    while way[-1] != start:
        way.append(int(before[way[-1]]))
    return way[::-1]


def _flooded(space: Space, first: Array, last: Array) -> Array | None:
    """Return a way over a grid, the coarsest that has one."""
    for grid in (fills.grid for fills in space.swept):
        seeds, sought = grid.joints(first), grid.joints(last)
        if not len(seeds) or not len(sought):
            continue
        flood = grid.fill(seeds, frozenset(sought.tolist()), leaves=False)
        if flood.ending is Ending.FOUND:
            nodes = grid.places(nodes_of(np.array(flood.back(flood.last))))
            head, tail = _joint(space.air, first, nodes[0]), _joint(space.air, last, nodes[-1])
            return np.concatenate([head[None], nodes, tail[None]])
    return None


def _joint(air: FreeAir, points: Array, node: Array) -> Array:
    """Return the nearest of ``points`` that joins ``node``."""
    free = air.clear(points, np.tile(node, (len(points), 1)))
    away = np.where(free, np.linalg.norm(points - node, axis=1), np.inf)
    nearest: Array = points[int(away.argmin())]
    return nearest


def _far_around(space: Space, first: Array, last: Array) -> Array | None:
    """Return a way that leads far away and comes back."""
    ends = [way_out(space, stubs) for stubs in (first, last)]
    if ends[0] is None or ends[1] is None:
        return None
    shell = FAR_SHELL * space.air.extent * SHELL
    found = _roadmap(space.air, ends[0][-1:], ends[1][-1:], shell)
    if found is None:
        return None
    return np.concatenate([ends[0][:-1], found, ends[1][-2::-1]])


def way_out(space: Space, stubs: Array) -> Array | None:
    """Return a way (k, 3) from one of ``stubs`` to far away, object frame; None without one."""
    straight = _straight_out(space.air, stubs)
    if straight is not None:
        return straight
    for grid in (fills.grid for fills in space.swept):
        flood = grid.fill(grid.joints(stubs))
        if flood.ending is Ending.OUTSIDE:
            way = grid.places(nodes_of(np.array(flood.back(flood.last))))
            off = _straight_out(space.air, way[-1:])
            assert off is not None, "the fill left from here"
            return np.concatenate([_joint(space.air, stubs, way[0])[None], way, off[1:]])
    return None


def _straight_out(air: FreeAir, points: Array) -> Array | None:
    """Return one of ``points`` that can go straight on for ever, and where it comes to."""
    away = for_ever(air) * straight_ways(air)
    for point in points:
        ends = _straight_on(air, point[None], away)
        if len(ends):
            return np.array([point, ends[0]])
    return None


def _straight_on(air: FreeAir, points: Array, away: Array) -> Array:
    """Return where ``points`` (n, 3) come to by the ways (w, 3), of those that are free."""
    starts = np.repeat(points, len(away), axis=0)
    ends: Array = starts + np.tile(away, (len(points), 1))
    return ends[air.clear(starts, ends)]


def shortened(air: FreeAir, corners: Array) -> Array:
    """Return a way with its corners cut where that is free; its ends stay."""
    for round_ in range(ROUNDS):
        try:
            limits.check()
        except LimitError:
            break  # the way is free as it is
        if round_:
            middles = (corners[:-1] + corners[1:]) / 2.0
            halved = np.empty((2 * len(corners) - 1, 3))
            halved[::2], halved[1::2] = corners, middles
            corners = halved
        corners = _cut(air, corners)
    return corners


def _cut(air: FreeAir, corners: Array) -> Array:
    """Return the corners left when every free short cut is taken, from the start on."""
    kept, k = [0], 0
    while k < len(corners) - 1:
        ahead = np.arange(k + 1, len(corners))
        free = air.clear(np.tile(corners[k], (len(ahead), 1)), corners[ahead])
        free[0] = True
        k = int(ahead[np.flatnonzero(free)[-1]])
        kept.append(k)
    return corners[kept]
