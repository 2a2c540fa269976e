"""The door to MuJoCo for hands: their files read, and what these say of joints and links."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import HandError, MissingExtraError, did_you_mean


class Hinges(NamedTuple):
    """What a file says of its joints.

    Attributes:
        names: (k,).
        low: (k,), least angles [rad]; -inf where the file limits none.
        high: (k,), greatest; likewise inf.
        links: names of all links.
    """

    names: tuple[str, ...]
    low: Array
    high: Array
    links: tuple[str, ...]


def mujoco() -> Any:
    """Import MuJoCo.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import mujoco
    except ModuleNotFoundError as error:
        raise MissingExtraError("MuJoCo", "hand") from error
    mujoco.set_mju_user_warning(_unheard)  # its own way is a file in the user's folder
    return mujoco


def _unheard(_: str) -> None:
    """Take a warning of MuJoCo's."""


def parsed(path: Path, text: str | None) -> Any:
    """Return MuJoCo's specification of a hand's file.

    Raises:
        HandError: MuJoCo cannot read it.
    """
    library = mujoco()
    try:
        spec = library.MjSpec.from_string(text) if text else library.MjSpec.from_file(str(path))
        spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise HandError(("file",), f"{path}: MuJoCo cannot use it: {reason}") from None
    return spec


def hinges(spec: Any) -> Hinges:
    """Return the joints of a parsed file.

    Raises:
        HandError: one of them is no hinge, or there is none.
    """
    library = mujoco()
    model = spec.compile()
    names = tuple(model.joint(i).name for i in range(model.njnt))
    for name, kind in zip(names, model.jnt_type, strict=True):
        if kind != library.mjtJoint.mjJNT_HINGE:
            text = f"joint {name!r} is no hinge; only hinges (revolute) can be planned"
            raise HandError(("file",), text)
    if not names:
        raise HandError(("file",), "it has no joint that moves; a hand needs hinges")
    limited = model.jnt_limited.astype(bool)
    low = np.where(limited, model.jnt_range[:, 0], -np.inf)
    high = np.where(limited, model.jnt_range[:, 1], np.inf)
    links = tuple(model.body(i).name for i in range(1, model.nbody))
    return Hinges(names, low, high, links)


def known_link(tip: str, links: Iterable[str], key: tuple[str | int, ...]) -> None:
    """Refuse a fingertip's link that the file does not have."""
    links = list(links)
    if tip not in links:
        raise HandError(key, f"{tip!r}: no such link{did_you_mean(tip, links)}; links: {links}")
