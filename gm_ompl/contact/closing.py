"""Where a gap closes, or a kept contact begins to sink, once it is bracketed. Compiled."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.compilation import inlined, lean
from gm_ompl.geometry.packed import Drive, Hull, HullRoom, moved_hull
from gm_ompl.geometry.stretches import width

BRACKET: Final = 1e-5
"""Share of the motion down to which a closing contact is bracketed by swept planes."""

WINDOW: Final = 2e-3
"""Share of the motion, past the bracket, in which a gap is followed down."""

GRAZE: Final = 1e-4
"""Pieces that are nearest for no longer than this share only graze each other."""

HALVINGS: Final = 60
"""After so many halvings nothing is left of a share of the motion."""

GOLDEN: Final = (np.sqrt(5.0) - 1.0) / 2.0


class Pair(NamedTuple):
    """A moving piece and a fixed one; whence their gap is counted; room for the first."""

    mover: Hull
    motion: Drive
    other: Hull
    level: float
    room: HullRoom


@lean
def _gap(pair: Pair, t: float) -> float:
    here = moved_hull(pair.mover, pair.motion, t, pair.room)
    wide: float = width(here, pair.other) - pair.level
    return wide


@lean
def _crossing(pair: Pair, level: float, first: float, last: float) -> float:
    """Return where a gap that is wider than ``level`` first comes down to it, by halving."""
    for _ in range(HALVINGS):
        middle = (first + last) / 2.0
        if not first < middle < last:
            break
        if _gap(pair, middle) > level:
            first = middle
        else:
            last = middle
    return last


@inlined
def closing(pair: Pair, first: float, last: float, closed: float, rounding: float) -> float:
    """Return where the gap of two pieces that were apart comes to 0, or nearest, past a bracket."""
    start = first
    while _gap(pair, last) > 0.0 and last < start + WINDOW:
        last += last - first
    if _gap(pair, last) <= 0.0:  # and perhaps 0 in every bit from where it closed
        return _crossing(pair, closed, first, last)
    nearest, lowest = _nearest(pair, first, last)
    # Two pieces that graze each other part again; others stay as near as they came.
    came = _crossing(pair, lowest + rounding, first, nearest)
    return min(1.0, came if nearest - came > GRAZE else nearest)


@inlined
def _nearest(pair: Pair, first: float, last: float) -> tuple[float, float]:
    """Return where a gap is least, and how wide it is there, by golden sections."""
    low, high = last - GOLDEN * (last - first), first + GOLDEN * (last - first)
    at_low, at_high = _gap(pair, low), _gap(pair, high)
    for _ in range(HALVINGS):
        if last - first <= 1e-12:
            break
        if at_low <= at_high:
            last, high, at_high = high, low, at_low
            low = last - GOLDEN * (last - first)
            at_low = _gap(pair, low)
        else:
            first, low, at_low = low, high, at_high
            high = first + GOLDEN * (last - first)
            at_high = _gap(pair, high)
    return (low, at_low) if at_low <= at_high else (high, at_high)


@inlined
def leaving(pair: Pair, last: float, deep: float) -> float:
    """Return where a contact that was kept begins to sink: followed back from behind."""
    while _gap(pair, last) > -2.0 * deep:
        last += BRACKET
    first, step = last, BRACKET
    while _gap(pair, first) < -deep:
        if first == 0.0:
            return 0.0
        first, step = max(0.0, last - step), 2.0 * step
    one_deep = _crossing(pair, -deep, first, last)
    two_deep = _crossing(pair, -2.0 * deep, first, last)
    return min(1.0, max(0.0, 2.0 * one_deep - two_deep))
