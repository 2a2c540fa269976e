"""``HandSpec``: a robot hand as a scenario declares it, everything checked and filled in."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gm_ompl.arrays import Array, fix
from gm_ompl.geometry.pose import Pose


@dataclass(frozen=True, eq=False)
class Tip:
    """Where a fingertip's sphere sits on its link.

    Attributes:
        link: the link's name.
        offset: (3,), the sphere's centre in the link's frame [m].
    """

    link: str
    offset: Array

    def __post_init__(self) -> None:
        fix(self, offset=(3,))


@dataclass(frozen=True, eq=False)
class HandSpec:
    """A hand of k hinges and n fingertips; SI units, angles in rad.

    Attributes:
        name: "trifinger", or the file's name.
        path: the file.
        text: a URDF's text, mesh files by absolute paths; None of an MJCF, which is read itself.
        tips: the fingertips, in finger order.
        base: the hand's base in the world.
        joints: the hinges' names, in the order of all arrays of joints.
        low: (k,), least angles.
        high: (k,), greatest.
        home: (k,), where the hand waits.
        torque: (k,), the most that each motor gives [N m].
        speed: (k,), how fast each may turn [rad/s].
    """

    name: str
    path: Path
    text: str | None
    tips: tuple[Tip, ...]
    base: Pose
    joints: tuple[str, ...]
    low: Array
    high: Array
    home: Array
    torque: Array
    speed: Array

    def __post_init__(self) -> None:
        k = (len(self.joints),)
        fix(self, low=k, high=k, home=k, torque=k, speed=k)
