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

    pairs = _joined(vertices, faces)
    links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(faces), len(faces)))
    count, label = connected_components(links, directed=False)
    shells = [np.flatnonzero(label == k) for k in range(count)]
    shells.sort(key=lambda shell: int(shell[0]))
    return _with_hollows(vertices, faces, shells)


def _joined(vertices: Array, faces: IntArray) -> IntArray:
    """Return pairs (k, 2) of triangles that meet at an edge of the same body."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    key = ends.min(axis=1) * len(vertices) + ends.max(axis=1)
    order = np.argsort(key, kind="stable")
    _, first, counts = np.unique(key[order], return_index=True, return_counts=True)
    owner = order // 3
    two = first[counts == 2]
    pairs = [np.stack([owner[two], owner[two + 1]], axis=1)]
    for start, count in zip(first[counts > 2], counts[counts > 2], strict=True):
        around = owner[start : start + count]
        tail, head = sorted(ends[order[start]].tolist())
        pairs.append(_wedges(vertices, faces, (tail, head), around))
    return np.concatenate(pairs)


def _wedges(vertices: Array, faces: IntArray, edge: tuple[int, int], around: IntArray) -> IntArray:
    """Return the pairs of triangles at one edge that have material between them."""
    along = vertices[edge[1]] - vertices[edge[0]]
    basis = plane_basis(along / np.linalg.norm(along))
    rows = faces[around].tolist()
    apex = [next(k for k in row if k not in edge) for row in rows]
    across = (vertices[apex] - vertices[edge[0]]) @ basis.T
    angle = np.arctan2(across[:, 1], across[:, 0])
    # A triangle that runs along the edge has its material on the side of smaller angles.
    ahead = [row[(row.index(edge[0]) + 1) % 3] == edge[1] for row in rows]
    # Of triangles at one angle, those that end a body's wedge come first.
    order = sorted(range(len(around)), key=lambda k: (round(float(angle[k]), 6), not ahead[k]))
    pairs = []
    for k, first in enumerate(order):
        second = order[(k + 1) % len(order)]
        if ahead[second] and not ahead[first]:
            pairs.append((around[first], around[second]))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


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
