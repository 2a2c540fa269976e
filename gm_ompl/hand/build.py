"""From what a scenario says of a hand to a ``HandSpec``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import HandError, did_you_mean
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.files import read_hand
from gm_ompl.hand.parsing import Hinges, hinges, known_link, parsed
from gm_ompl.hand.shipped import shipped_hand
from gm_ompl.hand.spec import HandSpec, Tip


@dataclass(frozen=True)
class Wanted:
    """What a scenario says of its hand; None where it leaves that to a shipped hand.

    Attributes:
        model: a shipped hand's name.
        file: a URDF or MJCF.
        packages: folders by the names in ``package://``.
        tips: the fingertips.
        base: where the hand's base is.
        home: angles by joint [rad].
        limits: least and greatest angle by joint [rad].
        torque: one for all joints, or one each [N m].
        speed: likewise [rad/s].
    """

    model: str | None
    file: Path | None
    packages: Mapping[str, Path]
    tips: tuple[Tip, ...] | None
    base: Pose
    home: Mapping[str, float] | None
    limits: Mapping[str, tuple[float, float]]
    torque: float | Sequence[float] | None
    speed: float | Sequence[float] | None


def hand_spec(wanted: Wanted, fingers: int) -> HandSpec:
    """Return the hand, everything checked that its file alone can tell.

    Raises:
        HandError: something in it cannot be used.
        MissingExtraError: a library for hands is not installed.
    """
    own = None if wanted.model is None else shipped_hand(wanted.model)
    path = own.path() if own is not None else wanted.file
    assert path is not None
    file = read_hand(path, wanted.packages)
    found = hinges(parsed(file.path, file.text))
    tips = wanted.tips
    if tips is None:
        if own is None:
            raise HandError(("tips",), "missing; add it: [{link: NAME, offset: [0, 0, 0]}, ...]")
        tips = tuple(Tip(link, np.zeros(3)) for link in own.tips)
    for i, tip in enumerate(tips):
        known_link(tip.link, found.links, ("tips", i, "link"))
        if tip.link in [other.link for other in tips[:i]]:
            raise HandError(("tips", i, "link"), f"{tip.link!r}: given twice; one finger per link")
    if len(tips) != fingers:
        text = f"{len(tips)} fingertips; fingers.count is {fingers}, and they must be the same"
        raise HandError(("tips",) if wanted.tips else ("model",), text)
    low, high = _limits(found, wanted.limits)
    return HandSpec(
        name=wanted.model or path.name,
        path=file.path,
        text=file.text,
        tips=tips,
        base=wanted.base,
        joints=found.names,
        low=low,
        high=high,
        home=_home(found, low, high, wanted.home, None if own is None else own.home),
        torque=_each("torque", found, wanted.torque, None if own is None else own.torque, "N m"),
        speed=_each("speed", found, wanted.speed, None if own is None else own.speed, "rad/s"),
    )


def _limits(found: Hinges, given: Mapping[str, tuple[float, float]]) -> tuple[Array, Array]:
    low, high = found.low.copy(), found.high.copy()
    for name, (least, most) in given.items():
        _known_joint(name, found, ("limits", name))
        if not least < most:
            raise HandError(("limits", name), f"[{least:g}, {most:g}] rad: must be increasing")
        k = found.names.index(name)
        if least < low[k] or most > high[k]:
            text = f"wider than the file's {low[k]:g} to {high[k]:g} rad; may only be narrower"
            raise HandError(("limits", name), text)
        low[k], high[k] = least, most
    for k in np.flatnonzero(~np.isfinite(low)).tolist():
        name = found.names[k]
        text = f"the file limits joint {name!r} nowhere; add {name}: [-90 deg, 90 deg], or so"
        raise HandError(("limits",), text)
    return low, high


def _known_joint(name: str, found: Hinges, key: tuple[str | int, ...]) -> None:
    if name not in found.names:
        known = f"joints: {', '.join(found.names)}"
        raise HandError(key, f"no such joint{did_you_mean(name, found.names)}; {known}")


def _home(
    found: Hinges,
    low: Array,
    high: Array,
    given: Mapping[str, float] | None,
    shipped: Sequence[float] | None,
) -> Array:
    home = np.full(len(found.names), np.nan) if shipped is None else np.array(shipped)
    for name, angle in (given or {}).items():
        _known_joint(name, found, ("home", name))
        home[found.names.index(name)] = angle
    for name, angle, least, most in zip(found.names, home, low, high, strict=True):
        if np.isnan(angle):
            raise HandError(("home",), f"joint {name!r} is missing; add {name}: 0 deg, or so")
        if not least <= angle <= most:
            text = f"{name} at {angle:g} rad is outside its limits, {least:g} to {most:g}"
            raise HandError(("home",), text)
    return home


def _each(
    key: str,
    found: Hinges,
    given: float | Sequence[float] | None,
    shipped: float | Sequence[float] | None,
    unit: str,
) -> Array:
    """Return one number per joint."""
    value = shipped if given is None else given
    count = len(found.names)
    if value is None:
        text = f"missing; add it, one number for all {count} joints or a list [{unit}]"
        raise HandError((key,), text)
    if not isinstance(value, int | float) and len(value) != count:
        raise HandError((key,), f"{len(value)} given; the hand has {count} joints")
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (count,)).copy()
