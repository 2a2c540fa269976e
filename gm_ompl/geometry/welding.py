"""Triangles as a file gives them: how finely it rounds, which vertices are one, which bodies."""

from __future__ import annotations

from decimal import Decimal

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.geometry.polygon import plane_basis

FINEST = 1e-7
"""Nothing is told apart below this part of the extent: the tolerance of all later steps."""

ROUND = 1e-5
"""Few digits are believed to be rounding up to this part of the extent: sizes may be round."""

COARSEST = 1e-3
"""Nor is single precision believed to blur more than this part of the extent."""

STEPS = 4.0
"""Lengths of so many roundings are none: two ends, each off by one in three coordinates."""

DIGITS = 9
"""Text with more significant digits is exact; with fewer it may be single precision, printed."""


def resolution(numbers: Array, single: bool = False) -> float:
    """Return the length below which coordinates (n, 3), as written, say nothing.

    Args:
        numbers: as read, neither scaled nor moved.
        single: whether they are known to be of single precision.
    """
    extent = float(np.linalg.norm(np.ptp(numbers, axis=0)))
    farthest = float(np.abs(numbers).max())
    if farthest == 0.0:
        return 0.0
    # Half a unit in the last place of single precision.
    step, most = 2.0**-24 * farthest, COARSEST
    if not single and (numbers != numbers.astype(np.float32)).any():
        digits = max(
            len(Decimal(repr(number)).normalize().as_tuple().digits)
            for number in numbers.ravel().tolist()
        )
        if digits > DIGITS:
            step = 0.0
        else:
            # The largest number of a file has the fewest decimals, or as many as the others.
            step = max(step, 0.5 * 10.0 ** (np.floor(np.log10(farthest)) - digits + 1))
            most = ROUND
    return float(min(max(STEPS * step, FINEST * extent), most * extent))


def welded(vertices: Array, faces: IntArray, weld: float) -> tuple[Array, IntArray, float]:
    """Return vertices and faces with vertices within ``weld`` of each other made one.

    Chains are followed; the one is the middle of them all. Triangles whose corners became one are
    dropped, and so are vertices that no triangle uses. The third is how far a vertex moved.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    # Equal ones first: files that repeat each corner per triangle have many.
    _, first, number = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")  # as the file has them
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    points, faces = vertices[first[order]], place[number.ravel()][faces]
    pairs, moved = cKDTree(points).query_pairs(weld, output_type="ndarray"), 0.0
    if len(pairs):
        links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
        count, label = connected_components(links, directed=False)
        total = np.zeros((count, 3))
        np.add.at(total, label, points)
        sizes = np.bincount(label)
        alone = sizes[label] == 1
        middle = total / sizes[:, None]
        middle[label[alone]] = points[alone]
        moved = float(np.linalg.norm(points - middle[label], axis=1).max())
        points, faces = middle, label[faces].astype(np.int64)
    return (*used(points, faces[(faces != np.roll(faces, -1, axis=1)).all(axis=1)]), moved)


def used(vertices: Array, faces: IntArray) -> tuple[Array, IntArray]:
    """Return the vertices that ``faces`` use, and the faces with their new numbers."""
    kept, number = np.unique(faces, return_inverse=True)
    return vertices[kept], number.reshape(-1, 3).astype(np.int64)


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
