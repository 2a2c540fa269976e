"""Facets that rounding or a scan has bent are made plane: vertices move, as little as they must.

What follows, contacts above all, needs faces that are plane to much less than a file's rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.geometry.facets import facets_of, neighbours_of
from gm_ompl.geometry.triangles import TriangleMesh

PLANE = 1e-9
"""Facets are plane once their vertices are this close to one, relative to the extent."""

ROUNDS = 60
"""Most rounds of fitting planes and moving vertices."""

FARTHEST = 20.0
"""A vertex moves no farther than this many times ``flat``, however flat its planes cross."""


@dataclass(frozen=True, eq=False)
class _Incidence:
    """Which vertices lie in which facet: row i says vertex[i] lies in facet[i]."""

    vertex: IntArray
    facet: IntArray
    count: int
    axis: IntArray
    """(count,), the axis along which the facet's normal points exactly, or -1."""


def flattened(mesh: TriangleMesh, flat: float) -> TriangleMesh:
    """Return the mesh with its facets made plane.

    Neighbouring triangles that lie within ``flat`` of one plane are a facet. A facet within
    ``flat`` of a plane across a coordinate axis is given that plane.
    """
    facets = facets_of(mesh.corners, neighbours_of(mesh.faces), flat)
    vertices = np.array(mesh.vertices)
    members = [np.unique(mesh.faces[rows]) for rows in facets]
    axis = np.array([_axis(vertices[m], flat) for m in members], dtype=np.int64)
    kept = [k for k, m in enumerate(members) if len(m) > 3 or axis[k] >= 0]
    if not kept:
        return mesh
    rows = _Incidence(
        vertex=np.concatenate([members[k] for k in kept]),
        facet=np.repeat(np.arange(len(kept)), [len(members[k]) for k in kept]),
        count=len(kept),
        axis=axis[kept],
    )
    for _ in range(ROUNDS):
        normals, gaps = _planes(vertices, rows)
        if np.abs(gaps).max() <= PLANE * mesh.extent:
            break
        vertices -= _steps(normals, gaps, rows, len(vertices), FARTHEST * flat)
    return TriangleMesh(vertices, mesh.faces)


def _axis(points: Array, flat: float) -> int:
    spread = np.ptp(points, axis=0)
    axis = int(spread.argmin())
    return axis if spread[axis] <= 2.0 * flat and spread[axis] < 1e-3 * spread.max() else -1


def _planes(vertices: Array, rows: _Incidence) -> tuple[Array, Array]:
    """Return the facets' normals (f, 3), and per row how far its vertex is above the plane."""
    points, counts = vertices[rows.vertex], np.bincount(rows.facet)
    middle = np.zeros((rows.count, 3))
    np.add.at(middle, rows.facet, points)
    local = points - (middle / counts[:, None])[rows.facet]
    spread = np.zeros((rows.count, 3, 3))
    np.add.at(spread, rows.facet, local[:, :, None] * local[:, None, :])
    normals = np.linalg.eigh(spread)[1][:, :, 0]
    across = rows.axis >= 0
    normals[across] = np.eye(3)[rows.axis[across]]
    return normals, np.einsum("ij,ij->i", local, normals[rows.facet])


def _steps(normals: Array, gaps: Array, rows: _Incidence, count: int, farthest: float) -> Array:
    """Return the least steps (v, 3) that bring every vertex nearest to all its planes."""
    n = normals[rows.facet]
    gram, pull = np.zeros((count, 3, 3)), np.zeros((count, 3))
    np.add.at(gram, rows.vertex, n[:, :, None] * n[:, None, :])
    np.add.at(pull, rows.vertex, n * gaps[:, None])
    values, frames = np.linalg.eigh(gram)
    along = np.einsum("vij,vi->vj", frames, pull)
    steps = np.where(values > 1e-9, along / np.where(values > 1e-9, values, 1.0), 0.0)
    steps[np.abs(steps) > farthest] = 0.0
    moved: Array = np.einsum("vij,vj->vi", frames, steps)
    return moved
