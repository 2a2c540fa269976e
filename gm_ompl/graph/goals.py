"""Which lattice nodes are the start and the goal."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from gm_ompl.arrays import BoolArray
from gm_ompl.errors import InputError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.sets import ordered_sets
from gm_ompl.graph.watch import Stop, never, watched
from gm_ompl.motion.lattice import Coordinates, Lattice
from gm_ompl.problem import Goal, Placements, Problem

ON_LATTICE = 1e-9
"""How far a coordinate may be off its node, relative to its axis's extent."""


def start_node(problem: Problem) -> int:
    """Return the lattice node at the start.

    Raises:
        InputError: the start is off the lattice.
    """
    node = problem.lattice.find(problem.start, ON_LATTICE)
    if node is None:
        raise InputError(
            f"start {_named(problem, problem.start)} is not a node of the lattice "
            f"({_steps(problem)}); move the start or change the lattice's steps, or use a "
            "planner that needs no lattice"
        )
    return node


@final
class GoalNodes:
    """The lattice nodes in the goal.

    Attributes:
        nodes: their numbers, increasing.

    Raises:
        InputError: no node of the lattice lies in the goal.
    """

    def __init__(self, problem: Problem) -> None:
        self._required = problem.fingers.goal
        lattice = problem.lattice
        inside = [_inside(lattice, problem.goal, d) for d in range(len(lattice.axes))]
        if not all(inside):
            raise InputError(
                f"goal {_region(problem)} holds no node of the lattice "
                f"({_steps(problem)}); move the goal or change the lattice's steps, or use a "
                "planner that needs no lattice"
            )
        numbers = np.ravel_multi_index(np.ix_(*inside), lattice.shape)
        self.nodes: tuple[int, ...] = tuple(numbers.ravel().tolist())
        self._members = frozenset(self.nodes)

    def contains(self, config: int, placements: Placements) -> bool:
        """Whether ``config`` lies in the goal and the fingers are where the goal wants them."""
        return config in self._members and all(
            want is None or have == want
            for have, want in zip(placements, self._required, strict=True)
        )

    def reachable(self, problem: Problem, judge: Judge, stop: Stop = never) -> tuple[int, ...]:
        """Return the goal's nodes at which some set of placements is geometrically valid.

        Raises:
            Stopped: ``stop`` said so.
        """
        return tuple(n for n in watched(self.nodes, stop) if _has_set(problem, judge, n))


def _has_set(problem: Problem, judge: Judge, config: int) -> bool:
    geometry = judge.node(problem.motion.pose(problem.lattice.coordinates(config)))
    if not geometry.object_free:
        return False
    allowed = restricted(geometry.free, problem.fingers.goal)
    keys = [np.zeros(len(mask)) for mask in allowed]
    sets = ordered_sets(problem.fingers.groups(), allowed, keys, judge.clear)
    return next(sets, None) is not None


def restricted(
    free: tuple[BoolArray, ...],
    required: tuple[int | None, ...],
) -> tuple[BoolArray, ...]:
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


def _inside(lattice: Lattice, goal: Goal, d: int) -> list[int]:
    axis, period = lattice.axes[d], lattice.periods[d]
    extent = period or float(axis[-1] - axis[0]) or 1.0
    one = Goal((goal.low[d],), (goal.high[d],), (goal.periods[d],))
    return [
        k for k, value in enumerate(axis.tolist()) if one.contains((value,), ON_LATTICE * extent)
    ]


def _region(problem: Problem) -> str:
    goal, parts = problem.goal, []
    for name, low, high in zip(problem.motion.names, goal.low, goal.high, strict=True):
        if low is None or high is None:
            parts.append(f"{name} = any")
        else:
            parts.append(f"{name} = {low:g}" + ("" if low == high else f" to {high:g}"))
    return "(" + ", ".join(parts) + ")"


def _named(problem: Problem, values: Coordinates) -> str:
    pairs = zip(problem.motion.names, values, strict=True)
    return "(" + ", ".join(f"{n} = {v:g}" for n, v in pairs) + ")"


def _steps(problem: Problem) -> str:
    parts = []
    for name, axis in zip(problem.motion.names, problem.lattice.axes, strict=True):
        step = float(axis[1] - axis[0]) if len(axis) > 1 else math.nan
        spacing = f" in steps of {step:g}" if len(axis) > 1 else ""
        parts.append(f"{name} from {axis[0]:g} to {axis[-1]:g}{spacing}")
    return ", ".join(parts)
