"""What a scheduler says of instants: the state at rest, and phases appended one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.planfile.arcs import pose_before
from gm_ompl.planfile.model import Plan, RegraspStep
from gm_ompl.problem import Problem
from gm_ompl.simulation.hand_ways import AirWay, HandWays
from gm_ompl.simulation.segments import runs
from gm_ompl.simulation.timeline import PHASES, Pace, Timeline, progress, ramp
from gm_ompl.simulation.transit import TOUCHING, Transit
from gm_ompl.simulation.world import force_unit

TOUCH = 0.02
"""Force with which a finger feels for the surface, of the unit of force (the object's weight)."""


class Phases:
    """Phases laid down so far; ``now`` holds what a timeline says at rest."""

    def __init__(self, plan: Plan, problem: Problem, pace: Pace, dt: float, lean: bool) -> None:
        self.problem, self.pace, self.dt, self.lean = problem, pace, dt, lean
        self.parts = runs(plan, problem)
        self.size, self.touch = problem.body.diagonal, TOUCH * force_unit(problem)
        self.timelines: list[Timeline] = []
        self.notes: list[str] = []
        first, n = plan.steps[0], problem.fingers.count
        hand = None if plan.hand is None else HandWays(plan.hand, problem, dt)
        z = first.z if isinstance(first, RegraspStep) else first.segments[0].z
        self.pose = pose_before(plan, 0, problem)
        self.points = np.array([place.point for place in first.placements])
        self.normals = np.array([place.normal for place in first.placements])
        self.now = SimpleNamespace(
            force_share=np.zeros(n),
            f_com=np.zeros(n),
            lean=np.zeros((n, 3)),
            least=np.full(n, np.nan),
            most=np.full(n, np.nan),
            limit=np.full(n, self.touch),
            press=np.zeros(n),
            down=np.zeros(n, dtype=bool),
            landing=np.zeros(n, dtype=bool),
            step=-1,
            segment=-1,
            z=z,
            joints=np.zeros(0) if hand is None else hand.home(),
        )
        self.hand = hand

    def _samples(self, seconds: float) -> int:
        return max(2, round(seconds / self.dt))

    def _only(self, i: int, way: Array) -> Array:
        """Return centres (K, n, 3) of which one finger's goes its ``way`` (K, 3), others stay."""
        touching = self.points - self.problem.fingers.radius[:, None] * self.normals
        centres = np.tile(self.pose.apply(touching), (len(way), 1, 1))
        centres[:, i] = way
        return centres

    def _bring(self, i: int, corners: Array) -> None:
        """Bring the lifted finger ``i`` along a way to where it stands off its new placement."""
        speed = self.pace.transit * self.size
        lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        legs = [
            a + np.outer(progress(length, speed, self.pace.ramp / 2.0, self.dt) / length, b - a)
            for a, b, length in zip(corners, corners[1:], lengths, strict=False)
            if length > 0
        ]
        path = np.concatenate(legs) if legs else corners[:1]
        self._add("transit", [self.pose] * len(path), self._only(i, path))

    def _transit(self) -> Transit:
        height = self.pace.clearance * self.size
        return Transit(self.problem, self.pose, self.points, self.normals, height)

    def _standing(self, tips: Array) -> Array:
        """Return (n, 3), how fingertips' centres (n, 3), world frame, stand off, object frame."""
        touching = self.points - self.problem.fingers.radius[:, None] * self.normals
        off: Array = self.pose.to_object(tips) - touching
        return off

    def _offs(self, which: BoolArray) -> Array:
        """Return (n, 3), how the fingers ``which`` stand off, object frame; 0 for the others."""
        transit, offs = self._transit(), np.zeros_like(self.points)
        for i in np.flatnonzero(which).tolist():
            offs[i] = transit.off(i, self.points[i], self.normals[i])
        return offs

    def _turned(self, share: Array, joints: Array) -> Array:
        """Return (K, k), the hinges on their way to ``joints`` after ``share`` (K,) of it."""
        now = self.now.joints
        self.now.joints = joints
        return np.asarray(now + np.multiply.outer(share, joints - now))

    def _lowered(self, phase: str, offs: Array, joints: Array) -> Array:
        """Bring fingers from ``offs`` (n, 3) nearer, from where they come down slowly.

        The plan has the hinges at ``joints`` (k,) where they touch.
        """
        far = np.linalg.norm(offs, axis=1, keepdims=True)
        near: Array = offs * np.minimum(
            1.0, self.pace.clearance * self.size / np.maximum(far, 1e-12)
        )
        falling = 1.0 - ramp(self._samples(self.pace.lift))
        off = near + falling[:, None, None] * (offs - near)
        self._rest(phase, self.pace.lift, off, joints=self._turned(1.0 - falling, joints))
        return near

    def _land(self, phase: str, which: BoolArray, offs: Array) -> None:
        """Bring fingers down to their placements, and a little beyond until they feel it.

        They come from ``offs`` (n, 3) off them, object frame.
        """
        lift = self.pace.lift
        falling = ramp(self._samples(lift))[:, None]
        beside = np.abs((offs * self.normals).sum(axis=1)) <= TOUCHING * self.size
        if (offs[beside] != 0.0).any():
            # A finger that felt for the surface before it is there would land on an edge.
            share = np.where(beside[:, None], 1.0 - falling[:, :, None], 1.0)
            self._rest(phase, lift, share * offs)
            offs = np.where(beside[:, None], 0.0, offs)
        press = falling * (self.pace.reach * self.size * which)
        looking = np.tile(which, (len(falling), 1))
        self._rest(phase, lift, (1.0 - falling[:, :, None]) * offs, press=press, landing=looking)
        self.now.down = self.now.down | which

    def _rest(
        self, phase: str, seconds: float, off: Array | float = 0.0, **arrays: Array | BoolArray
    ) -> None:
        self._add(phase, [self.pose] * self._samples(seconds), None, off, **arrays)

    def _fly(self, phase: str, way: AirWay) -> None:
        self._add(phase, [self.pose] * len(way.joints), way.tips, joints=way.joints)
        self.now.joints = way.joints[-1]

    def _add(
        self,
        phase: str,
        way: Sequence[Pose],
        centres: Array | None = None,
        off: Array | float = 0.0,
        **arrays: Array | BoolArray,
    ) -> None:
        """Append instants at the K poses ``way``; what is not given stays as it is.

        Fingertips are ``off`` (K, n, 3) where they touch, object frame, or at ``centres``
        (K, n, 3), world frame.
        """
        K = len(way)
        position = np.array([pose.position for pose in way])
        rotation = np.array([pose.rotation for pose in way])
        local = self.points - self.problem.fingers.radius[:, None] * self.normals
        local = local + np.broadcast_to(off, (K, *local.shape))
        centre = np.einsum("tij,tnj->tni", rotation, local) + position[:, None]
        if centres is not None:
            centre = centres
        fields: dict[str, Any] = {}
        for name, value in {**vars(self.now), "phase": PHASES.index(phase)}.items():
            still = np.asarray(value)
            given = np.broadcast_to(arrays.pop(name, still), (K, *still.shape))
            fields[name] = given.astype(still.dtype)
        assert not arrays
        fields["lean"] = np.einsum("tij,tnj->tni", rotation, fields["lean"])
        normal = np.einsum("tij,nj->tni", rotation, self.normals)
        where = {"position": position, "rotation": rotation, "centre": centre, "normal": normal}
        self.timelines.append(Timeline(dt=self.dt, notes=tuple(self.notes), **where, **fields))
        self.notes.clear()
