"""How far convex pieces are apart, exactly and vectorised, and where a lowered body stands.

A piece A and a fixed piece B overlap where the origin lies in B - A. That polytope is cut out by
the planes of B's faces, of A's and of pairs of edges; along the vertical it is one interval, whose
ends are quotients of support values: nothing is searched for.
"""

from __future__ import annotations

import enum
import functools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray, cross
from gm_ompl.geometry.facets import PARALLEL
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, ConvexPiece

TOUCHING = 1e-5
"""A gap or overlap of object and environment of at most this, relative to D, is a contact: parts
measured or stored in single precision are no more exact (``mechanics.contact_tolerance``)."""

BATCH = 4096
"""Pairs of edges looked at together: bounds the memory that two detailed hulls take."""


class PlacedPiece:
    """A convex piece at a pose, world frame; without a pose, where it is.

    What a question does not ask for is not computed.

    Attributes:
        piece: the piece itself.
        vertices: (v, 3).
    """

    def __init__(self, piece: ConvexPiece, pose: Pose | None = None) -> None:
        self.piece, self._pose = piece, pose
        self.vertices = piece.vertices if pose is None else pose.apply(piece.vertices)

    @functools.cached_property
    def normals(self) -> Array:
        """Outward unit normals (f, 3) of its faces."""
        normals, pose = self.piece.face_normals, self._pose
        return normals if pose is None else normals @ pose.rotation.T

    @functools.cached_property
    def offsets(self) -> Array:
        """Distances (f,) of its faces' planes from the origin, along their normals."""
        offsets, pose = self.piece.face_offsets, self._pose
        return offsets if pose is None else offsets + self.normals @ pose.position

    @functools.cached_property
    def edges(self) -> Array:
        """Unit directions (e, 3) of its edges."""
        edges, pose = self.piece.edge_directions, self._pose
        return edges if pose is None else edges @ pose.rotation.T

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest coordinates, (3,) each."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)


class Axis(enum.Enum):
    """Where a separating axis comes from."""

    FIRST = "a face of the first piece"
    SECOND = "a face of the second piece"
    EDGES = "an edge of each"


class Gap(NamedTuple):
    """The outcome of ``gap``: width, unit normal from the second to the first piece, its kind."""

    width: float
    normal: Array
    axis: Axis


def face_gaps(owner: PlacedPiece, other: PlacedPiece) -> Array:
    """Return (f,), how far ``other`` is beyond each face of ``owner``; negative: it reaches in."""
    gaps: Array = (other.vertices @ owner.normals.T).min(axis=0) - owner.offsets
    return gaps


def crossed_edges(edges: Array, others: Array) -> Iterator[tuple[IntArray, Array]]:
    """Yield, in batches, which pairs of directions (e, 3), (o, 3) cross and the unit normals there.

    Pair i * o + j is that of edge i and other j; the normals are (k, 3), e x o scaled to 1.
    """
    rows = max(1, BATCH // max(len(others), 1))
    for start in range(0, len(edges), rows):
        axes = cross(edges[start : start + rows, None], others[None]).reshape(-1, 3)
        sines = np.sqrt(np.einsum("ij,ij->i", axes, axes))
        crossed = np.flatnonzero(sines > PARALLEL)
        yield start * len(others) + crossed, axes[crossed] / sines[crossed, None]


def edge_gaps(a: PlacedPiece, b: PlacedPiece) -> tuple[Array, Array]:
    """Return the gaps (k,) along all crossed pairs of edges and the normals (k, 3) from b to a."""
    widths, normals = [], []
    for _, axes in crossed_edges(a.edges, b.edges):
        of_a, of_b = axes @ a.vertices.T, axes @ b.vertices.T
        ahead = of_a.min(axis=1) - of_b.max(axis=1)
        behind = of_b.min(axis=1) - of_a.max(axis=1)
        widths.append(np.maximum(ahead, behind))
        normals.append(np.where(ahead >= behind, 1.0, -1.0)[:, None] * axes)
    return np.concatenate(widths), np.concatenate(normals)


def gap(a: PlacedPiece, b: PlacedPiece, tie: float = 0.0) -> Gap:
    """Return the gap between two convex pieces along the best separating axis.

    Positive: a lower bound on their distance, exact unless a vertex is nearest. Negative: minus
    the depth of penetration, exact. Faces win over edges, and the second piece's over the first's,
    where their gaps differ by at most ``tie``; the width is the greatest of all gaps even so.
    """
    of_a, of_b = face_gaps(a, b), face_gaps(b, a)
    widths, normals = edge_gaps(a, b)
    edges = float(widths.max(initial=-np.inf))
    best = max(float(of_a.max()), float(of_b.max()), edges)
    if of_b.max() >= best - tie:
        return Gap(best, b.normals[of_b.argmax()], Axis.SECOND)
    if of_a.max() >= best - tie:
        return Gap(best, -a.normals[of_a.argmax()], Axis.FIRST)
    return Gap(best, normals[widths.argmax()], Axis.EDGES)


def penetrates(a: PlacedPiece, b: PlacedPiece, tolerance: float) -> bool:
    """Whether two convex pieces overlap by more than ``tolerance`` (length)."""
    if face_gaps(b, a).max() >= -tolerance or face_gaps(a, b).max() >= -tolerance:
        return False
    return bool(edge_gaps(a, b)[0].max(initial=-np.inf) < -tolerance)


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
    for axes in separating_axes(a, b):
        width = (axes @ b.vertices.T).max(axis=1) - (axes @ a.vertices.T).min(axis=1)
        rise = axes[:, 2]
        up, down = rise > 0.0, rise < 0.0
        if (width[rise == 0.0] <= slack).any():
            return np.inf, -np.inf, -np.inf
        stands = min(stands, float((width[up] / rise[up]).min(initial=np.inf)))
        high = min(high, float(((width[up] - slack) / rise[up]).min(initial=np.inf)))
        low = max(low, float(((width[down] - slack) / rise[down]).max(initial=-np.inf)))
    return low, high, stands


def separating_axes(a: PlacedPiece, b: PlacedPiece) -> Iterator[Array]:
    """Yield the outward normals (k, 3) of b - a, and others: each bounds it."""
    yield b.normals
    yield -a.normals
    for _, axes in crossed_edges(a.edges, b.edges):
        yield axes
        yield -axes
