"""Lower bounds on plans that keep the whole hand in place, for free motion on an open floor.

They are asked for set by set, and mode decisions with them: those on the cheapest sequence of
rotations that may lead to the goal's attitude, until all of them hold.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.cores import share_out
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.closure import firsts_of
from gm_ompl.graph.floor_graph import FloorGraph, floor_graph, looks, nearest, on_open_floor
from gm_ompl.graph.floor_values import SLIP, FloorArcs, FloorSets, evaluate, undecided
from gm_ompl.graph.kept_chords import chords, lines
from gm_ompl.graph.kept_tables import FAILED, FloorTable, Prices
from gm_ompl.motion.free import FreeMotion

AT_ONCE: Final = 512
"""Sets asked about between two looks at the limits, at most."""

STEPS: Final = 1 << 22
"""Sets times arcs likewise."""

A_FEW: Final = 8
"""Contact states of a set that are decided at once."""

MOST: Final = 512
"""Contact states on a way that are taken note of."""

LESS: Final = 1e-6
"""Contact states that count as one have the same z but for this, relatively."""

PLACES: Final = 1e9
"""Columns that differ by no more than one over this are one."""


@final
class FloorBounds:
    """What the sets of a hand must pay at least.

    Args:
        judge: of the problem; its back end is the kernel's.
        graph: of the problem.
        rows: (S, n), all sets.

    Attributes:
        table: what is left to pay, of sets that ``settle`` found it for.
    """

    def __init__(self, judge: Judge, graph: FloorGraph, rows: IntArray) -> None:
        problem, hand, backend = judge.problem, judge.problem.fingers, judge.backend
        motion = problem.motion
        assert isinstance(motion, FreeMotion) and isinstance(backend, KernelBackend)
        self._judge, self._backend, self._rows = judge, backend, rows
        self._graph, self._D = graph, problem.body.diagonal
        firsts = firsts_of(hand.shapes)
        number = {shape: f for f, shape in enumerate(firsts)}
        self._shapes = np.array([number[shape] for shape in hand.shapes], dtype=np.int64)
        self._tips = np.stack([judge.centres(i) for i in firsts.values()])
        self._prices = Prices(problem.cost.stability, problem.z_floor, problem.cost.regrasp)
        self._z_min = problem.mechanics.z_min * (1.0 - LESS)
        self._arcs, self._states = self._learn(list(firsts.values()))
        self._ends = graph.looks[:, :9].reshape(-1, 3, 3).copy()
        self._ends[~graph.arrived] = np.nan
        self._failed = np.tile([1.0, 2.0], (len(self._states), 1))  # of contact states, and asked
        self._margins: dict[int, tuple[IntArray, Array]] = {}  # what is known of sets
        goal = motion.goal
        # Attitudes that arrive stand for others near them.
        slack = goal.distance + float(np.linalg.norm(goal.high - goal.low)) / 2.0 + SLIP * self._D
        none = np.zeros((0, 3)), np.zeros((0, 2)), np.zeros((0, len(graph.looks)))
        middle = (goal.low[:2] + goal.high[:2]) / 2.0
        self.table = FloorTable(np.full(len(rows), -1), *none, middle, slack)

    @classmethod
    def of(cls, judge: Judge, rows: IntArray) -> FloorBounds | None:
        """Return those of a problem, or None where it has none.

        Raises:
            LimitError: a limit in force is reached.
        """
        graph = floor_graph(judge.problem) if on_open_floor(judge.problem) else None
        return None if graph is None or not graph.arrived.any() else cls(judge, graph, rows)

    def attitudes(self, rotations: Array, positions: Array) -> IntArray:
        """Return the numbers of poses' attitudes (N,); -1 where they are not in the graph."""
        return nearest(self._graph.looks, looks(rotations, positions, self._D))

    def _learn(self, fingers: list[int]) -> tuple[FloorArcs, IntArray]:
        """Return the arcs that the object passes, and their contact states by their numbers."""
        graph, problem = self._graph, self._judge.problem
        passes, free = self._judge.passing_along(graph.courses)
        states = self._backend.along(graph.courses)
        # What compiled code does not tell is not asked about, and costs nothing here.
        alike, first = self._alike(np.unique(states[states >= 0]))
        numbers = np.where(states >= 0, alike[states], -1)
        kept = np.flatnonzero(passes)[np.argsort(self._hops()[graph.heads[passes]], kind="stable")]
        courses = graph.courses.some(kept)
        spun = courses.ends_rotations - courses.rotations
        moved = courses.ends_positions - courses.positions
        shifts = np.concatenate([spun[:, :2], moved[:, :2, None]], axis=2)
        parts = problem.cost.samples_per_arc
        motion = problem.motion
        assert isinstance(motion, FreeMotion)
        arcs = FloorArcs(
            graph.tails[kept], graph.heads[kept], lines(courses),
            chords(courses, parts, ends=motion.ends)[:, : numbers.shape[1]], numbers[kept],
            np.ascontiguousarray(free[kept][:, fingers]), shifts, SLIP * self._D,
        )  # fmt: skip
        return arcs, first

    def _hops(self) -> IntArray:
        """Return how many arcs it is from attitudes to the goal (A,)."""
        hops = np.where(self._graph.arrived, 0, len(self._graph.looks))
        before = np.zeros(0, dtype=np.int64)
        while not np.array_equal(hops, before):
            before = hops.copy()
            np.minimum.at(hops, self._graph.tails, before[self._graph.heads] + 1)
        return hops

    def _alike(self, states: IntArray) -> tuple[IntArray, IntArray]:
        """Return a number for each contact state, the same for those with the same columns.

        Turned about the vertical by the angle between edges of the friction cones, a pose has the
        same columns again. The second result is one state of each number.
        """
        known: dict[bytes, int] = {}
        numbers, first = np.full(int(states.max(initial=0)) + 1, -1), list[int]()
        for state in states.tolist():
            env, load, _, _ = self._backend.columns(state)
            columns = np.rint(np.vstack([load, env]) * PLACES) + 0.0
            columns[1:] = columns[1:][np.lexsort(columns[1:].T)]
            key = columns.tobytes()
            if key not in known:
                known[key] = len(first)
                first.append(state)
            numbers[state] = known[key]
        return numbers, np.array(first, dtype=np.int64)

    def settle(self, which: IntArray, limit: float) -> Array:
        """Return lower bounds (L,) on plans of sets, by their numbers.

        Those of at most ``limit`` are in ``table`` after that, where memory does for them.

        Raises:
            LimitError: a limit in force is reached.
        """
        found, few = np.empty(len(which)), STEPS // (len(self._arcs.tails) + 1)
        some = max(1, min(AT_ONCE, few))
        for first in range(0, len(which), some):
            limits.check()
            part = slice(first, first + some)
            found[part] = self._settle(which[part], limit)
        return found

    def _settle(self, which: IntArray, limit: float) -> Array:
        L, A = len(which), len(self._graph.looks)
        asked = self._asked(which)
        bounds, open_ = np.zeros(L), np.arange(L)
        values, via = np.empty((L, A)), np.empty((L, A), dtype=np.int64)
        while len(open_):
            limits.check()
            self._evaluate(asked, open_, values, via)
            bounds[open_] = self._ahead(asked, open_, values)
            open_ = open_[bounds[open_] <= limit]
            ways = [self._undecided(via[one], asked.margins[one]) for one in open_.tolist()]
            some = np.array([len(way) > 0 for way in ways], dtype=bool)
            self._keep(which, open_[~some], asked, values)
            open_ = open_[some]
            self._ask(asked, open_, [way for way in ways if len(way)])
        for one in np.flatnonzero(bounds < np.inf).tolist():
            known = np.flatnonzero(asked.margins[one] < np.inf)
            self._margins[int(which[one])] = known, asked.margins[one, known]
        return bounds

    def _asked(self, which: IntArray) -> FloorSets:
        rows, margins = self._rows[which], np.full((len(which), len(self._states)), np.inf)
        for row, one in zip(margins, which.tolist(), strict=True):
            known, zs = self._margins.get(one, (slice(0), 0.0))
            row[known] = zs
        tips = np.stack([self._tips[f, rows[:, i]] for i, f in enumerate(self._shapes)], axis=1)
        points, looks = tips.mean(axis=1), self._graph.looks[0]
        start = self._judge.problem.object_graph.pose(self._judge.problem.object_graph.start)
        end = self._ends[self._graph.arrived]
        there = (points @ end.mean(axis=0).T)[:, :2] + self.table.goal
        ways = there - start.position[:2] - (points @ looks[:9].reshape(3, 3).T)[:, :2]
        ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-300)
        return FloorSets(rows, self._shapes, self._tips, margins, points, ways)

    def _evaluate(self, asked: FloorSets, which: IntArray, values: Array, via: IntArray) -> None:
        def work(part: slice) -> None:
            some = which[part]
            own = asked._replace(
                rows=asked.rows[some], margins=asked.margins[some],
                points=asked.points[some], ways=asked.ways[some],
            )  # fmt: skip
            left, by, costs = values[some], via[some], np.empty(len(self._arcs.tails))
            evaluate(own, self._arcs, self._prices, self._ends, costs, left, by)
            values[some], via[some] = left, by

        share_out(work, len(which))

    def _ahead(self, asked: FloorSets, which: IntArray, values: Array) -> Array:
        """Return what plans of sets cost at least."""
        motion, table = self._judge.problem.motion, self.table
        assert isinstance(motion, FreeMotion)
        here = motion.start.apply(asked.points[which])[:, :2]
        gone = (asked.ways[which] * (table.goal - here)).sum(axis=1)
        bounds: Array = gone - table.slack + values[which, 0]
        return bounds

    def _undecided(self, via: IntArray, margins: Array) -> IntArray:
        found = np.empty(MOST, dtype=np.int64)
        return found[: undecided(via, 0, margins, self._arcs, found)]

    def _ask(self, asked: FloorSets, which: IntArray, ways: list[IntArray]) -> None:
        """Decide what is not known on sets' ways, each up to where one does not hold."""
        left = dict(zip(which.tolist(), ways, strict=True))
        while left:
            limits.check()
            ratio = self._failed[:, 0] / self._failed[:, 1]
            for one, way in left.items():
                left[one] = way[np.argsort(-ratio[way], kind="stable")]
            pairs = np.array([(one, s) for one, way in left.items() for s in way[:A_FEW].tolist()])
            ones, states = pairs.T
            zs = self._backend.margins(self._states[states], asked.rows[ones], self._z_min)
            fails = zs < self._z_min
            asked.margins[ones, states] = np.where(fails, FAILED, zs)
            np.add.at(self._failed, states, np.column_stack([fails, np.ones(len(fails))]))
            lost = set(ones[fails].tolist())
            left = {o: w[A_FEW:] for o, w in left.items() if o not in lost and len(w) > A_FEW}

    def _keep(self, which: IntArray, settled: IntArray, asked: FloorSets, values: Array) -> None:
        """Note what is left to pay of sets that hold all along their way."""
        table, new = self.table, which[settled]
        if not limits.fits(8.0 * (len(table.values) + len(new)) * table.values.shape[1]):
            return  # what bounds them at the start must do
        table.rows[new] = len(table.values) + np.arange(len(new))
        self.table = table._replace(
            points=np.concatenate([table.points, asked.points[settled]]),
            ways=np.concatenate([table.ways, asked.ways[settled]]),
            values=np.concatenate([table.values, values[settled]]),
        )
