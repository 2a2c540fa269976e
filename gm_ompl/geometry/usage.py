"""From a file's triangles to the shape that is used: welded, chosen, simplified, made convex."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.collision import surface_distances
from gm_ompl.geometry.decomposition import MAX_PIECES, solid
from gm_ompl.geometry.hulls import clean_hull, flattened, hull_mesh, triangulated
from gm_ompl.geometry.mesh import BEFORE_CUTTING, convex_parts, simplified, turned_outward
from gm_ompl.geometry.separation import PlacedPiece, penetrates
from gm_ompl.geometry.solids import Body, ConvexPiece, hull, volume
from gm_ompl.geometry.triangles import TriangleMesh, checked
from gm_ompl.geometry.welding import bodies_of, used, welded

Convex: TypeAlias = Literal["exact", "hull", "decompose"]

MAX_FACES = 20_000
"""A mesh with more triangles is refused: plan files carry every one of them."""

NOTHING = 1e-9
"""A deviation below this part of the extent is none."""

OVERLAP = 1e-6
"""Pieces that overlap by more than this, relative to D, are refused: mass would count twice."""

FULL = 1e-3
"""A body whose hull has no more than this part of volume more is convex enough."""

SHOWN = 6
"""Bodies of a file that a message lists."""


@dataclass(frozen=True)
class Usage:
    """How triangles are to be used; lengths in the scenario's units.

    Attributes:
        weld: vertices so close are one; None: as the numbers' own rounding asks.
        flat: triangles within it of a plane are one face; None: likewise.
        bodies: the numbers of the bodies to take, or "all"; None: all of them for a hull or
            pieces, else there must be one.
        convex: as it is, its hull, or pieces that fill it about.
        simplify: at most so many triangles, or None.
        turn: whether triangles that face inward are turned around.
    """

    weld: float | None = None
    flat: float | None = None
    bodies: tuple[int, ...] | Literal["all"] | None = None
    convex: Convex = "exact"
    simplify: int | None = None
    turn: bool = True


@dataclass(frozen=True, eq=False)
class Used:
    """The shape that is used.

    Attributes:
        meshes: one closed surface, convex or to be cut exactly; or the surfaces of convex pieces.
        deviation: the largest distance found between its surface and that of the triangles.
    """

    meshes: tuple[TriangleMesh, ...]
    deviation: float


class SeveralBodiesError(GeometryError):
    """There are several bodies, and nothing says which of them to take."""


class TooManyTrianglesError(GeometryError):
    """More triangles than plan files can carry."""


def shape_of(vertices: Array, faces: IntArray, finest: float, usage: Usage) -> Used:
    """Return the shape that triangles describe, as ``usage`` wants it.

    Args:
        vertices: (v, 3), in the scenario's units.
        faces: (t, 3).
        finest: the length below which the vertices' numbers say nothing.
        usage: what to do.

    Raises:
        GeometryError: what keeps them from being a shape.
    """
    weld = finest if usage.weld is None else usage.weld
    flat = finest if usage.flat is None else usage.flat
    points, triangles, moved = welded(vertices, faces, weld)
    if not len(triangles):
        raise GeometryError("the mesh encloses no volume: its triangles have no area")
    chosen = _chosen(points, triangles, usage)
    rows = np.sort(np.concatenate(chosen))
    if usage.convex == "exact":
        made = [_closed(*used(points, triangles[body]), usage, flat) for body in chosen]
        meshes, bent = _exact([mesh for mesh, _ in made]), max(bent for _, bent in made)
    else:
        surface = used(points, triangles[rows])
        pieces = _hulls(*surface, usage, flat)
        meshes = tuple(triangulated(piece) for piece in pieces)
        bent = np.inf
    before = points[triangles[rows]]
    extent = float(np.linalg.norm(np.ptp(before.reshape(-1, 3), axis=0)))
    off = min(bent, deviation(before, meshes)) if bent > NOTHING * extent else 0.0
    return Used(meshes, off + moved if off + moved > NOTHING * extent else 0.0)


def _chosen(points: Array, triangles: IntArray, usage: Usage) -> list[IntArray]:
    """Return the triangles of every body that is taken."""
    if usage.bodies in ("all", None) and usage.convex != "exact":
        return [np.arange(len(triangles))]
    found = bodies_of(points, triangles)
    if usage.bodies == "all" or (usage.bodies is None and len(found) == 1):
        return found
    if usage.bodies is None:
        raise SeveralBodiesError(f"there are {_listed(points, triangles, found)}")
    for k in usage.bodies:
        if k >= len(found):
            listed = _listed(points, triangles, found)
            raise GeometryError(f"bodies: there is no body {k}; there are {listed}")
    return [found[k] for k in sorted(set(usage.bodies))]


def _listed(points: Array, triangles: IntArray, bodies: Sequence[IntArray]) -> str:
    """Return how many bodies there are, and what the largest of them are like."""
    sizes = [np.ptp(points[triangles[rows]].reshape(-1, 3), axis=0) for rows in bodies]
    largest = sorted(range(len(bodies)), key=lambda k: -float(np.linalg.norm(sizes[k])))[:SHOWN]
    told = ", ".join(
        f"{k}: {' x '.join(f'{side:.3g}' for side in sizes[k])} ({len(bodies[k])} triangles)"
        for k in sorted(largest)
    )
    if len(bodies) == 1:
        return f"1 bodies ({told})"
    which = "" if len(largest) == len(bodies) else "the largest "
    return f"{len(bodies)} bodies ({which}{told})"


def _closed(
    points: Array, triangles: IntArray, usage: Usage, flat: float
) -> tuple[TriangleMesh, float]:
    """Return one body's closed surface, and how far a vertex moved (inf: another surface)."""
    bent = 0.0
    if usage.simplify is not None and len(triangles) > usage.simplify:
        points, triangles = simplified(points, triangles, usage.simplify)
        bent = np.inf
    if len(triangles) > MAX_FACES:
        raise TooManyTrianglesError(f"{len(triangles)} triangles; at most {MAX_FACES} are taken")
    mesh = checked(points, turned_outward(points, triangles) if usage.turn else triangles)
    plane = flattened(mesh, flat)
    if plane is mesh:
        return mesh, bent
    bent += float(np.linalg.norm(plane.vertices - mesh.vertices, axis=1).max())
    if bent <= NOTHING * mesh.extent:
        return mesh, 0.0
    points, triangles, _ = welded(plane.vertices, plane.faces, NOTHING * mesh.extent)
    return checked(points, triangles), bent


def _exact(meshes: Sequence[TriangleMesh]) -> tuple[TriangleMesh, ...]:
    """Return one surface as it is, the surfaces of several as those of their convex pieces."""
    pieces = [piece for mesh in meshes for piece in solid(mesh).pieces]
    if len(meshes) == 1:
        return tuple(meshes)
    if len(pieces) > MAX_PIECES:
        raise GeometryError(
            f"the bodies fall into {len(pieces)} convex pieces; at most {MAX_PIECES} are taken"
        )
    check_apart(pieces, "bodies: their convex pieces")
    return tuple(triangulated(piece) for piece in pieces)


def check_apart(pieces: Sequence[ConvexPiece], name: str) -> None:
    """Raise where two pieces overlap.

    Raises:
        GeometryError: the message begins with ``name``.
    """
    tolerance = OVERLAP * Body(tuple(pieces)).diagonal
    for i, piece in enumerate(pieces):
        for j in range(i):
            if penetrates(PlacedPiece(piece), PlacedPiece(pieces[j]), tolerance):
                raise GeometryError(
                    f"{name} {j} and {i} overlap; they may touch, so that volume counts once"
                )


def _hulls(points: Array, triangles: IntArray, usage: Usage, flat: float) -> list[ConvexPiece]:
    """Return the hull, or the pieces that fill the surface about; facets within ``flat`` plane."""
    if usage.convex == "hull":
        mesh = hull_mesh(points)
        if usage.simplify is not None and len(mesh.faces) > usage.simplify:
            mesh = hull_mesh(simplified(mesh.vertices, mesh.faces, usage.simplify)[0])
        return [clean_hull(mesh, flat)]
    parts = _parts(points, triangles, usage.simplify or BEFORE_CUTTING)
    return [clean_hull(hull_mesh(part), flat) for part in parts]


def _parts(points: Array, triangles: IntArray, most: int) -> list[Array]:
    """Return the corners of convex pieces: each closed body's, else of all triangles at once."""
    parts: list[Array] = []
    for body in bodies_of(points, triangles):
        corners, faces = simplified(*used(points, triangles[body]), most)
        try:
            mesh = checked(corners, turned_outward(corners, faces))
            filled = volume(hull(corners)) <= mesh.volume * (1.0 + FULL)
        except GeometryError:
            break
        parts += [corners] if filled else convex_parts(corners, mesh.faces, MAX_PIECES, closed=True)
    else:
        if len(parts) <= MAX_PIECES:
            return parts
    return convex_parts(*simplified(points, triangles, most), MAX_PIECES, closed=False)


SAMPLES = 1500
"""Points of either surface, and as many of its corners, at which their distance is taken."""


def deviation(before: Array, meshes: Sequence[TriangleMesh]) -> float:
    """Return the largest distance found between triangles (t, 3, 3) and the surface of a shape.

    What of the shape's pieces lies in other pieces is no surface.
    """
    after = np.concatenate([mesh.corners for mesh in meshes])
    rng = np.random.default_rng(0)
    there = surface_distances(after, _spots(before, rng))
    spots = [_spots(mesh.corners, rng) for mesh in meshes]
    if len(meshes) > 1:
        pieces = [hull(mesh.vertices) for mesh in meshes]
        slack = 1e-6 * float(np.linalg.norm(np.ptp(after.reshape(-1, 3), axis=0)))
        for k in range(len(spots)):
            for piece in pieces[:k] + pieces[k + 1 :]:
                heights = spots[k] @ piece.face_normals.T - piece.face_offsets
                spots[k] = spots[k][heights.max(axis=1, initial=-np.inf) > slack]
    back = surface_distances(before, np.concatenate(spots))
    return float(max(there.max(), back.max(initial=0.0)))


def _spots(corners: Array, rng: np.random.Generator) -> Array:
    """Return points of triangles: their corners, and some at random, by area."""
    a, b, c = corners.transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    rows = rng.choice(len(corners), SAMPLES, p=areas / areas.sum())
    u, v = rng.random((2, SAMPLES, 1))
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    cloud = np.unique(corners.reshape(-1, 3), axis=0)
    if len(cloud) > SAMPLES:
        cloud = cloud[rng.choice(len(cloud), SAMPLES, replace=False)]
    inner: Array = a[rows] + u * (b - a)[rows] + v * (c - a)[rows]
    return np.concatenate([cloud, inner])
