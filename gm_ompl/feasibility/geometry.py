"""What geometry alone says at a pose, and along screws up to the nodes they lead to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.cores import share_out
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.swept import SweptScene
from gm_ompl.problem import Placements, Problem

if TYPE_CHECKING:
    from gm_ompl.feasibility.course_passages import Crossing
    from gm_ompl.motion.courses import Courses

AT_ONCE: Final = 1000
"""Screws between two looks at the limits in force."""

A_THREAD: Final = 50
"""Screws that take longer than it takes to start a thread."""


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
    """Says what is free along screws.

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
        from gm_ompl.feasibility.course_passages import Crossing  # free motion alone asks

        swept, centres = self._swept, self._centres
        return Crossing(
            swept.body, swept.obstacles, swept.floor, swept.depth,
            np.array(list(centres.values())), np.array(list(self._clear_of_object.values())),
            np.array([swept.gaps(radius) for radius in centres]),
        )  # fmt: skip

    def along(self, courses: Courses) -> tuple[BoolArray, BoolArray]:
        """Return whether the object (m,) and which fingertips (m, n, P) are free along screws.

        The nodes that they lead to are part of them; poses at ends are not asked for by themselves.

        Raises:
            LimitError: a limit in force is reached.
        """
        from gm_ompl.feasibility.course_passages import pass_along

        crossing, count = self._crossing, len(courses.parts)
        object_free = np.empty(count, dtype=np.bool_)
        free = np.empty((count, *crossing.apart.shape), dtype=np.bool_)

        def work(part: slice) -> None:
            pass_along(courses.some(part), crossing, object_free[part], free[part])

        share_out(work, count, A_THREAD, AT_ONCE)
        return object_free, free[:, self._which]
