"""What would make a mesh usable that is not: tried before it is offered."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import GeometryError, MissingExtraError
from gm_ompl.geometry.triangles import OpenMeshError
from gm_ompl.geometry.usage import (
    SeveralBodiesError,
    TooManyTrianglesError,
    Usage,
    Used,
    shape_of,
)
from gm_ompl.geometry.welding import bodies_of, welded

WELDS = (10.0, 100.0, 1000.0)
"""Lengths tried for ``weld``, in those below which the numbers say nothing."""

WIDEST = 1e-2
"""No ``weld`` beyond this part of the extent is offered."""

FEWER = 2000
"""The number of triangles tried for ``simplify``."""


def shape_or_remedy(vertices: Array, faces: IntArray, finest: float, usage: Usage) -> Used:
    """Return ``shape_of``; where it is refused, the message offers keys with which it is not.

    Raises:
        GeometryError: with the remedies that were tried and work.
    """
    try:
        return shape_of(vertices, faces, finest, usage)
    except GeometryError as error:
        offered = list(_offers(vertices, faces, finest, usage, error))
        if not offered:
            raise
        raise GeometryError(f"{error}; add {', or '.join(offered)}") from None


def _offers(
    vertices: Array, faces: IntArray, finest: float, usage: Usage, error: GeometryError
) -> Iterator[str]:
    for text, change in _candidates(vertices, faces, finest, error):
        if _works(vertices, faces, finest, replace(usage, **change)) is not None:
            yield text
            if "weld" in change:
                break
    if usage.convex != "hull":
        found = _works(vertices, faces, finest, replace(usage, convex="hull"))
        if found is not None:
            yield f"convex: hull (its convex hull, up to {found.deviation:.3g} off)"
        if usage.convex == "exact" and found is not None:
            yield "convex: decompose (convex pieces near it; takes a while)"


def _candidates(
    vertices: Array, faces: IntArray, finest: float, error: GeometryError
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield keys that may help against one kind of error, and what they change."""
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if isinstance(error, SeveralBodiesError):
        yield "bodies: all (one rigid body)", {"bodies": "all"}
        points, triangles, _ = welded(vertices, faces, finest)
        bodies = bodies_of(points, triangles)
        spans = [np.ptp(points[triangles[rows]].reshape(-1, 3), axis=0) for rows in bodies]
        largest = int(np.argmax(np.linalg.norm(spans, axis=1)))
        yield f"bodies: [{largest}] (this one alone)", {"bodies": (largest,)}
    elif isinstance(error, TooManyTrianglesError):
        yield f"simplify: {FEWER}", {"simplify": FEWER}
    elif isinstance(error, OpenMeshError):
        for factor in WELDS:
            weld = float(f"{factor * finest:.0e}")
            if weld <= WIDEST * extent:
                yield f"weld: {weld:g}", {"weld": weld}


def _works(vertices: Array, faces: IntArray, finest: float, usage: Usage) -> Used | None:
    try:
        return shape_of(vertices, faces, finest, usage)
    except (GeometryError, MissingExtraError):
        return None
