"""What all sets of placements share along arcs of the object."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.cores import share_out
from gm_ompl.feasibility.judge import Judge, NodeGeometry
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose
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

WORTH_A_THREAD: Final = 500
"""Sets whose bounds take longer than it takes to start a thread."""

UNASKED: Final = -1
"""Stands for a contact state that was not asked for yet: nothing bounds z there."""


class Tables(NamedTuple):
    """The tables as compiled code reads them.

    The object's nodes are numbered 0..V - 1, its arcs 0..A - 1, and their kinds 0..K - 1: arcs of
    one kind differ in nothing that concerns the hand. An arc has at most P segments; one that has
    fewer repeats the last one's contact state, with no length.

    Attributes:
        tail: (A,), the node where each arc begins.
        head: (A,), and where it ends.
        kind: (A,), of each arc.
        like: (K,), a kind's row in ``free`` and ``lengths``: an arc and its way back share one.
        order: (A,), the arcs such that costs to the goal settle soon, each arc after those ahead.
        one_pass: whether they settle in one pass, as on a row of nodes.
        into: (A,), the arcs by the nodes where they end.
        first: (V + 1,), where the arcs into each node begin in ``into``.
        states: (K, P), contact states of the segments, UNASKED where no search has come yet.
        free: (n, placements, rows), whether object and fingertip are free along the arc.
        lengths: (n, placements, rows, P), chords |dq_finger i,j| of Eq. (9).
        node_free: (n, placements, V), whether they are free at the nodes.
        goal: (V,), the goal nodes.
        wanted: (n,), the placements required at the goal, -1 for any.
        ahead: (n, placements, V), lower bound on travel to the goal, this finger kept.
        least: (V,), lower bound on travel to the goal with whatever placements.
        z_min: the threshold, over the kernel's unit of force.
        z_floor: what a smaller margin counts as in Eq. (9), likewise.
        X_stab: of Eq. (9), over the kernel's unit of force.
        X_regr: cost of a regrasp.
    """

    tail: IntArray
    head: IntArray
    kind: IntArray
    like: IntArray
    order: IntArray
    one_pass: bool
    into: IntArray
    first: IntArray
    states: IntArray
    free: BoolArray
    lengths: Array
    node_free: BoolArray
    goal: BoolArray
    wanted: IntArray
    ahead: Array
    least: Array
    z_min: float
    z_floor: float
    X_stab: float
    X_regr: float


@compiled
def lower(d: Array, costs: Array, tables: Tables) -> None:
    """Lower d (V,) to the least cost to go, by arcs whose kinds cost this (K,).

    On a row of nodes one pass over the arcs does it. Elsewhere a node whose value has fallen waits
    in a queue to be followed back (Bellman, Ford and Moore's algorithm).
    """
    tail, head, kind = tables.tail, tables.head, tables.kind
    if tables.one_pass:
        for k in range(len(tables.order)):
            a = tables.order[k]
            through = d[head[a]] + costs[kind[a]]
            if through < d[tail[a]]:
                d[tail[a]] = through
        return
    V = len(d)
    queue, waits = np.empty(V, dtype=np.int64), np.zeros(V, dtype=np.bool_)
    front, count = 0, 0
    for c in range(V):
        if d[c] < np.inf:
            queue[count], waits[c] = c, True
            count += 1
    while count > 0:
        c = queue[front]
        front, count, waits[c] = (front + 1) % V, count - 1, False
        for k in range(tables.first[c], tables.first[c + 1]):
            a = tables.into[k]
            t, through = tail[a], d[c] + costs[kind[a]]
            if through < d[t]:
                d[t] = through
                if not waits[t]:
                    queue[(front + count) % V], waits[t] = t, True
                    count += 1


@compiled
def settle(cost: Array, tables: Tables, ahead: Array) -> None:
    """Write the least costs to a goal node (m, V), by arcs whose rows cost this (m, rows)."""
    costs = np.empty(len(tables.like))
    for i in range(cost.shape[0]):
        for k in range(len(costs)):
            costs[k] = cost[i, tables.like[k]]
        for c in range(ahead.shape[1]):
            ahead[i, c] = 0.0 if tables.goal[c] else np.inf
        lower(ahead[i], costs, tables)


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
        nodes = [judge.node(pose) for pose in watched(frame.poses, stop)]
        along = [judge.along(frame.arcs[a].arc) for a in watched(self._rows, stop)]
        self.object_free = all(place.object_free for place in nodes + along)
        node_free, free = self._masks(nodes), self._masks(along)
        free &= node_free[:, :, frame.tail[self._rows]] & node_free[:, :, head[self._rows]]
        into = np.argsort(head, kind="stable")
        first = np.searchsorted(head[into], np.arange(len(nodes) + 1))
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

    def _masks(self, places: Sequence[NodeGeometry]) -> BoolArray:
        """Return (n, placements, len(places)): which fingertips are free at each place."""
        hand = self._judge.problem.fingers
        if not places or not hand.count:
            return np.zeros((hand.count, len(hand.placements), len(places)), dtype=bool)
        masks: BoolArray = np.array([place.free for place in places])
        return np.ascontiguousarray(masks.transpose(1, 2, 0))

    @cached_property
    def measured(self) -> Tables:
        """The tables with the lengths of Eq. (9) for all placements, and bounds by them."""
        judge, radii = self._judge, self._judge.problem.fingers.radius.tolist()
        P, known = self.tables.states.shape[1], dict[float, Array]()
        for i, radius in enumerate(radii):
            if radius not in known:
                centres = judge.centres(i)
                known[radius] = np.zeros((len(centres), len(self._rows), P))
                for row, a in enumerate(self._rows):
                    limits.check()
                    arc = self.frame.arcs[a]
                    known[radius][:, row, : arc.parts] = arc.lengths(centres)
        lengths = np.stack([known[radius] for radius in radii]) if radii else self.tables.lengths
        lengths = np.ascontiguousarray(lengths)
        travel = lengths.sum(axis=3)
        # Each arc by whatever placement is shortest there, for the slowest finger: a plan that
        # regrasps again may change.
        shortest = np.where(self.tables.free, travel, np.inf).min(axis=1, initial=np.inf)
        least = self._ahead(shortest.max(axis=0, initial=0.0))
        if not self.tables.one_pass:  # nearest the goal first: little is settled twice
            order = np.argsort(least[self.tables.head], kind="stable")
            self.tables = self.tables._replace(order=order)
        ahead = self._ahead(np.where(self.tables.free, travel, np.inf))
        return self.tables._replace(lengths=lengths, ahead=ahead, least=least)

    def _ahead(self, cost: Array) -> Array:
        """Return (.., V): least cost to a goal node by arcs that cost (.., rows)."""
        ahead = np.empty((*cost.shape[:-1], len(self.tables.goal)))
        rows, found = cost.reshape(-1, cost.shape[-1]), ahead.reshape(-1, ahead.shape[-1])

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
        # Segments of a screw are equally long, whichever way it is passed.
        key = (arc.arc.key, arc.parts) if isinstance(arc.arc, Screw) else a
        row = known.setdefault(key, len(rows))
        if row == len(rows):
            rows.append(a)
        like[a] = row
    return rows, like
