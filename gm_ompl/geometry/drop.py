"""Where a body comes to stand that is lowered until it touches: exact, for convex pieces.

A piece A and a fixed piece B overlap where the origin lies in B - A. That polytope is cut out by
the planes of B's faces, of A's and of pairs of edges; along the vertical it is one interval, whose
ends are quotients of support values: nothing is searched for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import PlacedPiece, crossed_edges
from gm_ompl.geometry.solids import Body

TIED = 1e-9
"""Supports whose heights differ by at most this, relative to D, carry together."""


class Support(NamedTuple):
    """Rises of the body, from where it is, at which it would overlap one thing.

    Attributes:
        name: of the thing.
        low: the least rise at which it overlaps by more than the tolerance.
        high: the greatest such rise.
        stands: the rise at which it just stands on the thing.
    """

    name: str
    low: float
    high: float
    stands: float


def supports(
    body: Body, obstacles: Sequence[tuple[str, Body]], floor: bool, pose: Pose, touching: float
) -> tuple[Support, ...]:
    """Return what lies above or below the body, somewhere along the vertical.

    Args:
        body: the object, object frame.
        obstacles: name and fixed body, world frame.
        floor: whether the half space z < 0 is solid.
        pose: where the object is; its height does not matter.
        touching: overlap that counts as touching, relative to D: what is beside the object within
            it holds nothing.
    """
    slack = touching * body.diagonal
    pieces = [PlacedPiece(piece, pose) for piece in body.pieces]
    found = []
    if floor:
        lowest = min(float(piece.vertices[:, 2].min()) for piece in pieces)
        found.append(Support("the floor", -np.inf, -lowest - slack, -lowest))
    for name, other in obstacles:
        for fixed in map(PlacedPiece, other.pieces):
            for piece in pieces:
                low, high, stands = _overlapping(piece, fixed, slack)
                if low < high:
                    found.append(Support(f"obstacle {name!r}", low, high, stands))
    return tuple(found)


def lowered(found: Sequence[Support], diagonal: float) -> float | None:
    """Return the rise at which a body stands that comes down from far above; None: on nothing."""
    if not found:
        return None
    stop = max(support.high for support in found)
    return max(s.stands for s in found if s.high >= stop - TIED * diagonal)


def below(found: Sequence[Support]) -> Support | None:
    """Return what the body would come to stand on first from where it is; None: on nothing."""
    under = [support for support in found if support.high <= 0.0]
    return max(under, key=lambda support: support.stands, default=None)


def _overlapping(a: PlacedPiece, b: PlacedPiece, slack: float) -> tuple[float, float, float]:
    """Return the interval of rises of ``a`` that overlap ``b`` by more than ``slack``.

    And the greatest rise that overlaps it at all.
    """
    (low_a, high_a), (low_b, high_b) = a.bounds, b.bounds
    if (low_a >= high_b)[:2].any() or (low_b >= high_a)[:2].any():
        return np.inf, -np.inf, -np.inf
    low, high, stands = -np.inf, np.inf, np.inf
    for axes in _axes(a, b):
        width = (axes @ b.vertices.T).max(axis=1) - (axes @ a.vertices.T).min(axis=1)
        rise = axes[:, 2]
        up, down = rise > 0.0, rise < 0.0
        if (width[rise == 0.0] <= slack).any():
            return np.inf, -np.inf, -np.inf
        stands = min(stands, float((width[up] / rise[up]).min(initial=np.inf)))
        high = min(high, float(((width[up] - slack) / rise[up]).min(initial=np.inf)))
        low = max(low, float(((width[down] - slack) / rise[down]).max(initial=-np.inf)))
    return low, high, stands


def _axes(a: PlacedPiece, b: PlacedPiece) -> Iterator[Array]:
    """Yield the outward normals (k, 3) of b - a, and others: each bounds it."""
    yield b.normals
    yield -a.normals
    for _, axes in crossed_edges(a.edges, b.edges):
        yield axes
        yield -axes
