"""Where fingertips may be placed: a table of contact points on the object's faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, IntArray, read_only


@dataclass(frozen=True, eq=False)
class PlacementTable:
    """All discrete fingertip placements, object frame; a placement is its row number.

    Attributes:
        points: (P, 3), the contact point on the surface.
        normals: (P, 3), unit, pointing into the object.
        face: (P,), index into ``labels``.
        cell: (P, 2), the grid cell on that face.
        piece: (P,), the convex piece of the body that the face belongs to.
        labels: the faces' names ("+x", ... for a box, "0", "1", ... for a hull).
    """

    points: Array
    normals: Array
    face: IntArray
    cell: IntArray
    piece: IntArray
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", read_only(self.points, (None, 3), "points"))
        object.__setattr__(self, "normals", read_only(self.normals, (None, 3), "normals"))
        for name in ("face", "cell", "piece"):
            whole = np.array(getattr(self, name), dtype=np.int64)
            whole.flags.writeable = False
            object.__setattr__(self, name, whole)

    def __len__(self) -> int:
        return len(self.points)

    def centres(self, radius: float) -> Array:
        """Return the fingertip centres (P, 3), object frame: one radius out along the normal."""
        outward: Array = self.points - radius * self.normals
        return outward

    def find(self, label: str, cell: Sequence[int]) -> int | None:
        """Return the placement on face ``label`` at ``cell``, or None if there is none."""
        if label not in self.labels:
            return None
        hits = np.flatnonzero(
            (self.face == self.labels.index(label)) & (self.cell == np.asarray(cell)).all(axis=1)
        )
        return int(hits[0]) if len(hits) else None
