"""A path: one degree of freedom through slides and tumbles that follow each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, read_only, unit
from gm_ompl.caches import Memo
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.geometry.separation import TOUCHING
from gm_ompl.geometry.solids import Body
from gm_ompl.motion.arc import POSE_BYTES, Motion
from gm_ompl.motion.lattice import Lattice
from gm_ompl.motion.screw import UP, Piece, Screw, Tumble, remembered

SAME_NODE = 1e-9
"""Two values of s closer than this (in pieces) are the same piece boundary."""


@final
class PathMotion(Motion):
    """Pieces one after the other; s runs from 0 at the start to 1 at the goal.

    Piece p of m covers s in [p/m, (p+1)/m], uniform in length or angle.

    Attributes:
        start: the pose at s = 0.
        pieces: the m pieces.
        knots: the m + 1 poses where pieces begin and end.
    """

    def __init__(self, start: Pose, pieces: Sequence[Piece]) -> None:
        if not pieces:
            raise GeometryError("a path needs at least one piece (slide or tumble)")
        self.start, self.pieces = start, tuple(pieces)
        knots = [start]
        for piece in self.pieces:
            knots.append(piece.pose(knots[-1], 1.0))
        self.knots = tuple(knots)
        self._known = [Memo[float, Pose](POSE_BYTES) for _ in self.pieces]
        for known, knot in zip(self._known, knots[1:], strict=True):
            known[1.0] = knot
        self.names = ("s",)
        self.low, self.high = (0.0,), (1.0,)
        self.periods = (None,)
        m = len(self.pieces)
        self.breakpoints = (tuple(p / m for p in range(1, m)),)

    def _piece(self, s: float, ahead: bool) -> tuple[int, float]:
        """Return the piece at ``s`` and the fraction of it; ``ahead`` decides at a boundary."""
        m = len(self.pieces)
        along = s * m
        boundary = round(along)
        if abs(along - boundary) <= SAME_NODE:
            along, p = float(boundary), boundary if ahead else boundary - 1
        else:
            p = int(np.floor(along))
        p = min(max(p, 0), m - 1)
        return p, along - p

    def pose(self, q: Sequence[float] | Array) -> Pose:
        """Return the object's pose at ``q = [s]``."""
        p, fraction = self._piece(float(q[0]), ahead=True)
        return self._at(p, fraction)

    def _at(self, p: int, fraction: float) -> Pose:
        """Return the pose after a fraction of piece p; the latest are remembered."""
        if fraction == 1.0:
            return self.knots[p + 1]
        return remembered(self._known[p], self.knots[p], self.pieces[p], fraction)

    def arc(self, tail: Sequence[float] | Array, head: Sequence[float] | Array) -> Screw:
        """Return the motion from ``tail = [s]`` to ``head = [s]``, within one piece."""
        first, last = float(tail[0]), float(head[0])
        p, _ = self._piece((first + last) / 2.0, ahead=last >= first)
        ends = self._fraction(p, first), self._fraction(p, last)
        return Screw(self.knots[p], self.pieces[p], *ends, self._known[p], ends=self.ends)

    def _fraction(self, p: int, s: float) -> float:
        """Return the fraction of piece p at ``s``; a node at its boundary is on it."""
        along = s * len(self.pieces)
        boundary = round(along)
        return (float(boundary) if abs(along - boundary) <= SAME_NODE else along) - p

    def velocity(self, q: Sequence[float] | Array, dq: Sequence[float] | Array) -> Twist:
        """Return the derivative of the pose at ``q = [s]`` in the direction ``dq = [ds]``.

        Where two pieces meet, it is the derivative on the side that ``dq`` points to.
        """
        ds = float(dq[0])
        p, fraction = self._piece(float(q[0]), ahead=ds >= 0)
        return self.pieces[p].velocity(self._at(p, fraction), ds * len(self.pieces))


def tumble_towards(
    body: Body, pose: Pose, towards: Array, angle: float, touching: float = TOUCHING
) -> Tumble:
    """Return the tumble about the object's bottom edge on the side ``towards``.

    Args:
        body: the object, object frame.
        pose: where the object is when the piece starts.
        towards: (3,), a horizontal direction, world frame.
        angle: rotation [rad]; positive tips the object over that edge.
        touching: corners whose heights differ by at most this, relative to D, lie on one edge.

    Raises:
        GeometryError: no bottom edge is perpendicular to ``towards`` on that side.
    """
    direction = unit(towards)
    axis = np.cross(UP, direction)
    corners = pose.apply(body.vertices)
    tolerance = touching * body.diagonal
    bottom = corners[corners[:, 2] <= corners[:, 2].min() + tolerance]
    reach = bottom @ direction
    edge = bottom[reach >= reach.max() - tolerance]
    along = edge @ axis
    if np.ptp(along) <= 2 * tolerance:
        raise GeometryError(
            "the object's lowest part on that side is a single point, not an edge at right "
            "angles to the direction; turn the object (start yaw) or choose another direction"
        )
    ends = edge[[int(along.argmin()), int(along.argmax())]]
    return Tumble(ends.mean(axis=0), axis, angle)


def path_lattice(segments: Sequence[int]) -> Lattice:
    """Return the lattice with ``segments[p]`` equal arcs in piece p; boundaries are nodes."""
    m, nodes = len(segments), sum(segments) + 1
    limits.claim(32.0 * nodes, f"a lattice of {nodes:,} nodes", "lower lattice.segments")
    pieces = [(p + np.arange(count) / count) / m for p, count in enumerate(segments)]
    return Lattice((read_only(np.concatenate([*pieces, [1.0]]), (None,), "nodes"),), (None,))
