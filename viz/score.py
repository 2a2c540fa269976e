"""The animation as the plain values that the page's script plays from."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.state import ContactState
from gm_ompl.planfile.model import PlacementRecord

from .animation import Animation, ShownSegment
from .scene import SceneMessages

DIGITS: Final = 12  # significant digits of lengths and quaternions
PER_THRESHOLD: Final = 20.0  # the gauge of z ends at most at this many times z_min


def score(animation: Animation, scene: SceneMessages) -> dict[str, Any]:
    """Return what the page needs beside the scene's messages: JSON's types only.

    ``segments`` are rows: start, end, step, first pose, number of poses, modes, f_com, z, row of
    ``hands`` (each finger's row of ``places``), row of ``contacts``, lifted finger or -1, row of
    ``places`` it moves to or -1, row of ``paths`` or -1. ``links`` has per step rows of where a
    hand's links are, evenly spaced in time.
    """
    problem = animation.problem
    tables = _Tables(animation)
    segments = [tables.row(segment) for segment in animation.segments]
    poses = [row for segment in animation.segments for row in segment.poses]
    return {
        "duration": animation.duration,
        "scale": scene.scale,
        "size": problem.body.diagonal,
        "centre": numbers(scene.centre),
        "arrow": scene.arrow,
        "slots": scene.slots,
        "fMax": problem.fingers.max_normal_force.tolist(),
        "zMin": problem.mechanics.z_min,
        "zTop": z_top(animation),
        "names": list(problem.motion.names),
        "steps": _steps(animation),
        "chain": [
            {"first": link.steps[0], "last": link.steps[1], "words": link.words}
            for link in animation.chain
        ],
        "segments": segments,
        "poses": [numbers(row) for row in poses or [animation.rest_pose()]],
        "places": tables.places,
        "hands": tables.hands,
        "contacts": tables.contacts,
        "paths": tables.paths,
        "fingers": problem.fingers.count,
        "links": [[[numbers(p) for p in row] for row in step] for step in animation.link_poses()],
    }


def z_top(animation: Animation) -> float:
    """Return the value of z at the end of its gauge and axis."""
    found = [segment.record.z for segment in animation.segments]
    if not found:
        return 1.0
    threshold = animation.problem.mechanics.z_min
    most = max(found)
    if threshold > 0:
        most = min(most, max(PER_THRESHOLD * threshold, 1.5 * float(np.median(found))))
    return 1.08 * max(most, threshold) or 1.0


def _steps(animation: Animation) -> list[dict[str, Any]]:
    """Return what can be read of each step; ``spent`` is the cost up to its end."""
    rows, spent = [], 0.0
    for start, step in zip(animation.step_starts, animation.plan.steps, strict=True):
        ends = (step.at, step.at) if step.kind == "regrasp" else (step.from_, step.to)
        spent += step.cost
        rows.append({
            "t": start, "kind": step.kind, "from": list(ends[0]), "to": list(ends[1]),
            "cost": step.cost, "spent": spent,
        })  # fmt: skip
    return rows


class _Tables:
    """Placements, contact states and paths, each stored once."""

    def __init__(self, animation: Animation) -> None:
        self._animation = animation
        self.places: list[dict[str, Any]] = []
        self.hands: list[list[int]] = []
        self.contacts: list[list[list[float]]] = []
        self.paths: list[list[list[float]]] = []
        self._known: dict[object, int] = {}
        self._poses = 0

    def row(self, segment: ShownSegment) -> list[Any]:
        """Return ``segment`` as one row."""
        places = [self._place(i, place) for i, place in enumerate(segment.placements)]
        lifted = [-1, -1, -1]
        if segment.regrasp is not None:
            finger, to = segment.regrasp.finger, segment.regrasp.to
            lifted = [finger, self._place(finger, to), len(self.paths)]
            self.paths.append([numbers(p) for p in segment.path])
        first = self._poses
        self._poses += len(segment.poses)
        return [
            segment.start, segment.end, segment.step, first, len(segment.poses), segment.modes,
            list(segment.record.f_com), segment.record.z, self._once(self.hands, places),
            self._once(self.contacts, self._markers(segment.contacts)),
            *lifted,
        ]  # fmt: skip

    def _place(self, finger: int, place: PlacementRecord) -> int:
        return self._once(self.places, {
            "label": place.words,
            "centre": numbers(self._animation.centre(finger, place)),
            "turn": numbers(turn_to(np.asarray(place.normal))),
        })  # fmt: skip

    def _markers(self, contacts: ContactState) -> list[list[float]]:
        step = 1e-6 * self._animation.problem.body.diagonal
        points = np.round(contacts.points / step) * step
        sliding = [bool(slip.any()) for slip in contacts.slip]
        return [[*numbers(p), int(s)] for p, s in zip(points, sliding, strict=True)]

    def _once(self, table: list[Any], value: Any) -> int:
        key = (id(table), repr(value))
        if key not in self._known:
            table.append(value)
            self._known[key] = len(table) - 1
        return self._known[key]


def turn_to(normal: Array) -> Array:
    """Return the quaternion (w, x, y, z) that turns the z axis to the unit ``normal``."""
    x, y, z = (float(value) for value in normal)
    if z < -1.0 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    quaternion = np.array([1.0 + z, -y, x, 0.0])
    turned: Array = quaternion / np.linalg.norm(quaternion)
    return turned


def numbers(values: Iterable[float]) -> list[float]:
    """Return ``values`` as floats of ``DIGITS`` significant digits."""
    return [float(f"{float(value):.{DIGITS}g}") for value in values]
