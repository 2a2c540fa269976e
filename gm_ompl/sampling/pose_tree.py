"""A tree over poses of free motion, grown where some hand carries the object."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.holds.watch import Stop
from gm_ompl.motion.free import PoseGoal, angle_between
from gm_ompl.sampling.carrying import Carrying
from gm_ompl.sampling.screws import Leap, Screws, Stride

ROOT: Final = -1
"""Stands for the parent of the vertex at the start."""

GOAL_SHARE: Final = 0.3
"""Share of the samples that are the goal."""

ROAMING_SHARE: Final = 0.3
"""Share of the steps that go any way on offer from any vertex."""

TRIED: Final = 4
"""Leaps tried from a vertex towards a sample, the most helpful first."""

APPROACHES: Final = 40
"""Leaps in a row on the way to the goal."""

NEARER: Final = 1e-6
"""A leap helps where it brings the object nearer by more than this, relative to D."""


@dataclass(frozen=True, eq=False)
class TreePose:
    """A pose that the tree came to.

    Attributes:
        place: its number.
        parent: the vertex before, or ROOT.
        strides: from there.
        sets: (m, n), sets of placements that hold on the last of them; None at the start: any.
        regrasps: regrasps on the way from the start, about.
        length: the way of the object from the start.
    """

    place: int
    parent: int
    strides: tuple[Stride, ...]
    sets: IntArray | None
    regrasps: int
    length: float


def nearest_in(goal: PoseGoal, pose: Pose) -> Pose:
    """Return the pose in the goal that is nearest to ``pose``."""
    position = np.minimum(np.maximum(pose.position, goal.low), goal.high)
    rotation = pose.rotation
    if goal.rotation is not None:
        rotation = goal.rotation
    elif goal.up is not None:
        up = rotation @ goal.up
        axis = np.array([up[1], -up[0], 0.0])  # up x z
        sine = float(np.linalg.norm(axis))
        if sine > 0.0:
            rotation = rotation_about(axis, math.atan2(sine, float(up[2]))) @ rotation
        elif up[2] < 0.0:
            rotation = rotation_about([1.0, 0.0, 0.0], math.pi) @ rotation
    return Pose(rotation, position)


@final
class Metric:
    """How far poses are apart: the way of the centre of mass, and half D times the turn.

    Args:
        diagonal: D.

    Attributes:
        none: what is nearer than this is one.
    """

    def __init__(self, diagonal: float) -> None:
        self.turn, self.none = diagonal / 2.0, NEARER * diagonal

    def between(self, a: Pose, b: Pose) -> float:
        """Return the distance of two poses."""
        gap = a.position - b.position
        return math.sqrt(float(gap @ gap)) + self.turn * angle_between(a.rotation, b.rotation)

    def nearer(self, leaps: Sequence[Leap], here: Pose, target: Pose) -> list[Leap]:
        """Return the leaps from ``here`` that lead nearer to a target, the most helpful first."""
        most = self.between(here, target) - self.none
        ranked = sorted((self.between(leap.end, target), k) for k, leap in enumerate(leaps))
        return [leaps[k] for far, k in ranked if far < most]

    def nearest(self, positions: Array, rotations: Array, pose: Pose, weights: Array) -> int:
        """Return which of some poses (k, 3), (k, 3, 3) is nearest, distances weighted (k,)."""
        gaps = np.linalg.norm(positions - pose.position, axis=1)
        cosine = (np.einsum("kij,ij->k", rotations, pose.rotation) - 1.0) / 2.0
        turned = np.arccos(np.clip(cosine, -1.0, 1.0))
        return int(np.argmin((gaps + self.turn * turned) * weights))


@final
class PoseTree:
    """Grows from the start.

    Args:
        screws: the object's motions.
        carrying: finds hands for them.
        metric: tells how far poses are apart.
        lifts: whether a hand may carry the object where it touches nothing.
        rng: the source of randomness.

    Attributes:
        vertices: as they were added.
    """

    def __init__(
        self,
        screws: Screws,
        carrying: Carrying,
        metric: Metric,
        lifts: bool,
        rng: np.random.Generator,
    ) -> None:
        self._screws, self._carrying, self._rng = screws, carrying, rng
        self._lifts, self._metric = lifts, metric
        self._goal = screws.motion.goal
        self.vertices: list[TreePose] = []
        self._positions: Array = np.zeros((0, 3))
        self._rotations: Array = np.zeros((0, 3, 3))
        self._at: dict[int, int] = {}
        self._tired: Array = np.zeros(0)
        self._tried: dict[int, list[Pose]] = {}
        self._add(TreePose(screws.start, ROOT, (), None, 0, 0.0))

    def _add(self, vertex: TreePose) -> int | None:
        known = self._at.get(vertex.place)
        if known is not None:
            other = self.vertices[known]
            if (other.regrasps, other.length) <= (vertex.regrasps, vertex.length):
                return None
        number, pose = len(self.vertices), self._screws.pose(vertex.place)
        self.vertices.append(vertex)
        self._positions = np.concatenate([self._positions, pose.position[None]])
        self._rotations = np.concatenate([self._rotations, pose.rotation[None]])
        self._tired = np.append(self._tired, 0.0)
        self._at[vertex.place] = number
        return number

    def path(self, number: int) -> list[Stride]:
        """Return the strides from the start to a vertex."""
        strides = list[Stride]()
        while number != ROOT:
            vertex = self.vertices[number]
            strides = [*vertex.strides, *strides]
            number = vertex.parent
        return strides

    def search(self, steps: int, stop: Stop) -> int | None:
        """Return a vertex in the goal, found within so many steps."""
        found = self._approach(0, stop)
        if found is not None:
            return found
        for _ in range(steps):
            if stop():
                return None
            new = self._step()
            if new is not None:
                found = self._approach(new, stop)
                if found is not None:
                    return found
        return None

    def _step(self) -> int | None:
        """Grow a leap."""
        if self._rng.random() < ROAMING_SHARE:
            weights = 1.0 / (1.0 + self._tired)
            number = int(self._rng.choice(len(weights), p=weights / weights.sum()))
            self._tired[number] += 1.0
            leaps = self._leaps(number, self._anywhere())
            order = self._rng.permutation(len(leaps)).tolist()
            return self._first(number, (leaps[k] for k in order[:TRIED]))
        target = self._anywhere()
        weights = 1.0 + self._tired
        number = self._metric.nearest(self._positions, self._rotations, target, weights)
        self._tired[number] += 0.2
        return self._first(number, self._helping(number, target))

    def _first(self, number: int, leaps: Iterator[Leap]) -> int | None:
        """Return the vertex to which the first leap leads along which the object is carried."""
        for leap in leaps:
            new = self._grown(number, leap)
            if new is not None:
                return new
        return None

    def _approach(self, number: int, stop: Stop) -> int | None:
        """Go on to the goal for as long as that gets nearer; return a vertex there."""
        for _ in range(APPROACHES):
            here = self._screws.pose(self.vertices[number].place)
            if self._goal.contains(here):
                return number
            if stop():
                return None
            new = self._first(number, self._helping(number, nearest_in(self._goal, here)))
            if new is None:
                return None
            number = new
        return None

    def _leaps(self, number: int, target: Pose) -> list[Leap]:
        """Return the leaps from a vertex that are no longer than they were tried."""
        leaps = self._screws.towards(self.vertices[number].place, target)
        tried = self._tried.get(number, [])
        return [
            leap
            for leap in leaps
            if (self._lifts or not leap.bare)
            and not any(self._metric.between(leap.end, end) <= self._metric.none for end in tried)
        ]

    def _helping(self, number: int, target: Pose) -> Iterator[Leap]:
        """Return leaps that bring the object nearer to a target, the most helpful first."""
        here = self._screws.pose(self.vertices[number].place)
        return iter(self._metric.nearer(self._leaps(number, target), here, target)[:TRIED])

    def _grown(self, number: int, leap: Leap) -> int | None:
        """Return the vertex to which a leap leads, as far as the object is carried along it."""
        self._tried.setdefault(number, []).append(leap.end)
        vertex, strides = self.vertices[number], self._screws.strides(leap)
        carried = self._carrying.carry(self.path(number), strides, vertex.sets)
        if carried.strides == 0:
            return None
        passed = tuple(strides[: carried.strides])
        place = passed[-1].arc.head
        length = self._metric.between(self._screws.pose(vertex.place), self._screws.pose(place))
        return self._add(
            TreePose(
                place, number, passed, carried.sets, vertex.regrasps + carried.regrasps,
                vertex.length + length,
            )
        )  # fmt: skip

    def _anywhere(self) -> Pose:
        """Return a sample: the goal, or a pose anywhere, often turned as one that is known."""
        rng, vertices = self._rng, self.vertices
        known = self._screws.pose(vertices[int(rng.integers(len(vertices)))].place)
        if rng.random() < GOAL_SHARE:
            return nearest_in(self._goal, known)
        low, high = self._screws.motion.region
        rotation = known.rotation
        chance = rng.random()
        if chance < 0.3:
            rotation = nearest_in(self._goal, known).rotation
        elif chance < 0.6:
            rotation = rotation_about(self._axis(), rng.uniform(-math.pi, math.pi)) @ rotation
        return Pose(rotation, rng.uniform(low, high))

    def _axis(self) -> Array:
        """Return a direction about which the object may turn."""
        allowed = self._screws.motion.steps.rotate
        if allowed is not None and len(allowed):
            axis: Array = allowed[int(self._rng.integers(len(allowed)))]
            return axis
        direction: Array = self._rng.normal(size=3)
        return direction / np.linalg.norm(direction)
