"""What geometry alone says at a pose, and along an arc up to the node it leads to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.cores import share_out
from gm_ompl.feasibility.course_passages import Crossing, pass_along
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.packed import Drive, drive
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.swept import SweptScene
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.courses import Courses
from gm_ompl.problem import Placements, Problem

AT_ONCE: Final = 1000
"""Screws between two looks at the limits in force."""

UP = np.array([0.0, 0.0, 1.0])
NOWHERE = np.zeros(3)


@dataclass(frozen=True, eq=False)
class NodeGeometry:
    """What geometry alone says at one pose of the object, or all along an arc.

    Attributes:
        object_free: whether the object penetrates nothing.
        free: per finger, (P,), the placements at which its fingertip penetrates neither
            environment nor object; fingers of equal radius share one array.
    """

    object_free: bool
    free: tuple[BoolArray, ...]

    def admits(self, placements: Placements) -> bool:
        """Whether object and fingertips are free, the fingertips' mutual clearance left aside."""
        return self.object_free and all(
            mask[row] for mask, row in zip(self.free, placements, strict=True)
        )


@final
class Passages:
    """Says what is free along arcs.

    Args:
        problem: the problem.
        scene: its object and environment at single poses.
        swept: the same along motions.
        centres: (P, 3), of fingertips at every placement, object frame, by their radius.
    """

    def __init__(
        self, problem: Problem, scene: Scene, swept: SweptScene, centres: Mapping[float, Array]
    ) -> None:
        self._scene, self._swept, self._centres = scene, swept, centres
        self._radii: list[float] = problem.fingers.radius.tolist()
        self._which = [list(centres).index(radius) for radius in self._radii]
        self._piece = problem.fingers.placements.piece

    @cached_property
    def _clear_of_object(self) -> dict[float, BoolArray]:
        """Which fingertips penetrate no piece of the object, by their radius."""
        return {
            radius: self._scene.clear_of_object(centres, radius, self._piece)
            for radius, centres in self._centres.items()
        }

    @cached_property
    def _crossing(self) -> Crossing:
        """What compiled code goes by: fingertips by their radius."""
        swept, centres = self._swept, self._centres
        return Crossing(
            swept.body, swept.obstacles, swept.floor, swept.depth,
            np.array(list(centres.values())), np.array(list(self._clear_of_object.values())),
            np.array([swept.gaps(radius) for radius in centres]),
        )  # fmt: skip

    def along(self, courses: Courses) -> tuple[BoolArray, BoolArray]:
        """Return whether the object (m,) and which fingertips (m, n, P) are free along screws.

        The nodes that they lead to are part of them.

        Raises:
            LimitError: a limit in force is reached.
        """
        crossing, count = self._crossing, len(courses.parts)
        object_free = np.empty(count, dtype=np.bool_)
        free = np.empty((count, *crossing.apart.shape), dtype=np.bool_)

        def work(part: slice) -> None:
            pass_along(courses.some(part), crossing, object_free[part], free[part])

        share_out(work, count, most=AT_ONCE)
        return object_free, free[:, self._which]

    def passing(self, arc: Arc, head: Pose) -> NodeGeometry:
        """Return what geometry says along an arc and at the node it leads to.

        An arc's ends are part of it: the poses there are not asked for by themselves.
        """
        ways = [(sweep.start, drive(sweep)) for sweep in arc.sweeps]
        ways.append((head, Drive(head.position.copy(), UP, 0.0, NOWHERE)))
        object_free = all(self._swept.object_free_by(*way) for way in ways)
        free = {radius: mask & object_free for radius, mask in self._clear_of_object.items()}
        for radius, mask in free.items() if object_free else ():
            for start, motion in ways:
                self._swept.keep_free(mask, start.apply(self._centres[radius]), motion, radius)
        return NodeGeometry(object_free, tuple(free[radius] for radius in self._radii))
