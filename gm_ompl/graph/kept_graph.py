"""Poses, arcs and margins as the search for plans that keep the whole hand asks for them."""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import IntArray
from gm_ompl.contact.lattice import ContactLattice
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.arc_classes import ArcClasses, arcs_leaving
from gm_ompl.graph.closure import firsts_of, lifts
from gm_ompl.graph.floor_bounds import FloorBounds
from gm_ompl.graph.goal_distance import GoalDistance
from gm_ompl.graph.goal_sets import GoalSets
from gm_ompl.graph.kept_bounds import PlanarBounds, turning_axis
from gm_ompl.graph.kept_chords import chords, lines
from gm_ompl.graph.kept_room import ASKS, NO_ROWS, columns_with_room, new_book, no_arcs, no_floor
from gm_ompl.graph.kept_states import begin, expand, learn, rehash
from gm_ompl.graph.kept_tables import (
    ASKED,
    BLOCKED,
    EMPTY,
    FAILED,
    STATES,
    UNKNOWN,
    WANTED,
    BodyPoses,
    KeptArcs,
    KeptSets,
    KeptTables,
    Poses,
    Prices,
)
from gm_ompl.graph.mirror import Orbits
from gm_ompl.graph.potentials import POTENTIALS, PlaneGoal
from gm_ompl.holds.goals import restricted
from gm_ompl.holds.sets import placement_sets
from gm_ompl.motion.free import FreeMotion
from gm_ompl.problem import Placements

MOST_SETS: Final = 1_000_000
"""Sets of placements that are treated at once."""

AT_ONCE: Final = 20_000
"""Sets at the start that are asked about at once."""

SET_BYTES: Final = 1000.0
"""What is held for a set, at first."""

NOWHERE = PlaneGoal(np.zeros(2), np.zeros(2), False, 1.0, 0.0, 0.0, 0.0, 0.0)
"""A target that no potential is asked for."""


START: Final = 0
"""The node at the start."""


class TakenIn(NamedTuple):
    """How many of the lattice's poses, classes of arcs and forms were taken in."""

    poses: int
    kinds: int
    forms: int


@final
class KeptGraph:
    """States of the object with the whole hand in place, made on demand.

    Args:
        judge: of a problem of free motion; its back end is the kernel's.

    Attributes:
        tables: what compiled code goes by; others once they have grown. Poses have the numbers of
            the object's nodes.
        goal_sets: what the goal asks of sets.
        full: whether there is no memory for more states.
    """

    def __init__(self, judge: Judge) -> None:
        problem = judge.problem
        motion, hand = problem.motion, problem.fingers
        assert isinstance(motion, FreeMotion)
        assert isinstance(problem.object_graph, ContactLattice)
        self._judge, self._graph, self._lifts = judge, problem.object_graph, lifts(problem)
        # With a hand each arc is a class of its own: its joints are asked for there.
        self._apart, self._ends = problem.hand is not None, motion.ends
        firsts = firsts_of(hand.shapes)
        self._fingers = list(firsts.values())
        self._classes = ArcClasses(judge, problem.object_graph, self._fingers)
        number = {shape: f for f, shape in enumerate(firsts)}
        self.goal_sets = GoalSets(judge)
        axis = turning_axis(problem)
        self._planar = None if axis is None else PlanarBounds(judge, axis)
        goals = [GoalDistance(motion.goal, judge.centres(i)) for i in self._fingers]
        P, parts, F = len(hand.placements), problem.cost.samples_per_arc, len(firsts)
        shapes = np.array([number[shape] for shape in hand.shapes], dtype=np.int64)
        rows = self._sets()
        S = len(rows)
        target = NOWHERE if self._planar is None else self._planar.target
        flags = np.ones(S, dtype=bool), np.zeros(S, dtype=bool)
        self._asked = np.zeros(S, dtype=bool)  # of which sets at the start it was asked
        kept = np.zeros((S if self._planar else 0, POTENTIALS, 4))
        self._floor = FloorBounds.of(judge, rows) if axis is None and S else None
        self.tables = KeptTables(
            KeptSets(rows, shapes, *flags, kept, target),
            no_floor(S) if self._floor is None else self._floor.table,
            Poses(np.zeros((0, 5)), np.zeros(0, dtype=bool), NO_ROWS, NO_ROWS, NO_ROWS),
            BodyPoses(*self._graph.bodies()), GoalDistance.together(goals),
            no_arcs(F, P, parts),
            new_book(max(1024, 2 * S), 1 << 16),
            Prices(problem.cost.stability, problem.z_floor),
        )  # fmt: skip
        self._taken_in, self.full = TakenIn(0, 0, 0), False
        self._meet()
        self._see(np.array([START]))
        self._orbits = Orbits(problem, rows)
        begin(self._orbits.first, self.tables)

    def _sets(self) -> IntArray:
        """Return the sets (S, n) that start and goal allow."""
        judge, hand = self._judge, self._judge.problem.fingers
        free = judge.node(self._graph.pose(START)).free
        there = zip(free, self.goal_sets.free(), strict=True)
        free = tuple(at_start & at_goal for at_start, at_goal in there)
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
        self.full = not self._has_room(len(new))
        if not self.full:
            begin(new, self.tables)

    def follow(self, which: IntArray, limit: float) -> None:
        """Follow the arcs from states, up to plans of a bound of at most ``limit``."""
        of = self.tables.book.pose[which]
        self._prepare(of)
        poses = self.tables.poses
        most = int((poses.past[of] - poses.first[of]).max(initial=0))
        while len(which):
            self.full = not self._has_room(most)
            if self.full:
                break
            which = which[expand(which, limit, self.tables) :]

    def _prepare(self, of: IntArray) -> None:
        """Make the arcs that leave poses."""
        new = np.unique(of[self.tables.poses.first[of] == EMPTY])
        if len(new):
            self._graph.leave(new.tolist())
            self._meet()
            first, past = self._graph.spans(new)
            leaving, _ = arcs_leaving(self._graph, new)
            self._form(leaving)
            arcs, poses = self.tables.arcs, self.tables.poses
            self._see(arcs.heads[leaving[arcs.stages[arcs.kinds[leaving]] != BLOCKED]])
            poses.first[new], poses.past[new] = first, past

    def sharpen(self, which: IntArray, limit: float) -> IntArray:
        """Find what bounds plans of sets at the start that were not asked for yet.

        Returns:
            The states of ``which`` whose key is still at most ``limit``.
        """
        book, hands = self.tables.book, self.tables.hands
        begun = which[book.pose[which] == START]
        begun = begun[~self._asked[book.hand[begun]]]
        if not len(begun):
            return which
        which = which[~np.isin(which, begun[AT_ONCE:])]  # these have to wait
        begun = begun[:AT_ONCE]
        sets = book.hand[begun]
        may = self.goal_sets.may_end(hands.rows[sets])
        hands.alive[sets[~may]] = False
        asked = np.ones(len(sets), dtype=bool)
        if self._planar is not None:
            hands.potentials[sets[may]] = self._planar.potentials(hands.rows[sets[may]])
            hands.known[sets[may]] = True
        if self._floor is not None:
            bounds = self._floor.settle(sets[may], limit)
            self.tables = self.tables._replace(floor=self._floor.table)
            book.key[begun[may]] = np.maximum(book.key[begun[may]], bounds)
            asked[may] = bounds <= limit  # others are gone on with
            hands.alive[sets[may][bounds == np.inf]] = False
        self._asked[sets] = asked  # last: a limit may be reached before
        return which[book.key[which] <= limit]

    def _has_room(self, coming: int) -> bool:
        """Whether there is room for more states, and for the margins that are asked for."""
        book = self.tables.book
        states, asked = int(book.counts[STATES]), int((book.asks != EMPTY).sum())
        room, slots = len(book.cost), len(book.asks)
        if states + coming <= room and 2 * (asked + ASKS) <= slots:
            return True
        room = room if states + coming <= room else 2 * (states + coming)
        while 2 * (asked + ASKS) > slots:
            slots *= 2
        if not limits.fits(80.0 * room + 16.0 * slots):
            return False
        grown = new_book(room, slots)._replace(new=book.new)  # what is asked for stays so
        for name in ("pose", "hand", "cost", "bound", "key", "parent", "via"):
            getattr(grown, name)[:states] = getattr(book, name)[:states]
        grown.counts[:] = book.counts
        rehash(grown, book.asks, book.margins)
        self.tables = self.tables._replace(book=grown)
        return True

    def _meet(self) -> None:
        """Take in the poses and arcs that the lattice has made."""
        graph, known = self._graph, self._taken_in
        new = np.arange(known.poses, len(graph))
        poses = columns_with_room(self.tables.poses, len(graph))
        poses.places[new, 0], poses.first[new], poses.attitudes[new] = np.nan, EMPTY, EMPTY
        arcs, rows = self.tables.arcs, graph.arcs.rows
        count = len(graph.arcs) if self._apart else len(graph.arcs.kind_arcs)
        fresh = np.arange(known.kinds, count)
        stages, free, states = columns_with_room((arcs.stages, arcs.free, arcs.states), count)
        firsts = fresh if self._apart else np.array(graph.arcs.kind_arcs[known.kinds :], np.int64)
        stages[fresh] = np.where(rows.bare[firsts] & (not self._lifts), BLOCKED, UNKNOWN)
        states[fresh] = -1
        kinds = np.arange(count) if self._apart else rows.kinds
        alike = arcs.lines, arcs.chords, stages, free, states
        arcs, bodies = KeptArcs(rows.heads, rows.forms, kinds, *alike), BodyPoses(*graph.bodies())
        self.tables = self.tables._replace(poses=poses, arcs=arcs, bodies=bodies)
        self._taken_in = TakenIn(len(graph), count, known.forms)

    def _see(self, nodes: IntArray) -> None:
        """Find how far it is from poses to the goal, where that is not known."""
        poses, graph = self.tables.poses, self._graph
        new = np.unique(nodes[np.isnan(poses.places[nodes, 0])])
        R, p = graph.poses(new)
        poses.goal[new] = graph.arrived(new)
        poses.places[new] = 0.0 if self._planar is None else self._planar.places(R, p)
        if self._floor is not None:
            poses.attitudes[new] = self._floor.attitudes(R, p)

    def _form(self, leaving: IntArray) -> None:
        """Find how far fingertips go along arcs."""
        graph, arcs, forms = self._graph, self.tables.arcs, len(self._graph.arcs.form_arcs)
        lined, chorded = columns_with_room((arcs.lines, arcs.chords), forms)
        if forms > self._taken_in.forms:
            chorded[self._taken_in.forms : forms, 0] = np.nan
            self._taken_in = self._taken_in._replace(forms=forms)
        asked = np.unique(arcs.forms[leaving])
        new = asked[np.isnan(chorded[asked, 0])]
        courses = graph.courses(np.array(graph.arcs.form_arcs, np.int64)[new])
        chorded[new] = chords(courses, chorded.shape[1], ends=self._ends)
        lined[new] = lines(courses)
        self.tables = self.tables._replace(arcs=arcs._replace(lines=lined, chords=chorded))

    def answer(self) -> None:
        """Find what was asked for."""
        wanted = np.flatnonzero(self.tables.arcs.stages[: self._taken_in.kinds] == WANTED)
        first = wanted.tolist()
        if not self._apart:
            first = [self._graph.arcs.kind_arcs[kind] for kind in first]
        self._classes.learn(wanted, np.array(first, dtype=np.int64), self.tables.arcs)
        self._decide()

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
            nodes.append(int(book.pose[number]))
            number = int(book.parent[number])
        return nodes[::-1]
