"""The object on an open floor, wherever on it: its attitudes, and the rotations between them.

Where it touches nothing but a floor and no hand lifts it, what may follow at a pose depends on how
it stands alone, but for rotations, which may not begin everywhere. So a way on the contact lattice
is one on this graph, with translations along the floor between the rotations.
"""

from __future__ import annotations

import dataclasses
from typing import Final, NamedTuple

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.contact.lattice import ContactLattice
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import TOUCHING
from gm_ompl.graph.arc_classes import arcs_leaving
from gm_ompl.graph.closure import lifts
from gm_ompl.motion.courses import Courses
from gm_ompl.motion.free import FreeMotion, PoseGoal
from gm_ompl.problem import Problem

MOST: Final = 20_000
"""Attitudes of a graph that is made."""

NEAR: Final = 1e-6
"""Attitudes as near as this are one: entries of rotations, heights over D."""

FAR: Final = 1e4
"""How far from the start the object may roll meanwhile, over D."""


class FloorGraph(NamedTuple):
    """Attitudes, and arcs between them.

    Attributes:
        looks: (A, 10), each one's rotation and height over D; the start is 0.
        arrived: (A,), whether the goal allows it.
        tails: (K,), attitudes that arcs leave.
        heads: (K,), those they lead to.
        courses: the arcs, somewhere on the floor.
    """

    looks: Array
    arrived: BoolArray
    tails: IntArray
    heads: IntArray
    courses: Courses


def on_open_floor(problem: Problem) -> bool:
    """Whether a problem of free motion is on an open floor, and no hand lifts the object off."""
    environment, plain = problem.environment, problem.hand is None and not problem.uncertainty
    open_ = environment.floor and not environment.obstacles and not lifts(problem)
    return plain and open_ and _stands(problem)


def _stands(problem: Problem) -> bool:
    """Whether the object keeps the height that its attitude gives it, on two points or more.

    Within a wide contact tolerance it rises and sinks on the floor. On a single point it turns
    about lines through it; such a rotation may go on about a line that is no contact line any more
    when others have landed. On two points or more it stays so.
    """
    motion, body, tolerance = problem.motion, problem.body, problem.environment.contact_tolerance
    assert isinstance(motion, FreeMotion)
    corners, near = motion.start.apply(body.vertices), tolerance * body.diagonal
    low = corners[corners[:, 2] <= near, :2]
    width = float(np.linalg.norm(np.ptp(low, axis=0))) if len(low) else 0.0
    return bool(tolerance <= TOUCHING and width > 2.0 * near)


def floor_graph(problem: Problem) -> FloorGraph | None:
    """Return the graph of a problem ``on_open_floor``; None where it is too large.

    Raises:
        LimitError: a limit in force is reached.
    """
    motion, D = problem.motion, problem.body.diagonal
    assert isinstance(motion, FreeMotion)
    start, region = motion.start.position, motion.region.copy()
    region[:, :2] = start[:2] + FAR * D * np.array([[-1.0], [1.0]])
    steps = dataclasses.replace(motion.steps, translate=(), depth=None)
    rolling = FreeMotion(motion.start, motion.goal, region, steps)
    rolling.ends = motion.ends
    graph = dataclasses.replace(problem, motion=rolling).object_graph
    assert isinstance(graph, ContactLattice)
    known, layer = looks(*graph.poses(np.array([graph.start])), D), np.array([graph.start])
    arcs, tails = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    while len(layer):
        limits.check()
        leaving, of = _leaving(graph, layer)
        arcs.append(leaving)
        tails.append(len(known) - len(layer) + of)
        heads = graph.arcs.rows.heads[leaving]
        there = looks(*graph.poses(heads), D)
        fresh = np.flatnonzero(nearest(known, there) < 0)
        first = np.unique(np.rint(there[fresh] / NEAR), axis=0, return_index=True)[1]
        layer, known = heads[fresh[first]], np.concatenate([known, there[fresh[first]]])
        if len(known) > MOST:
            return None
    which = np.concatenate(arcs)
    heads = nearest(known, looks(*graph.poses(graph.arcs.rows.heads[which]), D))
    arrived = _arrived(motion.goal, known, D)
    return FloorGraph(known, arrived, np.concatenate(tails), heads, graph.courses(which))


def _leaving(graph: ContactLattice, nodes: IntArray) -> tuple[IntArray, IntArray]:
    """Return the rotations on the floor that leave nodes (N,), and which each leaves."""
    graph.leave(nodes.tolist())
    leaving, of = arcs_leaving(graph, nodes)
    rows = graph.arcs.rows
    stays = rows.turns[leaving] & ~rows.bare[leaving]
    return leaving[stays], of[stays]


def looks(rotations: Array, positions: Array, D: float) -> Array:
    """Return what tells attitudes (N, 10) of poses, see ``FloorGraph``."""
    return np.column_stack([rotations.reshape(-1, 9), positions[:, 2] / D])


def nearest(known: Array, asked: Array) -> IntArray:
    """Return which of attitudes (A, 10) those asked for are (N,); -1 where they are none."""
    from scipy.spatial import cKDTree  # takes long to load

    far, found = cKDTree(known).query(asked, distance_upper_bound=2.0 * NEAR)
    return np.where(np.isfinite(far), found, -1)


def _arrived(goal: PoseGoal, known: Array, D: float) -> BoolArray:
    """Return which attitudes the goal allows, or may allow: they stand for others near them."""
    middle, near = (goal.low + goal.high) / 2.0, 4.0 * NEAR
    goal = dataclasses.replace(goal, distance=goal.distance + near * D, angle=goal.angle + near)
    poses = [Pose(row[:9].reshape(3, 3), np.array([*middle[:2], row[9] * D])) for row in known]
    return np.array([goal.contains(pose) for pose in poses])
