"""Steps in words: what the object does, and where."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gm_ompl.planfile.record import ArcRecord, RotationArc, TranslationArc

ALONG = 1e-6
"""How far a direction may be off an axis that names it."""


def arc_in_words(arc: ArcRecord) -> str:
    """Return "slides 1.8 along -x", or "turns 15 deg about +y through [0.5, 0, 0]"."""
    if isinstance(arc, TranslationArc):
        length = math.hypot(*arc.translation)
        return f"slides {length:.6g} along {_direction(arc.translation, length)}"
    if isinstance(arc, RotationArc):
        turn = arc.rotation
        axis = [math.copysign(1.0, turn.angle) * value for value in turn.axis]
        angle, about = math.degrees(abs(turn.angle)), _direction(axis, math.hypot(*axis))
        return f"turns {angle:.6g} deg about {about} through {_listed(turn.point)}"
    line = arc.straight
    return f"moves from {_listed(line.from_)} to {_listed(line.to)}"


def _direction(vector: Sequence[float], length: float) -> str:
    """Return "-x", or the unit vector where it is no axis."""
    unit = [value / (length or 1.0) for value in vector]
    for name, value in zip("xyz", unit, strict=True):
        if abs(abs(value) - 1.0) <= ALONG:
            return f"{'-' if value < 0 else '+'}{name}"
    return _listed(unit)


def _listed(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{round(value, 9) + 0.0:.4g}" for value in values) + "]"
