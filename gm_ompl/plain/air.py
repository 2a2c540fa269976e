"""Ways through the air stated plainly: a second opinion on ``feasibility.reach``.

A stretch of a fingertip's way is clear of a convex piece where one plane keeps both its ends far
enough off: of a face, or across the way from the piece to the stretch's middle. Where no plane does
it is halved, until its middle is too near or it is too short to tell. A grid of sphere centres is
flooded, node by node of a wave, with the spacing that ``Fingers.clearance`` asks for.
"""

from __future__ import annotations

import enum
import itertools
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.geometry.collision import EXACT, allowed_depth
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import ConvexPiece
from gm_ompl.problem import Problem

HALVINGS = 20
"""A stretch halved as often that is still undecided counts as blocked."""

SPACINGS = (1.0, 0.5)
"""Of the grids flooded, in fingertip radii, before the finest."""

CELL = 3.0**0.5 / 2.0
"""From the middle of a cell to its corners, in spacings."""

MOST = 200_000
"""Nodes looked at per grid."""

OFF = tuple(2.0**k for k in range(-7, 8))
"""How far off a placement the air is entered, in clearances."""

WAYS = np.concatenate([np.eye(3), -np.eye(3)])


Node: TypeAlias = tuple[float, ...]
"""A node of a grid: whole numbers of spacings."""


class Freedom(enum.Enum):
    """Whether a fingertip gets away; the value is a sentence for the user."""

    FREE = "it can get away through the air"
    POCKET = "it is in a pocket: no way through the air leads there"
    UNKNOWN = "whether it is in a pocket was not decided: too much air to look at"


class Air:
    """Where one fingertip's centre may go while the object rests, object frame.

    Args:
        problem: the problem.
        pose: where the object rests.
        finger: whose fingertip.
        staying: the others that touch, and the row of each.
        slack: how much smaller the fingertip is taken to be.
    """

    def __init__(
        self,
        problem: Problem,
        pose: Pose,
        finger: int,
        staying: Sequence[tuple[int, int]],
        slack: float = 0.0,
    ) -> None:
        self.problem, self.pose, self.finger, self.staying = problem, pose, finger, staying
        hand, D = problem.fingers, problem.body.diagonal
        self.radius = float(hand.radius[finger]) - slack
        self._pieces = [(p, self.radius - allowed_depth(D, p)) for p in problem.body.pieces]
        self._fixed = [
            (p, self.radius - allowed_depth(D, p))
            for o in problem.environment.obstacles
            for p in o.body.pieces
        ]
        self._exact = EXACT * D
        finest = float(hand.clearance[finger]) / 2.0
        self._spacings = (*(share * self.radius for share in SPACINGS), finest)
        table = hand.placements
        self._tips = [
            (table.points[row] - hand.radius[i] * table.normals[row], float(hand.radius[i]))
            for i, row in staying
        ]
        far = [np.abs(problem.body.vertices).max()]
        far += [np.abs(pose.to_object(p.vertices)).max() for p, _ in self._fixed]
        self.far = 8.0 * float(max(far))
        self.up = pose.rotation[2]

    def blocked(self, a: Array, b: Array, touching: int | None = None) -> list[str]:
        """Return what is in the way of each stretch from ``a`` to ``b`` (n, 3), "" for nothing."""
        said = [""] * len(a)
        for name, free in self._tests(a, b, touching):
            for k in np.flatnonzero(~free):
                said[k] = said[k] or name
        return said

    def clear(self, a: Array, b: Array, touching: int | None = None) -> BoolArray:
        """Return which stretches from ``a`` to ``b`` (n, 3) are clear, (n,)."""
        every = np.ones(len(a), dtype=bool)
        for _, free in self._tests(a, b, touching):
            every &= free
        return every

    def _tests(self, a: Array, b: Array, touching: int | None) -> Iterator[tuple[str, BoolArray]]:
        """Yield, thing by thing, its name and which stretches are clear of it."""
        if self.problem.environment.floor:
            heights = [p @ self.up + self.pose.position[2] for p in (a, b)]
            yield "the floor", np.minimum(*heights) >= self.radius - self._exact
        for k, (piece, least) in enumerate(self._pieces):
            if k != touching:
                yield "the object", clear_of(piece, a, b, least)
        if self._fixed:
            ends = self.pose.apply(a), self.pose.apply(b)
            for piece, least in self._fixed:
                yield "an obstacle", clear_of(piece, *ends, least)
        for centre, radius in self._tips:
            yield (
                "another fingertip",
                _clear_of_point(centre, a, b, radius + self.radius - self._exact),
            )

    def freedom(self, row: int) -> Freedom:
        """Return whether the fingertip gets away from a placement."""
        stubs = self.stubs(row)
        if not len(stubs):
            return Freedom.POCKET
        ways = self.far * np.concatenate([self.up[None], WAYS])
        starts = np.repeat(stubs, len(ways), axis=0)
        if self.clear(starts, starts + np.tile(ways, (len(stubs), 1))).any():
            return Freedom.FREE
        found = Freedom.POCKET
        for spacing in self._spacings:
            found = self._flooded(stubs, spacing)
            if found is Freedom.FREE or self._closed(stubs, spacing):
                break
        return found if found is Freedom.FREE or spacing == self._spacings[-1] else Freedom.POCKET

    def _closed(self, stubs: Array, spacing: float) -> bool:
        """Whether there is no way out for certain.

        Nodes stand for the cells around them: with a fingertip smaller by half a cell's diagonal,
        no free place of a cell is missed.
        """
        slack = CELL * spacing
        if slack >= self.radius:
            return False
        smaller = Air(self.problem, self.pose, self.finger, self.staying, slack)
        return smaller._flooded(stubs, spacing, cells=True) is Freedom.POCKET

    def stubs(self, row: int) -> Array:
        """Return points (k, 3) off a placement along its normal, and off its face at last."""
        table = self.problem.fingers.placements
        normal = table.normals[row]
        here = table.points[row] - self.radius * normal
        clearance = float(self.problem.fingers.clearance[self.finger])
        off = here - clearance * np.array(OFF)[:, None] * normal
        free = self.clear(np.tile(here, (len(off), 1)), off, int(table.piece[row]))
        found: Array = off[: len(off) if free.all() else int(free.argmin())]
        return found

    def joined(self, a: int, b: int) -> bool:
        """Whether the fingertip gets from one placement in a pocket to another."""
        ends = self.stubs(a), self.stubs(b)
        return any(
            self._flooded(ends[0], spacing, frozenset(self._joints(ends[1], spacing)))
            is Freedom.FREE
            for spacing in self._spacings
        )

    def _flooded(
        self,
        stubs: Array,
        spacing: float,
        sought: frozenset[Node] = frozenset(),
        *,
        cells: bool = False,
    ) -> Freedom:
        """Flood from around ``stubs``; FREE where it gets away, or to a node that is sought."""
        front = self._joints(stubs, spacing)
        known = set(front)
        while front:
            if not sought.isdisjoint(front):
                return Freedom.FREE
            nodes = np.array(front, dtype=float)
            asked = spacing * nodes[(nodes % 4 == 0).all(axis=1)]
            for way in (self.up, *WAYS) if len(asked) and not sought else ():
                if self.clear(asked, asked + self.far * way).any():
                    return Freedom.FREE
            if len(known) > MOST:
                return Freedom.UNKNOWN
            tails = np.repeat(nodes, 6, axis=0)
            heads = tails + np.tile(WAYS, (len(nodes), 1))
            new = np.array([tuple(h) not in known for h in heads.tolist()], dtype=bool)
            tails, heads = tails[new], heads[new]
            free = self.clear(spacing * (heads if cells else tails), spacing * heads)
            front = list({tuple(h) for h in heads[free].tolist()})
            known.update(front)
        return Freedom.POCKET

    def _joints(self, stubs: Array, spacing: float) -> list[Node]:
        corners = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
        around = (np.floor(stubs / spacing)[:, None] + corners).reshape(-1, 3)
        free = self.clear(np.repeat(stubs, 8, axis=0), spacing * around)
        return list({tuple(node) for node in around[free].tolist()})


def clear_of(piece: ConvexPiece, a: Array, b: Array, least: float) -> BoolArray:
    """Return which stretches from ``a`` to ``b`` (n, 3) keep ``least`` from a piece, (n,)."""
    clear = np.zeros(len(a), dtype=bool)
    blocked = np.zeros(len(a), dtype=bool)
    rows, low, high = np.arange(len(a)), a, b
    for _ in range(HALVINGS):
        over = [p @ piece.face_normals.T - piece.face_offsets for p in (low, high)]
        sure = np.minimum(*over).max(axis=1, initial=-np.inf) >= least
        rows, low, high = rows[~sure], low[~sure], high[~sure]
        if not len(rows):
            break
        middle = (low + high) / 2.0
        ways = middle - piece.nearest_on_edges(middle)
        lengths = np.maximum(np.linalg.norm(ways, axis=1), np.finfo(float).tiny)
        axes = ways / lengths[:, None]
        support = (axes @ piece.vertices.T).max(axis=1)
        gaps = [np.einsum("ij,ij->i", axes, p) - support for p in (low, middle, high)]
        faces = (middle @ piece.face_normals.T - piece.face_offsets).max(axis=1)
        blocked[rows[np.maximum(faces, gaps[1]) < least]] = True
        left = (np.minimum(gaps[0], gaps[2]) < least) & ~blocked[rows]
        rows, low, middle, high = rows[left], low[left], middle[left], high[left]
        rows = np.concatenate([rows, rows])
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    blocked[rows] = True
    clear[~blocked] = True
    return clear


def _clear_of_point(point: Array, a: Array, b: Array, least: float) -> BoolArray:
    span = b - a
    along = np.einsum("ij,ij->i", point - a, span)
    share = np.clip(along / np.maximum((span**2).sum(axis=1), np.finfo(float).tiny), 0.0, 1.0)
    clear: BoolArray = np.linalg.norm(a + share[:, None] * span - point, axis=1) >= least
    return clear
