"""The hands that ship: which file, and what the file does not say."""

from __future__ import annotations

import importlib.metadata
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from gm_ompl.errors import HandError, MissingExtraError, did_you_mean

LINKS = ("finger_tip_link_0", "finger_tip_link_120", "finger_tip_link_240")


class ShippedHand(NamedTuple):
    """What a shipped hand adds to its file; the numbers are ours, no manufacturer's.

    Attributes:
        file: its file inside ``distribution``, or beside this module where that is None.
        distribution: the Python distribution that brings the file, by the extra ``hand``.
        tips: the fingertips' links; the spheres' centres are their origins.
        home: (k,), where it waits [rad].
        torque: the most that a motor gives [N m]; one number, or one per joint.
        speed: how fast a joint may turn [rad/s]; likewise.
    """

    file: str
    distribution: str | None
    tips: tuple[str, ...]
    home: tuple[float, ...]
    torque: float | tuple[float, ...]
    speed: float | tuple[float, ...]

    def path(self) -> Path:
        """Return where its file is.

        Raises:
            MissingExtraError: its distribution is not installed.
        """
        if self.distribution is None:
            return Path(str(files("gm_ompl.hand") / self.file))
        try:
            found = importlib.metadata.distribution(self.distribution)
        except importlib.metadata.PackageNotFoundError:
            raise MissingExtraError(self.distribution, "hand") from None
        return Path(str(found.locate_file(self.file)))


HANDS = {
    # The URDF's effort and velocity limits of 1000 are placeholders.
    "trifinger": ShippedHand(
        "robot_properties_fingers/urdf/pro/trifingerpro.urdf", "robot-properties-fingers",
        LINKS, (0.0, 0.9, -2.0) * 3, 0.36, 2.0,
    ),
    "arm-hand": ShippedHand(
        "arm-hand.xml", None, ("tip_left", "tip_right"),
        (0.0, -0.8, 0.9, 0.8, 0.0, 0.0, -0.3, 0.6, 0.0, -0.3, 0.6),
        (40.0, 40.0, 20.0, 10.0, 5.0, *(1.0,) * 6), 1.5,
    ),
}  # fmt: skip
"""By name."""


def shipped_hand(name: str) -> ShippedHand:
    """Return the shipped hand of a name.

    Raises:
        HandError: there is none of that name.
    """
    if name not in HANDS:
        known = f"shipped are {', '.join(HANDS)}; another hand needs file:"
        raise HandError(("model",), f"{name!r}: no such hand{did_you_mean(name, HANDS)}; {known}")
    return HANDS[name]
