"""States of plans that regrasp once, made on demand.

A finger is lifted where the others hold the object at rest, and put down elsewhere: through hubs,
sets with a finger in the air. So all fingers but one stay from the start to the end; what these
must travel at least bounds what follows.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import BoolArray, IntArray, with_room
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.kept_arcs import START
from gm_ompl.graph.kept_bounds import PlanarBounds
from gm_ompl.graph.kept_graph import MOST_SETS, NOWHERE, SET_BYTES, KeptGraph
from gm_ompl.graph.kept_room import ASKS, new_book, no_floor
from gm_ompl.graph.kept_states import begin, put_down, renew
from gm_ompl.graph.kept_tables import EMPTY, SAME, STATES, KeptSets
from gm_ompl.graph.mirror import Orbits
from gm_ompl.graph.relaxed import RelaxedSets
from gm_ompl.graph.state_graph import StateGraph
from gm_ompl.holds.extraction import Leg, shared_hub
from gm_ompl.holds.goals import restricted
from gm_ompl.holds.sets import LIFTED, PlacementSets, placement_sets, staying_of

LAST: Final = np.iinfo(np.int64).max
"""Stands for a lifted finger while sets are put in order."""


@final
class RegraspGraph(StateGraph):
    """States of plans that regrasp once.

    Args:
        judge: of a problem of free motion of two fingers or more that turns about one axis alone;
            its back end is the kernel's.
        kept: states of plans that do not regrasp.
        planar: its potentials.
    """

    slack = 0.01, 0.01  # relaxed sets are followed as far

    def __init__(self, judge: Judge, kept: KeptGraph, planar: PlanarBounds) -> None:
        problem = judge.problem
        hand, nodes = problem.fingers, problem.object_graph
        self._nodes, self._goal_sets = nodes, kept.goal_sets
        self._sets = PlacementSets(hand.groups())
        start = restricted(judge.node(nodes.pose(START)).free, hand.start)
        self._allowed = restricted(kept.goal_sets.free(), hand.goal)
        first = placement_sets(hand.groups(), start, judge.clear, MOST_SETS)
        few = first is not None and limits.fits(SET_BYTES * len(first))
        rows = first if first is not None and few else np.zeros((0, hand.count), dtype=np.int64)
        hubs, lifts = self._hubs(rows)
        S, H = len(rows), len(hubs)
        self._count = S + H
        may = self._may_stay(hubs)
        alive = np.concatenate([may[lifts].any(axis=1), may])
        lifts = np.concatenate([S + lifts, np.full(hubs.shape, EMPTY)])
        none, unknown = np.zeros((0, 1, 1)), np.zeros(S + H, dtype=bool)
        shapes, every = kept.tables.hands.shapes, np.concatenate([rows, hubs])
        hands = KeptSets(every, shapes, alive, lifts, unknown, none, NOWHERE)
        self._relaxed = RelaxedSets(judge, planar, hubs[may], kept.tables)
        seen, stand = self._relaxed.seen, np.full(S + H, EMPTY)
        stand[S + np.flatnonzero(may)] = seen.rows
        extra = np.concatenate([np.zeros(S), np.full(H, problem.cost.regrasp)])
        tables = kept.tables._replace(
            hands=hands, floor=no_floor(S + H), book=new_book(max(1024, 2 * S), 1 << 16, ASKS),
            relaxed=seen._replace(rows=stand, extra=extra),
        )  # fmt: skip
        super().__init__(judge, kept.object, tables)
        self.paid = problem.cost.regrasp
        self.full = not few
        self._first = S, S + H  # the first hub, and what lies behind the last
        self._exits: dict[int, tuple[IntArray, IntArray]] = {}
        orbits = Orbits(problem, rows).first
        begin(orbits[alive[orbits]], self.tables)

    def _hubs(self, rows: IntArray) -> tuple[IntArray, IntArray]:
        """Return the hubs (H, n) of sets (S, n), and which lifting a finger leads to (S, n)."""
        each = np.repeat(rows[:, None], rows.shape[1], axis=1)
        n = rows.shape[1]
        each[:, np.arange(n), np.arange(n)] = LAST
        flat = self._sets.canonical_rows(each.reshape(-1, n))
        flat[flat == LAST] = LIFTED
        hubs, of = np.unique(flat, axis=0, return_inverse=True)
        return np.ascontiguousarray(hubs), of.reshape(rows.shape)

    def _may_stay(self, hubs: IntArray) -> BoolArray:
        """Return of which hubs (H,) the fingers that touch may be where they are at the goal."""
        may = np.ones(len(hubs), dtype=bool)
        for i, allowed in enumerate(self._allowed):
            may &= (hubs[:, i] == LIFTED) | allowed[hubs[:, i]]
        return may

    def reach(self, limit: float) -> bool:
        """See that bounds tell of plans up to ``limit``; whether they rose, or there is no room."""
        relaxed, paid = self.tables.relaxed, self.paid
        if relaxed.reached > limit:
            return False
        self.full |= not self._relaxed.reach(limit * (1.0 + SAME) - paid, self.object)
        seen = self._relaxed.seen
        if relaxed.after is seen.after:
            return True  # that takes some steps
        relaxed = relaxed._replace(
            book=seen.book, after=seen.after, reached=seen.reached + paid
        )  # fmt: skip
        self.tables = self.tables._replace(relaxed=relaxed)
        self._take_in()
        renew(self.open, self.tables)
        return True

    def follow(self, which: IntArray, limit: float) -> None:
        """Follow what leads on from states, up to plans of a bound of at most ``limit``."""
        hands = self.tables.book.hand[which]
        hubs = (hands >= self._first[0]) & (hands < self._first[1])
        self._expand(which[~hubs], limit)
        for number in which[hubs].tolist():
            self._put_down(number)
        self.object.learn()
        self.object.rest()
        self._decide()

    def _put_down(self, number: int) -> None:
        """Let the lifted finger of a hub's state touch again, wherever it is free."""
        book = self.tables.book
        pose, hub = int(book.pose[number]), int(book.hand[number])
        rows, sets = self._exits_of(hub)
        slot = self.placements(hub).index(LIFTED)
        sets = sets[self._judge.node(self._nodes.pose(pose)).free[slot][rows]]
        if self._has_room(len(sets)):
            put_down(number, sets, self.tables)
            self.tables.book.key[number] = np.inf

    def _exits_of(self, hub: int) -> tuple[IntArray, IntArray]:
        """Return where a hub's lifted finger may be put down to stay, and the sets that makes."""
        if hub not in self._exits:
            placements = self.placements(hub)
            slot = placements.index(LIFTED)
            fits = self._allowed[slot].copy()
            for i, row in staying_of(placements):
                clear = self._judge.clear[slot][i]
                if clear is not None:
                    fits &= clear[:, row]
            rows = np.flatnonzero(fits)
            made = np.repeat(np.array([placements]), len(rows), axis=0)
            made[:, slot] = rows
            made = self._sets.canonical_rows(made)
            may = self._goal_sets.may_end(made)
            self.full |= not limits.fits(SET_BYTES * len(made))
            self._exits[hub] = rows[may], self._add(made[may], hub)
        return self._exits[hub]

    def _add(self, rows: IntArray, hub: int) -> IntArray:
        """Take in sets (m, n) that a hub leads to; return their numbers."""
        hands, relaxed, first = self.tables.hands, self.tables.relaxed, self._count
        self._count += len(rows)
        new, used = np.arange(first, self._count), (first, self._count)
        hands = hands._replace(
            rows=with_room(hands.rows, *used), alive=with_room(hands.alive, *used),
            lifts=with_room(hands.lifts, *used), known=with_room(hands.known, *used),
        )  # fmt: skip
        hands.rows[new], hands.lifts[new] = rows, EMPTY
        hands.alive[new], hands.known[new] = True, False
        stand, extra = with_room(relaxed.rows, *used), with_room(relaxed.extra, *used)
        stand[new], extra[new] = relaxed.rows[hub], 0.0
        relaxed = relaxed._replace(rows=stand, extra=extra)
        self.tables = self.tables._replace(hands=hands, relaxed=relaxed)
        return new

    def arrived(self) -> IntArray:
        """Return the states that plans may end with."""
        book, goal = self.tables.book, self.tables.poses.goal
        states = slice(0, int(book.counts[STATES]))
        return np.flatnonzero(goal[book.pose[states]] & (book.hand[states] >= self._first[1]))

    def stands(self, number: int) -> bool:
        """Whether fingers get through the air where the way to a state asks for it.

        Where they do not, it is not known what else would do for as much.
        """
        reach, fingers = self._judge.reach, self._judge.problem.fingers
        nodes, ((first, _, at), (last, _, _)) = self.legs(number)
        hub = shared_hub(self._sets, first, last)
        slot, staying = hub.index(LIFTED), staying_of(hub)
        group = next(g for g in fingers.groups() if slot in g)
        stay = {hub[i] for i in group}
        a, b = (next(p[i] for i in group if p[i] not in stay) for p in (first, last))
        begin, regrasp, end = (self._nodes.pose(nodes[k]) for k in (0, at, -1))
        stands = (
            reach.landing(begin, first, fingers.standing) is not None
            and reach.joined(regrasp, slot, staying, a, b)
            and (not fingers.leave or reach.landing(end, last) is not None)
        )
        if not stands:
            self.doubt = min(self.doubt, float(self.tables.book.cost[number]))
        return stands

    def legs(self, number: int) -> tuple[list[int], list[Leg]]:
        """Return the nodes on the way to a state, and the sets of placements."""
        states, book = self.way(number), self.tables.book
        hands = book.hand[states]
        hub = int(np.flatnonzero((hands >= self._first[0]) & (hands < self._first[1]))[0])
        nodes = [int(n) for n in book.pose[states[:hub] + states[hub + 2 :]]]
        first, last = self.placements(int(hands[0])), self.placements(int(hands[-1]))
        return nodes, [(first, 0, hub - 1), (last, hub - 1, len(nodes) - 1)]
