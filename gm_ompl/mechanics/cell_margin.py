"""Bounds on z over products of cells of placements, compiled.

Every point of a cell is a convex combination of its corners, so what a finger can exert there it
can exert with the cones at all corners at once under its one limit. Problem (6) for such fingers
bounds z for all points of the product, whatever the modes: position control and Problem (5) left
aside are optimistic, too. The answer is a wrench whose cut proves it (``certificate``).
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.cell_cuts import CellBoxes
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.mechanics.stability import BELOW, REACHED, position_margin
from gm_ompl.mechanics.tau import new_tableau


@compiled
def corner_columns(columns: Array, hand: IntArray, cells: IntArray, boxes: CellBoxes) -> Array:
    """Return the columns (k, 4 s, 6) of fingers at all corners of their cells.

    Args:
        columns: (n, F, s, 3, 6), all fingers' columns on each face: constant and slopes.
        hand: (k,), the fingers.
        cells: (k,), the cell of each.
        boxes: the cells.
    """
    s = columns.shape[2]
    tips = np.empty((len(hand), 4 * s, 6))
    for i in range(len(hand)):
        p, r = boxes.sides[cells[i], 0], boxes.sides[cells[i], 1]
        wide, high = boxes.sides[cells[i], 2], boxes.sides[cells[i], 3]
        side = columns[hand[i], boxes.faces[cells[i]]]
        for corner in range(4):
            u = p + (wide if corner % 2 else -wide)
            v = r + (high if corner // 2 else -high)
            for k in range(s):
                for t in range(6):
                    here = side[k, 0, t] + u * side[k, 1, t] + v * side[k, 2, t]
                    tips[i, corner * s + k, t] = here
    return tips


@compiled
def corner_points(planes: Array, cells: IntArray, boxes: CellBoxes) -> Array:
    """Return the points (k, 4, 3) at the corners of cells (k,), in ``corner_columns``' order.

    Args:
        planes: (F, 3, 3), of each face: the point of coordinates (0, 0) and a unit of either.
        cells: the cells.
        boxes: all cells.
    """
    points = np.empty((len(cells), 4, 3))
    for i in range(len(cells)):
        p, r = boxes.sides[cells[i], 0], boxes.sides[cells[i], 1]
        wide, high = boxes.sides[cells[i], 2], boxes.sides[cells[i], 3]
        plane = planes[boxes.faces[cells[i]]]
        for corner in range(4):
            u = p + (wide if corner % 2 else -wide)
            v = r + (high if corner // 2 else -high)
            for t in range(3):
                points[i, corner, t] = plane[0, t] + u * plane[1, t] + v * plane[2, t]
    return points


@compiled
def cell_margin(program: Program, separation: Separation, below: float, y: Array) -> float:
    """Return an upper bound on z for all points of a product of cells; -inf: no equilibrium.

    Args:
        program: what acts; ``tips`` (k, c, 6) are each finger's columns at all corners of its cell.
        separation: of the environment's columns.
        below: where z is proven smaller than this, any such bound will do.
        y: output (6,), the wrench of the cut that proves it; zero where nothing does.
    """
    n, s = program.tips.shape[0], program.tips.shape[1]
    tableau = new_tableau(n, len(program.env), s)
    end, z, _ = position_margin(program, separation, below, True, tableau, y)
    return z if end in (BELOW, REACHED) else np.inf
