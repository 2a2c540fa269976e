"""Poses, arcs and margins as the search for plans that keep the whole hand asks for them."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.closure import firsts_of
from gm_ompl.graph.floor_bounds import FloorBounds
from gm_ompl.graph.goal_distance import GoalDistance
from gm_ompl.graph.goal_sets import GoalSets
from gm_ompl.graph.kept_arcs import START, KeptObject
from gm_ompl.graph.kept_bounds import PlanarBounds, turning_axis
from gm_ompl.graph.kept_room import ASKS, new_book, no_floor, no_relaxed
from gm_ompl.graph.kept_states import begin
from gm_ompl.graph.kept_tables import EMPTY, STATES, KeptSets, KeptTables, Prices
from gm_ompl.graph.mirror import Orbits
from gm_ompl.graph.potentials import POTENTIALS, PlaneGoal
from gm_ompl.graph.state_graph import StateGraph
from gm_ompl.holds.extraction import Leg
from gm_ompl.holds.goals import restricted
from gm_ompl.holds.sets import placement_sets
from gm_ompl.motion.free import FreeMotion

MOST_SETS: Final = 1_000_000
"""Sets of placements that are treated at once."""

AT_ONCE: Final = 20_000
"""Sets at the start that are asked about at once."""

SET_BYTES: Final = 1000.0
"""What is held for a set, at first."""

NOWHERE = PlaneGoal(np.zeros(2), np.zeros(2), False, 1.0, 0.0, 0.0, 0.0, 0.0)
"""A target that no potential is asked for."""


@final
class KeptGraph(StateGraph):
    """States of the object with the whole hand in place, made on demand.

    Args:
        judge: of a problem of free motion; its back end is the kernel's.

    Attributes:
        planar: potentials, where the object turns about one axis alone.
        goal_sets: what the goal asks of sets.
    """

    def __init__(self, judge: Judge) -> None:
        problem = judge.problem
        motion, hand = problem.motion, problem.fingers
        assert isinstance(motion, FreeMotion)
        self._nodes = problem.object_graph
        self.goal_sets = GoalSets(judge)
        firsts = firsts_of(hand.shapes)
        goals = [GoalDistance(motion.goal, judge.centres(i)) for i in firsts.values()]
        number = {shape: f for f, shape in enumerate(firsts)}
        shapes = np.array([number[shape] for shape in hand.shapes], dtype=np.int64)
        found, axis = self._sets(judge), turning_axis(problem)
        rows = np.zeros((0, hand.count), dtype=np.int64) if found is None else found
        S = len(rows)
        self.planar = None if axis is None else PlanarBounds(judge, axis)
        target = NOWHERE if self.planar is None else self.planar.target
        kept = np.zeros((S if self.planar else 0, POTENTIALS, 4))
        self._floor = FloorBounds.of(judge, rows) if axis is None and S else None
        own = KeptObject(judge, self.planar, self._floor)
        self._asked = np.zeros(S, dtype=bool)  # of which sets at the start it was asked
        alive, lifts, known = np.ones(S, dtype=bool), np.full(rows.shape, EMPTY), np.zeros(S, bool)
        tables = KeptTables(
            KeptSets(rows, shapes, alive, lifts, known, kept, target),
            no_floor(S) if self._floor is None else self._floor.table,
            own.poses, own.bodies, GoalDistance.together(goals), own.arcs,
            new_book(max(1024, 2 * S), 1 << 16, ASKS),
            Prices(problem.cost.stability, problem.z_floor, problem.cost.regrasp),
            no_relaxed(S),
        )  # fmt: skip
        super().__init__(judge, own, tables)
        self.full = found is None
        self._orbits = Orbits(problem, rows)
        begin(self._orbits.first, self.tables)

    def _sets(self, judge: Judge) -> IntArray | None:
        """Return the sets (S, n) that start and goal allow; None where they are too many."""
        hand = judge.problem.fingers
        free = judge.node(self._nodes.pose(START)).free
        there = zip(free, self.goal_sets.free(), strict=True)
        free = tuple(at_start & at_goal for at_start, at_goal in there)
        allowed = restricted(restricted(free, hand.start), hand.goal)
        found = placement_sets(hand.groups(), allowed, judge.clear, MOST_SETS)
        return None if found is None or not limits.fits(SET_BYTES * len(found)) else found

    def arrived(self) -> IntArray:
        """Return the states that plans may end with."""
        book = self.tables.book
        return np.flatnonzero(self.tables.poses.goal[book.pose[: book.counts[STATES]]])

    def stands(self, number: int) -> bool:
        """Whether fingers get to where they are at the start of a way, and off at its end.

        The grids that say so are no mirror images: where they refuse a set, its images are asked.
        """
        alive, book = self.tables.hands.alive, self.tables.book
        hand, problem, reach = int(book.hand[number]), self._judge.problem, self._judge.reach
        if not alive[hand]:
            return False
        placements = self.placements(hand)
        if reach.landing(self._nodes.pose(START), placements, problem.fingers.standing) is None:
            alive[hand] = False
            self._open_images(hand)
            return False
        end = self._nodes.pose(int(book.pose[number]))
        stands = not problem.fingers.leave or reach.landing(end, placements) is not None
        if not stands:
            self._open_images(hand)
        return stands

    def legs(self, number: int) -> tuple[list[int], list[Leg]]:
        """Return the nodes on the way to a state, and its set of placements."""
        book = self.tables.book
        nodes = [int(book.pose[state]) for state in self.way(number)]
        return nodes, [(self.placements(int(book.hand[number])), 0, len(nodes) - 1)]

    def _open_images(self, hand: int) -> None:
        """Open a set's mirror images at the start: it does not stand for them after all."""
        new = self._orbits.take(hand)
        if self._has_room(len(new)):
            begin(new, self.tables)

    def follow(self, which: IntArray, limit: float) -> None:
        """Follow the arcs from states, up to plans of a bound of at most ``limit``."""
        self._expand(self._sharpen(which, limit), limit)
        self.object.learn()
        self._decide()

    def _sharpen(self, which: IntArray, limit: float) -> IntArray:
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
        if self.planar is not None:
            hands.potentials[sets[may]] = self.planar.potentials(hands.rows[sets[may]])
            hands.known[sets[may]] = True
        asked = np.ones(len(sets), dtype=bool)
        if self._floor is not None:
            bounds = self._floor.settle(sets[may], limit)
            self.tables = self.tables._replace(floor=self._floor.table)
            book.key[begun[may]] = np.maximum(book.key[begun[may]], bounds)
            asked[may] = bounds <= limit  # others are gone on with
            hands.alive[sets[may][bounds == np.inf]] = False
        self._asked[sets] = asked  # last: a limit may be reached before
        return which[book.key[which] <= limit]
