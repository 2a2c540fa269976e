"""Where a screw motion of the object ends: where it would penetrate, or a new contact closes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, final

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.environment import Environment
from gm_ompl.geometry.separation import PlacedPiece, gap, separating_axes
from gm_ompl.geometry.solids import Body, ConvexPiece
from gm_ompl.geometry.sweep import Sweep, heights
from gm_ompl.geometry.swept import MovingPiece

ROUNDING: Final = 1e-10
"""Gaps are known to this, relative to D."""

WHOLE: Final = 1e-9
"""An end within this share of the whole motion is the whole."""

TOUCH: Final = 1e-9
"""Gaps of pieces that were apart count as closed from here on, relative to D: poses that end at a
contact are no more exact after many arcs."""

CLOSED: Final = 4e-15
"""What the sum of a gap leaves of none, relative to D."""

BRACKET: Final = 1e-5
"""Share of the motion down to which a closing contact is bracketed by swept planes."""

WINDOW: Final = 2e-3
"""Share of the motion, past the bracket, in which a gap is followed down."""

GRAZE: Final = 1e-4
"""Pieces that are nearest for no longer than this share only graze each other."""

MOST_STRETCHES: Final = 2000
"""Stretches looked at for one pair; beyond, the motion ends where it was known to be clear."""

DEEP: Final = 1e-8
"""Two depths, this and twice this, relative to D, tell where a kept contact begins to sink."""

UP = np.array([[0.0, 0.0, 1.0]])


@final
class Stops:
    """The object and what it may run into.

    Args:
        body: the object, object frame.
        environment: floor and obstacles.
    """

    def __init__(self, body: Body, environment: Environment) -> None:
        self._body, self._floor = body, environment.floor
        self._D = body.diagonal
        self._touching = environment.contact_tolerance * self._D
        self._least, self._touch = ROUNDING * self._D, TOUCH * self._D
        self._pieces = [p for o in environment.obstacles for p in o.body.pieces]
        self._low = np.array([piece.bounds[0] for piece in self._pieces]).reshape(-1, 3)
        self._high = np.array([piece.bounds[1] for piece in self._pieces]).reshape(-1, 3)

    def near(self, position: Array, reach: float) -> bool:
        """Whether an obstacle may be nearer to a place (3,) than ``reach``."""
        if not self._pieces:
            return False
        way = np.minimum(np.maximum(position, self._low), self._high) - position
        return bool((np.einsum("ij,ij->i", way, way) <= reach * reach).any())

    def beside(self, low: Array, high: Array) -> bool:
        """Whether an obstacle's bounding box meets that of two corners (3,)."""
        margin = self._touching
        meets = (self._low <= high + margin) & (low - margin <= self._high)
        return bool(meets.all(axis=1).any())

    def free_share(self, sweep: Sweep) -> float:
        """Return the share of a translation or a turn that the object can go, 0 to 1."""
        share = min((self._over_floor(sweep, p) for p in self._body.pieces), default=1.0)
        if not self._pieces:
            return _whole(share)
        for piece in self._body.pieces:
            for j in self._near(sweep, piece, share).tolist():
                share = min(share, self._beside(sweep, piece, self._pieces[j]))
        return _whole(share)

    def _near(self, sweep: Sweep, piece: ConvexPiece, share: float) -> IntArray:
        """Return the obstacle pieces in whose bounding box the object's piece may come."""
        arms = sweep.arms(piece.vertices)
        ends = np.concatenate([sweep.moved(arms, 0.0), sweep.moved(arms, share)])
        margin = sweep.sagitta(arms) + self._touching
        low, high = ends.min(axis=0) - margin, ends.max(axis=0) + margin
        return np.flatnonzero(((self._low <= high) & (low <= self._high)).all(axis=1))

    def _over_floor(self, sweep: Sweep, piece: ConvexPiece) -> float:
        """Return the share that a piece can go over the floor."""
        if not self._floor:
            return 1.0
        still = heights(sweep, sweep.arms(piece.vertices), UP, np.zeros(1))
        first, lowest = still.at(0.0)[0], still.least(0.0, 1.0)[0]
        touches = first.min() <= self._touching
        # What touches may go no deeper than a contact is; what is apart ends where it touches.
        ends = lowest < -self._touching if touches else lowest <= self._touch
        if not ends.any():
            return 1.0
        # A corner on the floor sinks from where it is; others come down to it.
        level = np.where(first <= self._touching, np.minimum(first, 0.0) - self._least, 0.0)[ends]
        if sweep.angle == 0.0:
            share = (level - first[ends]) / (still.at(1.0)[0] - first)[ends]
            return min(1.0, max(0.0, float(share.min())))
        a, b, c = (part[0][ends] for part in still.still)
        c = c * np.sign(sweep.angle)
        cosine = np.clip((level - a) / np.hypot(b, c), -1.0, 1.0)
        angle = float(np.mod(np.arctan2(c, b) + np.arccos(cosine), 2.0 * np.pi).min())
        return min(1.0, angle / abs(sweep.angle))

    def _beside(self, sweep: Sweep, piece: ConvexPiece, other: ConvexPiece) -> float:
        """Return the share that a piece can go beside one of the environment."""
        here, there = PlacedPiece(piece, sweep.start), PlacedPiece(other)
        if sweep.angle == 0.0:
            return self._sliding(here, there, sweep.drift)
        width = gap(here, there).width
        apart = width > self._touching
        level = 0.0 if apart else min(width, 0.0)
        depth = -self._touch if apart else self._touching
        bracket = _bracket(MovingPiece(piece, sweep), other, depth)
        if bracket is None:
            return 1.0

        def width_at(t: float) -> float:
            return gap(PlacedPiece(piece, sweep.pose(t)), there).width - level

        if apart:
            return _closing(width_at, *bracket, self._least, CLOSED * self._D)
        return _leaving(width_at, bracket[1], DEEP * self._D)

    def _sliding(self, here: PlacedPiece, there: PlacedPiece, drift: Array) -> float:
        """Return the share of a translation until two pieces touch, or penetrate."""
        axes = np.concatenate(list(separating_axes(here, there)))
        gaps = (here.vertices @ axes.T).min(axis=0) - (there.vertices @ axes.T).max(axis=0)
        rates, width = axes @ drift, float(gaps.max())
        apart = width > self._touching
        level = self._touch if apart else -self._touching
        closing, opening = rates < -self._least, rates > self._least
        if (gaps[~closing & ~opening] > level).any() or not closing.any():
            return 1.0
        first = float(((level - gaps[closing]) / rates[closing]).max())
        last = float(((level - gaps[opening]) / rates[opening]).min(initial=np.inf))
        if last < 0.0 or first > min(last, 1.0):
            return 1.0
        level = 0.0 if apart else min(width, 0.0) - self._least
        first = float(((level - gaps[closing]) / rates[closing]).max())
        return min(1.0, max(0.0, first))


def _whole(share: float) -> float:
    return 1.0 if share >= 1.0 - WHOLE else share


def _bracket(mover: MovingPiece, other: ConvexPiece, depth: float) -> tuple[float, float] | None:
    """Return (t, t'), clear up to t and blocked somewhere up to t'; None: clear throughout."""
    planes = mover.planes(other)
    left = [(0.0, 1.0)]
    for _ in range(MOST_STRETCHES):
        if not left:
            return None
        first, last = left.pop()
        clear = planes.clear((first, last), depth)
        if clear:
            continue
        middle = (first + last) / 2.0
        if last - first <= BRACKET:
            return first, last
        left = [(first, middle)] if clear is False else [*left, (middle, last), (first, middle)]
    return left[-1][0], left[-1][1]


def _closing(
    width_at: Callable[[float], float],
    first: float,
    last: float,
    rounding: float,
    closed: float,
) -> float:
    """Return where the gap of two pieces that were apart comes to 0, or nearest, past a bracket."""
    while width_at(last) > 0.0 and last < first + WINDOW:
        last += last - first
    if width_at(last) <= 0.0:  # and perhaps 0 in every bit from where it closed
        return float(brentq(lambda t: width_at(t) - closed, first, last, xtol=1e-15))
    least = minimize_scalar(
        width_at, bounds=(first, last), method="bounded", options={"xatol": 1e-12}
    )
    # Two pieces that graze each other part again; others stay as near as they came.
    lowest = float(least.fun) + rounding
    came = float(brentq(lambda t: width_at(t) - lowest, first, float(least.x), xtol=1e-15))
    return min(1.0, came if least.x - came > GRAZE else float(least.x))


def _leaving(width_at: Callable[[float], float], last: float, deep: float) -> float:
    """Return where a contact that was kept begins to sink: followed back from behind."""
    while width_at(last) > -2.0 * deep:
        last += BRACKET
    first, step = last, BRACKET
    while width_at(first) < -deep:
        if first == 0.0:
            return 0.0
        first, step = max(0.0, last - step), 2.0 * step
    one, two = (
        float(brentq(lambda t, d=depth: width_at(t) + d, first, last, xtol=1e-15))
        for depth in (deep, 2.0 * deep)
    )
    return min(1.0, max(0.0, 2.0 * one - two))
