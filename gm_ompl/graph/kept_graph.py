"""Poses, arcs and margins as the search for plans that keep the whole hand asks for them."""

from __future__ import annotations

from typing import Any, Final, TypeVar, cast, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.closure import firsts_of, lifts
from gm_ompl.graph.goal_distance import GoalDistance
from gm_ompl.graph.kept_bounds import PlanarBounds, turning_axis
from gm_ompl.graph.kept_states import begin, learn, rehash
from gm_ompl.graph.kept_tables import (
    ASKED,
    BLOCKED,
    EMPTY,
    FAILED,
    READY,
    STATES,
    WANTED,
    KeptArcs,
    KeptSets,
    KeptTables,
    Poses,
    Prices,
    StateBook,
)
from gm_ompl.graph.mirror import Orbits
from gm_ompl.graph.potentials import POTENTIALS, PlaneGoal
from gm_ompl.holds.goals import restricted
from gm_ompl.holds.sets import placement_sets
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.problem import Placements

MOST_SETS: Final = 1_000_000
"""Sets of placements that are treated at once."""

SET_BYTES: Final = 1000.0
"""What is held for a set, at first."""

ASKS: Final = 20_000
"""Margins asked for at once."""

Columns = TypeVar("Columns", bound=tuple[np.ndarray[Any, Any], ...])

NOWHERE = PlaneGoal(np.zeros(2), np.zeros(2), False, 0.0, 0.0, 0.0)
"""A target that no potential is asked for."""


@final
class KeptGraph:
    """States of the object with the whole hand in place, made on demand.

    Args:
        judge: of a problem of free motion; its back end is the kernel's.

    Attributes:
        tables: what compiled code goes by; others once they have grown.
        met: the object's nodes, by the numbers of their poses here.
    """

    def __init__(self, judge: Judge) -> None:
        problem = judge.problem
        motion, hand = problem.motion, problem.fingers
        assert isinstance(motion, FreeMotion)
        self._judge, self._graph, self._lifts = judge, problem.object_graph, lifts(problem)
        firsts = firsts_of(hand.shapes)
        self._fingers = list(firsts.values())
        number = {shape: f for f, shape in enumerate(firsts)}
        axis = turning_axis(problem)
        self._planar = None if axis is None else PlanarBounds(judge, axis)
        self._goals = [GoalDistance(motion.goal, judge.centres(i)) for i in self._fingers]
        self._numbers, self.met = dict[int, int](), list[int]()
        self._steps = list[GraphArc]()
        self._forms, self._kinds = dict[object, int](), dict[object, int]()
        self._of_kind = list[GraphArc]()
        P, parts, F = len(hand.placements), problem.cost.samples_per_arc, len(firsts)
        shapes = np.array([number[shape] for shape in hand.shapes], dtype=np.int64)
        rows = self._sets()
        S = len(rows)
        target = NOWHERE if self._planar is None else self._planar.target
        flags = np.ones(S, dtype=bool), np.zeros(S, dtype=bool)
        kept = np.zeros((S if self._planar else 0, POTENTIALS, 4))
        self.tables = KeptTables(
            KeptSets(rows, shapes, *flags, kept, target),
            Poses(
                np.zeros((1, 3)), np.zeros((1, F, P)), np.zeros(1, dtype=bool),
                np.zeros(1, np.int64), np.zeros(1, np.int64),
            ),
            KeptArcs(
                np.zeros(1, np.int64), np.zeros(1, np.int64), np.zeros(1, np.int64),
                np.zeros((1, F, P, parts)), np.zeros(1, np.int64),
                np.zeros((1, F, P), dtype=bool), np.full((1, parts), -1),
            ),
            _new_book(max(1024, 2 * S), 1 << 16),
            Prices(problem.cost.stability, problem.z_floor, np.empty(parts)),
        )  # fmt: skip
        self._met(self._graph.start)
        self._orbits = Orbits(problem, rows)
        begin(self._orbits.first, self.tables)

    def _sets(self) -> IntArray:
        """Return the sets (S, n) that start and goal allow."""
        judge, hand = self._judge, self._judge.problem.fingers
        free = judge.node(self._graph.pose(self._graph.start)).free
        allowed = restricted(restricted(free, hand.start), hand.goal)
        found = placement_sets(hand.groups(), allowed, judge.clear, MOST_SETS)
        if found is None or not limits.fits(SET_BYTES * len(found)):
            return np.zeros((0, hand.count), dtype=np.int64)
        return found

    @property
    def open(self) -> IntArray:
        """The states that are open."""
        book = self.tables.book
        return np.flatnonzero(book.key[: book.counts[STATES]] < np.inf)

    def placements(self, hand: int) -> Placements:
        """Return a set of placements."""
        return tuple(self.tables.hands.rows[hand].tolist())

    def open_images(self, hand: int) -> None:
        """Open a set's mirror images at the start: it does not stand for them after all."""
        new = self._orbits.take(hand)
        self._make_room(len(new))
        begin(new, self.tables)

    def prepare(self, which: IntArray) -> None:
        """Make what following the arcs from states takes: their poses' arcs, and room."""
        book = self.tables.book
        for pose in np.unique(book.pose[which]).tolist():
            if self.tables.poses.first[pose] == EMPTY:
                self._leave(pose)
        poses = self.tables.poses
        of = book.pose[which]
        coming = int((poses.past[of] - poses.first[of]).sum())
        self._make_room(coming)

    def sharpen(self, which: IntArray) -> None:
        """Find the potentials of sets at the start that have none yet."""
        book, hands = self.tables.book, self.tables.hands
        new = which[(book.pose[which] == 0) & ~hands.known[book.hand[which]]]
        if self._planar is None or not len(new):
            return
        sets = book.hand[new]
        hands.potentials[sets] = self._planar.potentials(hands.rows[sets])
        hands.known[sets] = True

    def _make_room(self, coming: int) -> None:
        book = self.tables.book
        states, asked = int(book.counts[STATES]), int((book.asks != EMPTY).sum())
        room, slots = len(book.cost), len(book.asks)
        if states + coming <= room and 2 * (asked + ASKS) <= slots:
            return
        room = room if states + coming <= room else 2 * (states + coming)
        while 2 * (asked + ASKS) > slots:
            slots *= 2
        limits.claim(
            80.0 * room + 16.0 * slots, f"{states:,} states", "use fewer fingers.placements"
        )
        grown = _new_book(room, slots)
        for name in ("pose", "hand", "cost", "bound", "key", "parent", "via"):
            getattr(grown, name)[:states] = getattr(book, name)[:states]
        grown.counts[:] = book.counts
        rehash(grown, book.asks, book.margins)
        self.tables = self.tables._replace(book=grown)

    def _met(self, node: int) -> int:
        """Return the number of a node's pose."""
        known = self._numbers.get(node)
        if known is not None:
            return known
        number = self._numbers[node] = len(self.met)
        self.met.append(node)
        pose, poses = self._graph.pose(node), _with_room(self.tables.poses, number)
        if self._planar is not None:
            poses.places[number] = self._planar.place(pose)
        poses.onward[number] = [goal.distances(pose) for goal in self._goals]
        poses.goal[number] = self._graph.in_goal(node)
        poses.first[number] = EMPTY
        if poses is not self.tables.poses:
            self.tables = self.tables._replace(poses=poses)
        return number

    def _leave(self, pose: int) -> None:
        """Make the arcs that leave a pose."""
        first = len(self._steps)
        for step in self._graph.arcs_from(self.met[pose]):
            if step.bare and not self._lifts:
                continue
            head, arc = self._met(step.head), len(self._steps)
            form, kind = self._form(step), self._kind(step)
            arcs = self.tables.arcs
            heads, forms, kinds = _with_room((arcs.heads, arcs.forms, arcs.kinds), arc)
            heads[arc], forms[arc], kinds[arc] = head, form, kind
            if heads is not arcs.heads:
                grown = arcs._replace(heads=heads, forms=forms, kinds=kinds)
                self.tables = self.tables._replace(arcs=grown)
            self._steps.append(step)
        self.tables.poses.first[pose], self.tables.poses.past[pose] = first, len(self._steps)

    def _form(self, step: GraphArc) -> int:
        """Return an arc's row of lengths."""
        key = ("arc", len(self._steps)) if step.form is None else step.form
        known = self._forms.get(key)
        if known is None:
            known = self._forms[key] = len(self._forms)
            arcs = self.tables.arcs
            (lengths,) = _with_room((arcs.lengths,), known)
            lengths[known] = 0.0
            for f, i in enumerate(self._fingers):
                lengths[known, f, :, : step.parts] = step.lengths(self._judge.centres(i))
            if lengths is not arcs.lengths:
                self.tables = self.tables._replace(arcs=arcs._replace(lengths=lengths))
        return known

    def _kind(self, step: GraphArc) -> int:
        """Return an arc's class."""
        alone = step.kind is None or self._judge.problem.hand is not None
        key = ("arc", len(self._steps)) if alone else step.kind
        known = self._kinds.get(key)
        if known is None:
            known = self._kinds[key] = len(self._kinds)
            self._of_kind.append(step)
            arcs = self.tables.arcs
            stages, free, states = _with_room((arcs.stages, arcs.free, arcs.states), known)
            stages[known], states[known] = 0, -1
            if stages is not arcs.stages:
                grown = arcs._replace(stages=stages, free=free, states=states)
                self.tables = self.tables._replace(arcs=grown)
        return known

    def answer(self) -> None:
        """Find what was asked for."""
        wanted = self.tables.arcs.stages[: len(self._kinds)] == WANTED
        for kind in np.flatnonzero(wanted).tolist():
            self._learn(kind)
        self._decide()

    def _learn(self, kind: int) -> None:
        """Find where fingertips are free along a class of arcs, and its contact states."""
        arcs, step = self.tables.arcs, self._of_kind[kind]
        found = self._judge.passing(step, self._graph.pose(step.head))
        passes = found.object_free and all(free.any() for free in found.free)
        arcs.stages[kind] = READY if passes else BLOCKED
        if not passes:
            return
        for f, i in enumerate(self._fingers):
            arcs.free[kind, f] = found.free[i]
        states = self._judge.environments(step)
        arcs.states[kind, : len(states)] = states

    def _decide(self) -> None:
        """Decide the margins that were asked for."""
        book, backend = self.tables.book, self._judge.backend
        assert isinstance(backend, KernelBackend)
        new, z_min = book.new[: book.counts[ASKED]], self._judge.problem.mechanics.z_min
        if not len(new):
            return
        hands = self.tables.hands
        zs = backend.margins(new[:, 0].copy(), hands.rows[new[:, 1]], z_min)
        learn(book, len(hands.rows), np.where(zs >= z_min, zs, FAILED))

    def way(self, number: int) -> list[int]:
        """Return the object's nodes on the way to a state, from the start."""
        book, nodes = self.tables.book, list[int]()
        while number != EMPTY:
            nodes.append(self.met[int(book.pose[number])])
            number = int(book.parent[number])
        return nodes[::-1]


def _new_book(room: int, slots: int) -> StateBook:
    hashed = 1 << int(2 * room - 1).bit_length()
    numbers, reals = np.zeros((4, room), dtype=np.int64), np.full((3, room), np.inf)
    return StateBook(
        np.full(hashed, EMPTY), numbers[0], numbers[1], reals[0], reals[1], reals[2],
        numbers[2], numbers[3], np.full(slots, EMPTY), np.zeros(slots),
        np.zeros((ASKS, 2), dtype=np.int64), np.zeros(3, dtype=np.int64),
    )  # fmt: skip


def _with_room(columns: Columns, number: int) -> Columns:
    """Return arrays with room for row ``number``: themselves where there is."""
    if number < len(columns[0]):
        return columns
    grown = []
    for column in columns:
        larger = np.empty((max(2 * len(column), number + 1), *column.shape[1:]), column.dtype)
        larger[: len(column)] = column
        grown.append(larger)
    return cast(Columns, Poses(*grown) if isinstance(columns, Poses) else tuple(grown))
