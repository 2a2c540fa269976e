"""Judges a stated arc: is it the scenario's motion between the stated coordinates?"""

from __future__ import annotations

import numpy as np

from gm_ompl.check.findings import Findings, listed
from gm_ompl.check.recheck import Recheck
from gm_ompl.motion.arc import Arc
from gm_ompl.plan.arcs import arc_record
from gm_ompl.plan.record import ArcRecord, RotationArc, StraightArc, TranslationArc, Turn


def check_arc(recheck: Recheck, claimed: ArcRecord, arc: Arc, found: Findings) -> None:
    """Judge whether ``claimed`` is ``arc``, the motion between the step's coordinates."""
    wanted = arc_record(arc)
    kinds = [type(record).__name__.removesuffix("Arc").lower() for record in (claimed, wanted)]
    if not found.check(
        "arc",
        kinds[0] == kinds[1],
        f"a {kinds[0]} is claimed; between these coordinates the scenario has a {kinds[1]}",
    ):
        return
    length = recheck.tolerances.length * max(
        recheck.diagonal, *np.abs([arc.start.position, arc.end.position]).ravel().tolist()
    )
    for what, have, want, allowed in _parts(claimed, wanted, length, recheck.tolerances.direction):
        off = float(np.abs(np.subtract(have, want)).max())
        found.check(
            "arc",
            off <= allowed,
            f"{what} {listed(have)} is claimed; between these coordinates it is {listed(want)} "
            f"(off by {off:.3g}, allowed {allowed:.3g})",
        )


Part = tuple[str, tuple[float, ...], tuple[float, ...], float]
"""What is compared, what is claimed, what it is, and by how much they may differ."""


def _parts(claimed: ArcRecord, wanted: ArcRecord, length: float, angle: float) -> list[Part]:
    if isinstance(claimed, TranslationArc) and isinstance(wanted, TranslationArc):
        return [("translation", claimed.translation, wanted.translation, length)]
    if isinstance(claimed, RotationArc) and isinstance(wanted, RotationArc):
        return _turns(claimed.rotation, wanted.rotation, length, angle)
    assert isinstance(claimed, StraightArc) and isinstance(wanted, StraightArc)
    parts: list[Part] = []
    for name, have, want in (
        ("straight.from", claimed.straight.from_, wanted.straight.from_),
        ("straight.to", claimed.straight.to, wanted.straight.to),
    ):
        parts += [(name, have[:2], want[:2], length), (f"{name} (yaw)", have[2:], want[2:], angle)]
    return parts


def _turns(claimed: Turn, wanted: Turn, length: float, angle: float) -> list[Part]:
    """Compare two turns: any point of the line will do, and the axis may point either way."""
    sign = 1.0 if np.dot(claimed.axis, wanted.axis) >= 0.0 else -1.0
    axis = np.array(wanted.axis)
    arm = np.subtract(claimed.point, wanted.point)
    beside = arm - (arm @ axis) * axis
    point = tuple(np.subtract(claimed.point, beside).tolist())
    return [
        ("rotation.point", claimed.point, point, length),
        ("rotation.axis", claimed.axis, tuple((sign * axis).tolist()), angle),
        ("rotation.angle", (claimed.angle,), (sign * wanted.angle,), angle),
    ]
