"""A lower bound for planar motion: the object's own shortest way on its lattice."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.collision import Scene
from gm_ompl.holds.goals import blocked_at_all
from gm_ompl.holds.sets import LIFTED
from gm_ompl.holds.watch import Stop, never, watched
from gm_ompl.problem import Placements, Problem

LEVELS = 64
"""Costs are kept for so many distances of a fingertip from the yaw axis, others rounded down."""

MOST_NUMBERS = 2_000_000
"""Distances kept (8 bytes each); a larger lattice gets fewer levels, at least one."""

MOST_NODES = 700_000
"""Here a level takes some two thirds of a second, in which no limit is heard."""

NODE_BYTES = 350.0
"""What a node takes while the bound is made, beside its distances."""

MOST_TESTED = 30_000
"""On larger lattices the object counts as free everywhere: testing would outlast the search."""


@final
class PlanarHeuristic:
    """Stronger than (11): a fingertip follows lattice arcs, each along one coordinate.

    A displacement arc costs at least its step in x or y, or what its outermost fingertip travels
    in a step of yaw. So the object's shortest way on its lattice, past nodes at which it
    penetrates something, bounds the rest of a plan without regrasping; with fingertips as near to
    the yaw axis as any placement, and X_regr more, a plan with one. A finger blocked at every
    goal needs a regrasp.

    Args:
        judge: of the problem, whose motion is planar.
        goals: the goal's nodes; at least one.
        stop: asked now and then while the bound is made.

    Raises:
        LimitError: ``stop`` said so.
    """

    def __init__(self, judge: Judge, goals: tuple[int, ...], stop: Stop = never) -> None:
        problem = judge.problem
        hand, self._X_regr = problem.fingers, problem.cost.regrasp
        reach = [np.linalg.norm(judge.centres(i)[:, :2], axis=1) for i in range(hand.count)]
        count = max(1, min(LEVELS, MOST_NUMBERS // problem.lattice.size))
        levels = _levels(np.concatenate([np.zeros(0), *reach]), count)
        self._level: list[IntArray] = [
            np.searchsorted(levels, r, side="right").clip(1) - 1 for r in reach
        ]
        self._level_lists = [level.tolist() for level in self._level]
        self._distance = _distances(problem, goals, levels, stop)
        self._blocked = blocked_at_all(judge, goals)
        self._blocked_lists = [mask.tolist() for mask in self._blocked]

    def estimate(self, config: int, placements: Placements) -> float:
        """Return the bound for a node; +inf where the object cannot reach the goal."""
        regrasps, level = 0, 0
        for i, row in enumerate(placements):
            if row == LIFTED:
                continue
            if self._blocked_lists[i][row]:
                regrasps += 1
            level = max(level, self._level_lists[i][row])
        column = self._distance[config]
        nearest = float(column[0])
        if regrasps:
            return regrasps * self._X_regr + nearest
        return min(float(column[level]), self._X_regr + nearest)

    def finger_estimates(self, config: int) -> tuple[Array, ...]:
        """Return per finger (P,) the bound where it alone touches the object."""
        column = self._distance[config]
        with_one = self._X_regr + float(column[0])
        return tuple(
            np.where(mask, with_one, np.minimum(column[level], with_one))
            for mask, level in zip(self._blocked, self._level, strict=True)
        )


def _levels(reach: Array, count: int) -> Array:
    """Return at most ``count`` increasing lengths, the least of ``reach`` (k,) among them."""
    if not len(reach):
        return np.zeros(1)
    # Rounded down, so that a level never exceeds what it stands for.
    size = float(reach.max()) or 1.0
    found: Array = np.unique(np.floor(reach / size * 1e9) * 1e-9 * size)
    if len(found) > count:
        found = np.linspace(found[0], found[-1], count, endpoint=False)
    return found


def _distances(problem: Problem, goals: tuple[int, ...], levels: Array, stop: Stop) -> Array:
    """Return the object's least cost from every lattice node to the nearest goal, (size, levels).

    Per level, fingertips are that far from the yaw axis.
    """
    from scipy.sparse import coo_array  # takes long to load
    from scipy.sparse.csgraph import dijkstra

    # Parts of uneven length are no shorter together than one fewer of equal length.
    lattice, P = problem.lattice, problem.cost.samples_per_arc - problem.motion.ends
    free = _object_free(problem, stop)
    tails, heads, axis, steps = _edges(problem, free)
    found = np.full((lattice.size, len(levels)), np.inf)
    for k, level in enumerate(watched(levels, stop)):
        # Eq. (9) for a step of yaw: the chords of P equal segments.
        costs = np.where(axis == 2, 2.0 * P * level * np.sin(steps / (2.0 * P)), steps)
        # csgraph drops arcs of cost 0; a tip on the yaw axis does not move.
        costs = np.maximum(costs, 1e-12 * problem.body.diagonal)
        graph = coo_array((costs, (heads, tails)), shape=(lattice.size, lattice.size)).tocsr()
        found[:, k] = dijkstra(graph, indices=list(goals), min_only=True)
    # Sums along other paths differ by rounding: stay below them.
    return found * (1.0 - 1e-9)


def _edges(problem: Problem, free: BoolArray) -> tuple[IntArray, IntArray, IntArray, Array]:
    """Return tail, head, coordinate and length of every step between free nodes."""
    lattice = problem.lattice
    numbers = np.arange(lattice.size).reshape(lattice.shape)
    parts = []
    for d, (values, period) in enumerate(zip(lattice.axes, lattice.periods, strict=True)):
        tails, heads = np.moveaxis(numbers, d, 0)[:-1], np.moveaxis(numbers, d, 0)[1:]
        lengths = np.broadcast_to(np.diff(values)[:, None, None], tails.shape)
        parts.append((tails.ravel(), heads.ravel(), d, lengths.ravel()))
        if period is not None and len(values) >= 3:
            tails, heads = np.moveaxis(numbers, d, 0)[-1], np.moveaxis(numbers, d, 0)[0]
            last = float(values[0]) + period - float(values[-1])
            parts.append((tails.ravel(), heads.ravel(), d, np.full(tails.size, last)))
    tails = np.concatenate([part[i] for i in (0, 1) for part in parts])
    heads = np.concatenate([part[i] for i in (1, 0) for part in parts])
    axis = np.concatenate([np.full(len(part[0]), part[2]) for part in parts] * 2)
    lengths = np.concatenate([part[3] for part in parts] * 2)
    kept = free[tails] & free[heads]
    return tails[kept], heads[kept], axis[kept], lengths[kept]


def _object_free(problem: Problem, stop: Stop) -> BoolArray:
    """Return at which lattice nodes the object penetrates nothing, (size,)."""
    lattice, obstacles = problem.lattice, [o.body for o in problem.environment.obstacles]
    if not obstacles or lattice.size > MOST_TESTED:
        return np.ones(lattice.size, dtype=bool)
    scene = Scene(problem.body, obstacles, False, problem.environment.contact_tolerance)
    return np.array([
        scene.object_free(problem.motion.pose(lattice.coordinates(node)))
        for node in watched(range(lattice.size), stop)
    ])  # fmt: skip


def suits(problem: Problem) -> bool:
    """Whether the bound applies: planar motion, on a lattice that fits in memory."""
    planar, nodes = problem.motion.names == ("x", "y", "yaw"), math.prod(problem.lattice.shape)
    return planar and nodes <= MOST_NODES and limits.fits(NODE_BYTES * nodes + 8 * MOST_NUMBERS)
