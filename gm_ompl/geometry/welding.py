"""Triangles as a file gives them: how finely it rounds, and which of its vertices are one."""

from __future__ import annotations

from decimal import Decimal

import numpy as np

from gm_ompl.arrays import Array, IntArray

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
