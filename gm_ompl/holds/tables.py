"""What all sets of placements share along arcs of the object."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.cores import share_out
from gm_ompl.feasibility.geometry import NodeGeometry
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose
from gm_ompl.holds.rows import UNASKED, Tables, settle
from gm_ompl.holds.watch import Stop, never, watched
from gm_ompl.motion.arc import Moment
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.motion.screw import Screw
from gm_ompl.problem import Problem

NODE_BYTES, NUMBERS = 7000.0, 4.5
"""What the object's arcs at a node take, and how many numbers per node, finger and placement are
held beside the lengths of an arc: measured."""

ARCS_AT_ONCE: Final = 5_000_000
"""Arcs settled between two looks at the limits in force, about: some tenths of a second."""

WORTH_A_THREAD: Final = 20_000
"""Sets whose bounds take much longer than it takes to load and to start threads."""


class Frame(NamedTuple):
    """Arcs of the object and how they hang together.

    Attributes:
        poses: (V), of the nodes.
        tail: (A,), where each arc begins.
        arcs: (A), their heads among the nodes.
        order: (A,), as ``Tables`` has it.
        one_pass: likewise.
        goal: (V,), the goal nodes.
    """

    poses: Sequence[Pose]
    tail: IntArray
    arcs: Sequence[GraphArc]
    order: IntArray
    one_pass: bool
    goal: BoolArray


def claim_tables(problem: Problem, nodes: int, where: str) -> None:
    """Raise where the tables of arcs past so many nodes are beyond the memory that may be taken.

    Raises:
        LimitError: with the numbers.
    """
    hand, P = problem.fingers, problem.cost.samples_per_arc
    rows, key = len(hand.placements), "segments" if problem.motion.dimension == 1 else "steps"
    limits.claim(
        nodes * (NODE_BYTES + 8.0 * rows * (P + hand.count * (P + NUMBERS))),
        f"{where} of {nodes:,} nodes with {rows:,} placements",
        f"use a coarser lattice.{key} or fingers.placements.grid",
    )


@final
class ArcTable:
    """The tables of some arcs: geometry is tested at once, all else when it is asked for.

    Args:
        judge: answers about the problem.
        frame: the arcs.
        stop: asked now and then while geometry is tested.

    Attributes:
        tables: without lengths and what follows from them; contact states come as they are asked
            for.
        object_free: whether the object penetrates nothing at any node or arc.

    Raises:
        LimitError: ``stop`` said so.
    """

    def __init__(self, judge: Judge, frame: Frame, stop: Stop = never) -> None:
        self._judge, self.frame = judge, frame
        problem, backend = judge.problem, judge.backend
        claim_tables(problem, len(frame.poses), "the way")
        scale = backend.scale if isinstance(backend, KernelBackend) else 1.0
        head = np.array([arc.head for arc in frame.arcs], dtype=np.int64)
        self._firsts, kind = _kinds(frame.arcs)
        # An arc for each row, and each kind's row.
        rows, like = _rows([frame.arcs[a] for a in self._firsts])
        self._rows = [self._firsts[k] for k in rows]
        self._ends = frame.tail[self._rows], head[self._rows]
        node_free, free = self.tested(judge, stop)
        into = np.argsort(head, kind="stable")
        first = np.searchsorted(head[into], np.arange(len(frame.poses) + 1))
        P = max((arc.parts for arc in frame.arcs), default=problem.cost.samples_per_arc)
        hand = problem.fingers
        self.tables = Tables(
            tail=frame.tail,
            head=head,
            kind=kind,
            like=like,
            order=frame.order,
            one_pass=frame.one_pass,
            into=into,
            first=first,
            states=np.full((len(like), P), UNASKED),
            free=free,
            lengths=np.empty((hand.count, len(hand.placements), 0, P)),
            node_free=node_free,
            goal=frame.goal,
            wanted=np.array([-1 if g is None else g for g in hand.goal], dtype=np.int64),
            ahead=np.empty((0, 0, 0)),
            least=np.empty(0),
            z_min=problem.mechanics.z_min / scale,
            z_floor=problem.z_floor / scale,
            X_stab=problem.cost.stability / scale,
            X_regr=float(problem.cost.regrasp),
        )
        self._middles: dict[int, tuple[Moment, ...]] = {}
        self._rests: dict[int, int] = {}

    def tested(self, judge: Judge, stop: Stop = never) -> tuple[BoolArray, BoolArray]:
        """Return which fingertips are free at each node and along each row's arc.

        It also finds ``object_free``.

        Args:
            judge: of the same object; its hand may be another.
            stop: asked now and then.
        """
        frame, rows = self.frame, self._rows
        nodes = [judge.node(pose) for pose in watched(frame.poses, stop)]
        along = [judge.along(frame.arcs[a].arc) for a in watched(rows, stop)]
        self.object_free = all(place.object_free for place in nodes + along)
        node_free, free = _masks(judge, nodes), _masks(judge, along)
        tail, head = self._ends
        free &= node_free[:, :, tail] & node_free[:, :, head]
        return node_free, free

    def passable(self) -> tuple[BoolArray, BoolArray]:
        """Return where the object alone is free: at each node (V,), along each row's arc."""
        arcs, judge, (tail, head) = self.frame.arcs, self._judge, self._ends
        nodes = np.array([judge.node(pose).object_free for pose in self.frame.poses])
        along = np.array([judge.along(arcs[a].arc).object_free for a in self._rows], dtype=bool)
        return nodes, along & nodes[tail] & nodes[head]

    def lengths(self, centres: Array) -> Array:
        """Return the chords of Eq. (9) of points (m, 3), object frame, as (m, rows, P)."""
        found = np.zeros((len(centres), len(self._rows), self.tables.states.shape[1]))
        for row, a in enumerate(self._rows):
            limits.check()
            arc = self.frame.arcs[a]
            found[:, row, : arc.parts] = arc.lengths(centres)
        return found

    @cached_property
    def measured(self) -> Tables:
        """The tables with the lengths of Eq. (9) for all placements, and bounds by them."""
        judge, radii = self._judge, self._judge.problem.fingers.radius.tolist()
        known = dict[float, Array]()
        for i, radius in enumerate(radii):
            if radius not in known:
                known[radius] = self.lengths(judge.centres(i))
        lengths = np.stack([known[radius] for radius in radii]) if radii else self.tables.lengths
        lengths = np.ascontiguousarray(lengths)
        travel = lengths.sum(axis=3)
        # Each arc by whatever placement is shortest there, for the slowest finger: a plan that
        # regrasps again may change.
        shortest = np.where(self.tables.free, travel, np.inf).min(axis=1, initial=np.inf)
        least = self.ahead(shortest.max(axis=0, initial=0.0))
        if not self.tables.one_pass:  # nearest the goal first: little is settled twice
            order = np.argsort(least[self.tables.head], kind="stable")
            self.tables = self.tables._replace(order=order)
        ahead = self.ahead(np.where(self.tables.free, travel, np.inf))
        return self.tables._replace(lengths=lengths, ahead=ahead, least=least)

    def ahead(self, cost: Array) -> Array:
        """Return (.., V): least cost to a goal node by arcs that cost (.., rows)."""
        ahead = np.empty((*cost.shape[:-1], len(self.tables.goal)))
        many = math.prod(cost.shape[:-1])  # there may be no arc at all
        rows, found = cost.reshape(many, cost.shape[-1]), ahead.reshape(many, ahead.shape[-1])

        def work(part: slice) -> None:
            settle(rows[part], self.tables, found[part])

        at_once = max(1, ARCS_AT_ONCE // max(1, len(self.tables.tail)))
        share_out(work, len(rows), WORTH_A_THREAD, at_once)
        return ahead

    def state(self, arc: int, part: int) -> int:
        """Return the contact state of a segment."""
        kind = int(self.tables.kind[arc])
        known = int(self.tables.states[kind, part])
        if known == UNASKED:
            middles = self._middles.get(kind)
            if middles is None:
                middles = self._middles[kind] = self.frame.arcs[self._firsts[kind]].middles()
            known = self._judge.environment(middles[min(part, len(middles) - 1)])
            self.tables.states[kind, part] = known
        return known

    def ask(self, arc: int) -> int:
        """Find the contact states of an arc; return how many were not known."""
        states = self.tables.states[self.tables.kind[arc]]
        unasked = np.flatnonzero(states == UNASKED).tolist()
        for part in unasked:
            self.state(arc, part)
        return len(unasked)

    def rest_state(self, node: int) -> int:
        """Return the contact state of the object at rest at a node."""
        known = self._rests.get(node)
        if known is None:
            known = self._judge.environment(Moment(self.frame.poses[node]))
            self._rests[node] = known
        return known


def _masks(judge: Judge, places: Sequence[NodeGeometry]) -> BoolArray:
    """Return (n, placements, len(places)): which fingertips are free at each place."""
    hand = judge.problem.fingers
    if not places or not hand.count:
        return np.zeros((hand.count, len(hand.placements), len(places)), dtype=bool)
    masks: BoolArray = np.array([place.free for place in places])
    return np.ascontiguousarray(masks.transpose(1, 2, 0))


def _kinds(arcs: Sequence[GraphArc]) -> tuple[list[int], IntArray]:
    """Return the first arc of each kind, and each arc's kind."""
    firsts: list[int] = []
    known: dict[object, int] = {}
    kinds = np.empty(len(arcs), dtype=np.int64)
    for a, arc in enumerate(arcs):
        kinds[a] = known.setdefault(a if arc.kind is None else ("kind", arc.kind), len(firsts))
        if kinds[a] == len(firsts):
            firsts.append(a)
    return firsts, kinds


def _rows(arcs: Sequence[GraphArc]) -> tuple[list[int], IntArray]:
    """Return an arc for each row, and each arc's row: ways back share it where they can."""
    rows: list[int] = []
    known: dict[object, int] = {}
    like = np.empty(len(arcs), dtype=np.int64)
    for a, arc in enumerate(arcs):
        key = arc.along
        if key is None:  # segments of a screw are equally long, whichever way it is passed
            key = (arc.arc.key, arc.parts) if isinstance(arc.arc, Screw) else a
        row = known.setdefault(key, len(rows))
        if row == len(rows):
            rows.append(a)
        like[a] = row
    return rows, like
