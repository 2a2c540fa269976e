"""What waits in the search over cells of placements."""

from __future__ import annotations

from dataclasses import dataclass

from gm_ompl.arrays import IntArray
from gm_ompl.graph.cell_graph import Tuple
from gm_ompl.graph.skeletons import Skeleton


@dataclass(frozen=True, eq=False)
class Product:
    """Cells for the spots of a skeleton.

    Attributes:
        skeleton: the order of regrasps.
        cells: per spot.
        legs: (m,), the lanes.
        rests: (m - 1,), between them.
        depth: how often it was divided.
    """

    skeleton: Skeleton
    cells: Tuple
    legs: IntArray
    rests: IntArray
    depth: int
