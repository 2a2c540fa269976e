"""Cells of whole faces, halved without end: every point of a face is in one."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.patches import Patch
from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.holds.cells import FIRST, ROUNDING, doubled, grown
from gm_ompl.holds.tables import ArcTable
from gm_ompl.mechanics.cell_cuts import CellBoxes

LITTER: Final = 6
"""Geometry is tested for all cells at once that so many halvings make of one."""

SMALLEST: Final = 1e-8
"""Cells whose sides are shorter than this, over D, are halved no more."""

SQUARES: Final = 1e-13
"""By this much of their coefficients squares of lengths give way: rounding."""

LEAST_RADIUS: Final = 1e-3
"""Of a fingertip, in its radii, up to which it stands for those of a cell."""


@final
class FaceCells:
    """The cells that were made so far, by their numbers; ``Cells`` of a grid without end.

    What ``tables`` say holds at every point of a cell at best: fingers are free where one is whose
    radius is less by half the cell's diagonal, and chords as short as anywhere in the cell.

    Args:
        judge: of a problem whose placements are the patches' ``frames``.
        table: the arcs, with those placements.
        patches: the faces' parts.
        points: placements that the fingers' start and goal name.

    Attributes:
        boxes: the cells in coordinates of their patches.
        tables: as ``ArcTable`` has them, by cells.
        faces: (F,), per patch the cell of all of it.
        planes: (F, 3, 3), per patch its middle and a unit along either axis.
    """

    def __init__(
        self, judge: Judge, table: ArcTable, patches: Sequence[Patch], points: PlacementTable
    ) -> None:
        self._judge, self._table, self._patches, self._given = judge, table, patches, points
        frame, hand = table.measured, judge.problem.fingers
        n, rows, P = hand.count, frame.free.shape[2], frame.states.shape[1]
        self._lengths, self._passable = _quadratics(judge, table, patches), table.passable()
        self.boxes = CellBoxes(np.empty((FIRST, 4)), np.zeros(FIRST, dtype=np.int64))
        self.tables = frame._replace(
            free=np.empty((n, FIRST, rows), dtype=np.bool_),
            lengths=np.empty((n, FIRST, rows, P)),
            node_free=np.empty((n, FIRST, len(frame.goal)), dtype=np.bool_),
            wanted=np.full(n, -1, dtype=np.int64),
            z_min=frame.z_min * (1.0 - ROUNDING),
        )
        self._middles, self._arms = np.empty((n, FIRST, 3)), np.empty(FIRST)
        self._count = 0
        self._halves: dict[int, tuple[int, int]] = {}
        self._points: dict[int, int] = {}
        self._litters: dict[tuple[int, int], dict[tuple[float, ...], int]] = {}
        self._tests: dict[tuple[int, int], tuple[BoolArray, BoolArray]] = {}
        self._above: list[tuple[int, int]] = []  # per cell, who has the litter, and how far up
        frames = [[p.rectangle.centre, *p.rectangle.axes] for p in patches]
        self.planes = np.array(frames).reshape(-1, 3, 3)
        whole = [np.concatenate([[0.0, 0.0], patch.rectangle.half]) for patch in patches]
        self.faces = tuple(self._root(f, sides) for f, sides in enumerate(whole))
        self.tables = self.tables._replace(least=self._least())

    def __len__(self) -> int:
        return self._count

    def by_face(self, columns: Array) -> Array:
        """Return the fingers' columns (n, 3 F, s, 6) on each face: (n, F, s, 3, 6)."""
        middle, first, second = columns[:, 0::3], columns[:, 1::3], columns[:, 2::3]
        return np.stack([middle, first - middle, second - middle], axis=3)

    def point(self, row: int) -> int:
        """Return the cell of a given placement alone."""
        known = self._points.get(row)
        if known is None:
            number = int(self._given.face[row])
            f = next(k for k, patch in enumerate(self._patches) if patch.number == number)
            place = self._patches[f].places(self._given.points[row : row + 1])[0]
            known = self._points[row] = self._root(f, np.concatenate([place, [0.0, 0.0]]))
        return known

    def row(self, cell: int) -> int:  # noqa: ARG002
        """Return -1: no cell is a placement of a grid."""
        return -1

    def width(self, cell: int) -> float:
        """Return the length of a cell's longer side; 0 of one that is halved no more."""
        width = 2.0 * float(self.boxes.sides[cell, 2:].max())
        return width if width > SMALLEST * self._judge.problem.body.diagonal else 0.0

    def halves(self, cell: int) -> tuple[int, int]:
        """Return the two cells that a cell falls into."""
        known = self._halves.get(cell)
        if known is None:
            low, high = _halved(self.boxes.sides[cell])
            top, depth = self._above[cell]
            if depth == LITTER:
                top, depth = cell, 0
            made = [self._child(top, depth + 1, sides) for sides in (low, high)]
            known = self._halves[cell] = made[0], made[1]
        return known

    def apart(self, i: int, cell: int, j: int, other: int, least: float) -> bool:
        """Whether somewhere in two cells fingertips i and j may be so far apart."""
        middle = self._middles[i, cell] - self._middles[j, other]
        reach = np.linalg.norm(middle) + self._arms[cell] + self._arms[other]
        return bool(reach >= least * (1.0 - ROUNDING))

    def places(self, cell: int) -> Array:
        """Return a cell's middle and corners (k, 3), its middle alone where it is one point."""
        sides, patch = self.boxes.sides[cell], self.patch(cell)
        if not sides[2:].any():
            return patch.points(sides[None, :2])
        ends = np.array([[0, 0], [-1, -1], [-1, 1], [1, -1], [1, 1]])
        corners: Array = sides[:2] + ends * sides[2:]
        return patch.points(corners)

    def patch(self, cell: int) -> Patch:
        """Return the patch that a cell is on."""
        return self._patches[int(self.boxes.faces[cell])]

    def _root(self, face: int, sides: Array) -> int:
        free, node_free = self._tested(face, sides[None])
        cell = self._make(face, sides, free[:, 0], node_free[:, 0])
        self._above.append((cell, 0))
        return cell

    def _child(self, top: int, depth: int, sides: Array) -> int:
        """Make a cell that ``depth`` halvings make of ``top``."""
        face = int(self.boxes.faces[top])
        litter = self._litters.get((top, depth))
        if litter is None:
            boxes = self.boxes.sides[top][None]
            for _ in range(depth):
                boxes = np.concatenate([_halved(box) for box in boxes])
            litter = {tuple(box.tolist()): k for k, box in enumerate(boxes)}
            self._litters[top, depth] = litter
            self._tests[top, depth] = self._tested(face, boxes)
        free, node_free = self._tests[top, depth]
        k = litter[tuple(sides.tolist())]
        cell = self._make(face, sides, free[:, k], node_free[:, k])
        self._above.append((top, depth))
        return cell

    def _tested(self, face: int, boxes: Array) -> tuple[BoolArray, BoolArray]:
        """Return where fingers in cells (k, 4) of one size may be free, (n, k, ..) twice."""
        limits.check()
        patch, problem = self._patches[face], self._judge.problem
        hand, points = problem.fingers, patch.points(boxes[:, :2])
        arm = float(np.linalg.norm(boxes[0, 2:])) * (1.0 + ROUNDING)
        small = np.maximum(hand.radius - arm, LEAST_RADIUS * hand.radius)
        k = len(boxes)
        table = PlacementTable(
            points=points - arm * patch.normal,
            normals=np.tile(patch.normal, (k, 1)),
            face=np.full(k, patch.number),
            cell=np.zeros((k, 2), dtype=np.int64),
            piece=patch.owners(points),
            labels=hand.placements.labels,
        )
        standing = dataclasses.replace(hand, placements=table, radius=small)
        judge = self._judge.of_hand(
            dataclasses.replace(problem, fingers=standing), self._judge.backend
        )
        node_free, free = self._table.tested(judge)
        for i in np.flatnonzero(hand.radius - arm < small):
            node_free[i], free[i] = self._passable
        empty = patch.empty(points, arm)
        free[:, empty], node_free[:, empty] = False, False
        return free, node_free

    def _make(self, face: int, sides: Array, free: BoolArray, node_free: BoolArray) -> int:
        cell = self._count
        self._count += 1
        if cell == len(self._arms):
            self._grow()
        self.boxes.sides[cell], self.boxes.faces[cell] = sides, face
        self.tables.free[:, cell], self.tables.node_free[:, cell] = free, node_free
        self.tables.lengths[:, cell] = _least(self._lengths[:, face], sides)
        patch, radius = self._patches[face], self._judge.problem.fingers.radius
        self._middles[:, cell] = patch.points(sides[None, :2]) - radius[:, None] * patch.normal
        self._arms[cell] = np.linalg.norm(sides[2:])
        return cell

    def _least(self) -> Array:
        """Return (V,): least travel to the goal, with whatever placements, of the slowest."""
        roots = list(self.faces)
        free, travel = self.tables.free[:, roots], self.tables.lengths[:, roots].sum(axis=3)
        shortest = np.where(free, travel, np.inf).min(axis=1, initial=np.inf)
        return self._table.ahead(shortest.max(axis=0, initial=0.0))

    def _grow(self) -> None:
        """Make room for twice as many cells."""
        self.boxes, self.tables = grown(self.boxes, self.tables)
        self._middles, self._arms = doubled(self._middles, 1), doubled(self._arms, 0)


def _halved(sides: Array) -> Array:
    """Return the halves (2, 4) of a cell (4,), across its longer side."""
    axis = int(sides[3] > sides[2])
    halves = np.stack([sides, sides])
    halves[:, 2 + axis] /= 2.0
    halves[0, axis] -= halves[0, 2 + axis]
    halves[1, axis] += halves[1, 2 + axis]
    return halves


PROBES: Final = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1]])
"""Places at which a quadratic is told."""


def _quadratics(judge: Judge, table: ArcTable, patches: Sequence[Patch]) -> Array:
    """Return the squares of Eq. (9)'s chords over each patch, (n, F, rows, P, 6).

    A chord is the norm of a function that is affine in the placement. The coefficients are those
    of 1, u, v, u^2, u v, v^2.
    """
    hand, known = judge.problem.fingers, dict[float, Array]()
    for radius in hand.radius.tolist():
        if radius not in known:
            found = []
            for patch in patches:
                size = max(float(patch.rectangle.half.max()), 1e-3 * judge.problem.body.diagonal)
                centres = patch.points(size * PROBES) - radius * patch.normal
                q, e, w, n, s, ne = table.lengths(centres) ** 2
                u, v, uu, vv = (e - w) / 2.0, (n - s) / 2.0, (e + w) / 2.0 - q, (n + s) / 2.0 - q
                uv = ne - q - u - v - uu - vv
                scaled = (q, u / size, v / size, uu / size**2, uv / size**2, vv / size**2)
                found.append(np.stack(scaled, axis=-1))
            known[radius] = np.stack(found)
    return np.stack([known[radius] for radius in hand.radius.tolist()])


def _least(squares: Array, sides: Array) -> Array:
    """Return the roots of the least values of convex quadratics (.., 6) over a cell (4,)."""
    c, cu, cv, cuu, cuv, cvv = np.moveaxis(squares, -1, 0)
    p, r, wide, high = sides
    least = np.full(c.shape, np.inf)

    def take(u: Array, v: Array) -> None:
        value = c + cu * u + cv * v + cuu * u * u + cuv * u * v + cvv * v * v
        np.minimum(least, value, out=least)

    def stationary(slope: Array, curve: Array, middle: float, half: float) -> Array:
        flat = curve <= 0.0
        best = np.where(flat, middle, -slope / (2.0 * np.where(flat, 1.0, curve)))
        return np.clip(best, middle - half, middle + half)

    for u in (p - wide, p + wide):
        for v in (r - high, r + high):
            take(np.asarray(u), np.asarray(v))
        take(np.asarray(u), stationary(cv + cuv * u, cvv, r, high))
    for v in (r - high, r + high):
        take(stationary(cu + cuv * v, cuu, p, wide), np.asarray(v))
    det = 4.0 * cuu * cvv - cuv * cuv
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = (cuv * cv - 2.0 * cvv * cu) / det, (cuv * cu - 2.0 * cuu * cv) / det
    inside = (np.abs(u - p) <= wide) & (np.abs(v - r) <= high)
    take(np.where(inside, u, p), np.where(inside, v, r))
    far = max(abs(p) + wide, abs(r) + high)
    size = np.abs(squares) @ np.array([1.0, far, far, far**2, far**2, far**2])
    root: Array = np.sqrt(np.maximum(least - SQUARES * size, 0.0))
    return root
