"""Closed surfaces among triangles: who is whose neighbour, and which bodies they bound."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.geometry.polygon import plane_basis


def bodies_of(vertices: Array, faces: IntArray) -> list[IntArray]:
    """Return per body the numbers of its triangles, in the order of the file.

    Bodies hang together by their surface. Where more than two triangles share an edge, those
    between which there is material belong together: bodies may touch along edges and faces. A
    shell that faces inward is a hollow of the smallest body around it.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs = np.array(_joined(vertices, faces), dtype=np.int64).reshape(-1, 2)
    links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(faces), len(faces)))
    count, label = connected_components(links, directed=False)
    shells = [np.flatnonzero(label == k) for k in range(count)]
    shells.sort(key=lambda shell: int(shell[0]))
    return _with_hollows(vertices, faces, shells)


def _joined(vertices: Array, faces: IntArray) -> list[tuple[int, int]]:
    """Return pairs of triangles that meet at an edge of the same body."""
    edges: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for number, triangle in enumerate(faces.tolist()):
        for k in range(3):
            edge = triangle[k], triangle[(k + 1) % 3]
            edges.setdefault((min(edge), max(edge)), []).append((number, triangle[k - 1]))
    pairs: list[tuple[int, int]] = []
    for (tail, head), around in edges.items():
        if len(around) == 2:
            pairs.append((around[0][0], around[1][0]))
        elif len(around) > 2:
            pairs += _wedges(vertices, faces, (tail, head), around)
    return pairs


def _wedges(
    vertices: Array, faces: IntArray, edge: tuple[int, int], around: list[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Return the pairs of triangles at one edge that have material between them."""
    along = vertices[edge[1]] - vertices[edge[0]]
    basis = plane_basis(along / np.linalg.norm(along))
    across = (vertices[[apex for _, apex in around]] - vertices[edge[0]]) @ basis.T
    angle = np.arctan2(across[:, 1], across[:, 0])
    rows = [faces[number].tolist() for number, _ in around]
    # A triangle that runs along the edge has its material on the side of smaller angles.
    ahead = [row[(row.index(edge[0]) + 1) % 3] == edge[1] for row in rows]
    # Of triangles at one angle, those that end a body's wedge come first.
    order = sorted(range(len(around)), key=lambda k: (round(float(angle[k]), 6), not ahead[k]))
    pairs = []
    for k, first in enumerate(order):
        second = order[(k + 1) % len(order)]
        if ahead[second] and not ahead[first]:
            pairs.append((around[first][0], around[second][0]))
    return pairs


def _with_hollows(vertices: Array, faces: IntArray, shells: list[IntArray]) -> list[IntArray]:
    corners = vertices[faces] - vertices.mean(axis=0)
    sizes = [float(np.linalg.det(corners[shell]).sum()) for shell in shells]
    if not any(size > 0.0 for size in sizes):
        return shells
    outer = [k for k, size in enumerate(sizes) if size > 0.0]
    found = {k: [shells[k]] for k in outer}
    for k, shell in enumerate(shells):
        if k in found:
            continue
        point = vertices[faces[shell[0]]].mean(axis=0)
        around = [j for j in outer if inside(point, vertices[faces[shells[j]]])]
        if around:
            found[min(around, key=lambda j: sizes[j])].append(shell)
        else:
            found[k] = [shell]  # alone and inside out: the reader turns it
    return [np.sort(np.concatenate(found[k])) for k in sorted(found)]


def inside(point: Array, corners: Array) -> bool:
    """Whether ``point`` lies within triangles (t, 3, 3): their winding number, by solid angles."""
    a, b, c = (corners - point).transpose(1, 0, 2)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    volume_of = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    angle = 2.0 * np.arctan2(volume_of, la * lb * lc + ab * lc + bc * la + ca * lb)
    return bool(angle.sum() > 2.0 * np.pi)
