"""What fingers that stay to the end must travel at least, where no margin is asked for.

Where the object turns about one axis alone, fingertips that the plane across it shows in one place
travel alike. So few sets stand for all; one is free where any of those is that it stands for. Ways
are followed from the start, and what is left to travel from a state is found backwards over these;
ways that were not followed cost more than what was reached.
"""

from __future__ import annotations

from typing import final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import IntArray, with_room
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.closure import firsts_of
from gm_ompl.graph.goal_distance import GoalDistance
from gm_ompl.graph.kept_arcs import KeptObject
from gm_ompl.graph.kept_bounds import PlanarBounds
from gm_ompl.graph.kept_room import book_with_room, new_book, no_floor, no_relaxed
from gm_ompl.graph.kept_states import begin, expand, list_steps, settle
from gm_ompl.graph.kept_tables import EMPTY, READY, STATES, KeptSets, KeptTables, Relaxed
from gm_ompl.graph.potentials import POTENTIALS
from gm_ompl.holds.sets import LIFTED
from gm_ompl.motion.free import FreeMotion


@final
class RelaxedSets:
    """The sets that stand for all, and their search.

    Args:
        judge: of the problem.
        planar: its potentials.
        rows: (S, n), hubs: sets with one finger in the air.
        like: tables of the whole hand's.

    Attributes:
        tables: of the search.
        seen: what it says of the sets.
    """

    def __init__(
        self, judge: Judge, planar: PlanarBounds, rows: IntArray, like: KeptTables
    ) -> None:
        problem, shapes = judge.problem, like.hands.shapes
        motion = problem.motion
        assert isinstance(motion, FreeMotion)
        fingers = list(firsts_of(problem.fingers.shapes).values())
        every = [
            np.unique(planar.sites[i], return_index=True, return_inverse=True) for i in fingers
        ]
        self._of = np.stack([of for _, _, of in every])
        most = max(len(first) for _, first, _ in every)
        goals = [
            GoalDistance(motion.goal, judge.centres(i)[np.resize(first, most)])
            for i, (_, first, _) in zip(fingers, every, strict=True)
        ]
        own = np.where(rows == LIFTED, LIFTED, self._of[shapes, rows])
        for group in problem.fingers.groups():
            own[:, list(group)] = np.sort(own[:, list(group)], axis=1)
        own, first, of = np.unique(own, axis=0, return_index=True, return_inverse=True)
        R, yes = len(own), np.ones(len(own), dtype=bool)
        found = np.zeros((R, POTENTIALS, 4))
        for i in range(rows.shape[1]):
            some = np.flatnonzero(rows[first, i] == LIFTED)
            others = np.delete(np.arange(rows.shape[1]), i)
            found[some] = planar.potentials(rows[first[some]][:, others], others)
        stay = np.full(own.shape, EMPTY)
        sets = KeptSets(np.ascontiguousarray(own), shapes, yes, stay, yes, found, planar.target)
        self._free = np.zeros((0, len(fingers), most), dtype=bool)
        self._projected = np.zeros(0, dtype=bool)
        self._states = np.zeros((0, like.arcs.states.shape[1]), dtype=np.int64)
        self.tables = like._replace(
            hands=sets, floor=no_floor(R), goal=GoalDistance.together(goals),
            book=new_book(max(1024, 2 * R), 1, 0), relaxed=no_relaxed(R),
        )  # fmt: skip
        begin(np.arange(R), self.tables)
        self._left, self._steps = np.zeros(0), 0
        self._followed = list[IntArray]()  # whose steps are to be listed: a limit may come before
        self._ends, self._costs = np.zeros((0, 2), dtype=np.int64), np.zeros(0)
        self.seen = Relaxed(of.reshape(-1), np.zeros(R), self.tables.book, self._left, 0.0)

    def reach(self, limit: float, own: KeptObject) -> bool:
        """Follow some ways of at most ``limit``, or see what all of them tell.

        Returns:
            Whether there is room for that.

        Raises:
            LimitError: a limit in force is reached.
        """
        self._take_in(own)  # others may have learnt since
        if len(which := self._open(limit)):
            return self._follow(which, limit, own)
        if self._followed:
            if not self._list(np.unique(np.concatenate(self._followed))):
                return False
            self._followed.clear()
        self._settle(limit)
        return True

    def _follow(self, which: IntArray, limit: float, own: KeptObject) -> bool:
        """Follow the arcs from states; whether there is room for that."""
        limits.check()
        self._followed.append(which)
        of = self.tables.book.pose[which]
        own.prepare(of)
        self._take_in(own)
        poses, n = self.tables.poses, self.tables.hands.rows.shape[1]
        most = int((poses.past[of] - poses.first[of]).max()) + n
        while len(which):
            book = book_with_room(self.tables.book, most)
            if book is None:
                return False
            self.tables = self.tables._replace(book=book)
            which = which[expand(which, limit, self.tables) :]
        own.learn()
        self._take_in(own)
        return True

    def _open(self, limit: float) -> IntArray:
        book = self.tables.book
        return np.flatnonzero(book.key[: book.counts[STATES]] <= limit)

    def _take_in(self, own: KeptObject) -> None:
        """Go by what the object has become; no margin is asked for."""
        arcs, kinds = own.arcs, own.kinds
        if kinds > len(self._projected):
            count = len(self._projected)
            self._free = with_room(self._free, count, len(arcs.stages))
            self._projected = with_room(self._projected, count, len(arcs.stages), 0)
        new = np.flatnonzero(~self._projected[:kinds] & (arcs.stages[:kinds] == READY))
        for f, of in enumerate(self._of):
            order = np.argsort(of, kind="stable")
            first = np.flatnonzero(np.diff(of[order], prepend=-1))
            free = np.logical_or.reduceat(arcs.free[new, f][:, order], first, axis=1)
            self._free[new, f, : len(first)] = free
        self._projected[new] = True
        self._states = with_room(self._states, 0, len(arcs.states), -1)
        arcs = arcs._replace(free=self._free, states=self._states)
        self.tables = self.tables._replace(poses=own.poses, bodies=own.bodies, arcs=arcs)

    def _list(self, which: IntArray) -> bool:
        """Take note of the steps from states; whether there is room for that."""
        poses, of = self.tables.poses, self.tables.book.pose[which]
        most = int((poses.past[of] - poses.first[of]).sum())
        if self._steps + most > len(self._costs) and not limits.fits(48.0 * (self._steps + most)):
            return False
        self._ends = with_room(self._ends, self._steps, self._steps + most)
        self._costs = with_room(self._costs, self._steps, self._steps + most)
        room = self._ends[self._steps :], self._costs[self._steps :]
        self._steps += list_steps(which, self.tables, *room)
        return True

    def _settle(self, limit: float) -> None:
        """Find what follows each state at least."""
        book, poses = self.tables.book, self.tables.poses
        states = int(book.counts[STATES])
        left = np.full(states, np.inf)
        left[: len(self._left)] = self._left
        left[poses.goal[book.pose[:states]]] = 0.0
        settle(self._ends[: self._steps], self._costs[: self._steps], left)
        reached = max(limit, float(book.key[:states].min(initial=np.inf)))
        after = np.maximum(np.minimum(left, reached - book.cost[:states]), book.bound[:states])
        self._left, self.seen = left, self.seen._replace(book=book, after=after, reached=reached)
