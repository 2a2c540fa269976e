"""What the object does along an arc, told from its contacts: slides, tumbles, lifts off."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment, contacts_at, environment_contacts
from gm_ompl.contact.lines import parallel
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.motion.arc import Arc

AXES = ("x", "y", "z")
"""Names of the world's axes."""

ALONG = 1e-6
"""How far a direction may be off an axis that names it."""


ON_LINE = 1e-5
"""How far from a line a point may be that lies on it, relative to D."""


class Deed(enum.Enum):
    """What the object does; the value is the verb."""

    SLIDES = "slides"
    LIFTS = "lifts off"
    CARRIED = "is carried"
    TUMBLES = "tumbles"
    TURNS = "turns in place"
    SWINGS = "is turned in the air"

    @property
    def preposition(self) -> str:
        """What stands between the verb and an axis."""
        return "about" if self in (Deed.TUMBLES, Deed.TURNS, Deed.SWINGS) else "along"


class Doing(NamedTuple):
    """What the object does along an arc.

    Attributes:
        deed: the kind of it.
        over: what it tumbles over: "its +x edge", as seen from its centre of mass, "its corner", or
            "an edge of step"; None where it does not tumble, or stands over the line.
    """

    deed: Deed
    over: str | None = None


def doing(arc: Arc, body: Body, environment: Environment) -> Doing:
    """Return what the object does along a translation or a rotation, seen at its middle.

    Args:
        arc: the object's motion.
        body: the object, object frame.
        environment: what it touches.
    """
    middle, sweep = arc.moment(0.5), arc.sweeps[0]
    kept = contacts_at(middle, body, environment)
    normals = kept.normals @ middle.pose.rotation.T
    if not sweep.angle:
        if len(normals):
            return Doing(Deed.SLIDES)
        touched = len(environment_contacts(body, environment, arc.start).points)
        return Doing(Deed.LIFTS if touched else Deed.CARRIED)
    if not len(normals):
        return Doing(Deed.SWINGS)
    if all(parallel(normal, sweep.axis) for normal in normals):
        return Doing(Deed.TURNS)
    return Doing(Deed.TUMBLES, _pivot(sweep, normals[0], middle.pose, body, environment))


def _pivot(
    sweep: Sweep, normal: Array, middle: Pose, body: Body, environment: Environment
) -> str | None:
    """Return what the object tumbles over."""
    near = ON_LINE * body.diagonal
    corners = int((_off(sweep, sweep.start.apply(body.vertices)) <= near).sum())
    if not corners:
        return _edge_of(sweep, near, middle, body, environment)
    if corners == 1:
        return "its corner"
    arm = sweep.pivot - sweep.start.position
    for off in (sweep.axis, normal):
        arm = arm - (arm @ off) * off
    k = int(np.argmax(np.abs(arm)))
    if abs(arm[k]) <= near:
        return None
    return f"its {'-' if arm[k] < 0 else '+'}{AXES[k]} edge"


def _edge_of(
    sweep: Sweep, near: float, middle: Pose, body: Body, environment: Environment
) -> str | None:
    """Return the obstacle whose edge the line is: "an edge of step"."""
    for obstacle in environment.obstacles:
        alone = replace(environment, floor=False, obstacles=(obstacle,))
        points = environment_contacts(body, alone, middle).points
        if len(points) and _off(sweep, points).min() <= near:
            return f"an edge of {obstacle.name}"
    return None


def _off(sweep: Sweep, points: Array) -> Array:
    """Return how far points (n, 3), world frame, are from the line of a turn."""
    distances: Array = np.linalg.norm(np.cross(points - sweep.pivot, sweep.axis), axis=1)
    return distances


def axis_name(direction: Sequence[float]) -> str | None:
    """Return "-x" for a unit vector (3,) along a world axis; None for any other."""
    for name, value in zip(AXES, direction, strict=True):
        if abs(abs(value) - 1.0) <= ALONG:
            return f"{'-' if value < 0 else '+'}{name}"
    return None
