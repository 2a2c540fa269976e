"""Lanes and rests of cells of placements, with all that is known of each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.cell_bounds import (
    REGRASP,
    LaneRoom,
    RestRoom,
    note,
    renew_lane,
    renew_rest,
)
from gm_ompl.graph.lanes import Leaving, lane_table
from gm_ompl.holds.cells import Cells, CellTree
from gm_ompl.holds.known import FAILED, Known
from gm_ompl.holds.rows import UNASKED, Tables
from gm_ompl.holds.sets import LIFTED, PlacementSets
from gm_ompl.holds.tables import ArcTable
from gm_ompl.holds.watch import Stop, never
from gm_ompl.mechanics.cell_cuts import CellCuts
from gm_ompl.mechanics.cell_margin import cell_margin, corner_columns, corner_points
from gm_ompl.mechanics.cell_modes import largest_sets, mode_margin, squeezed
from gm_ompl.mechanics.certificate import separates_environment
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements, Problem

Tuple: TypeAlias = tuple[int, ...]
"""A cell for each finger, LIFTED for one in the air."""

MakeTree: TypeAlias = Callable[[ArcTable], CellTree]
"""Makes cells from the table of the arcs."""

FIRST = 256
"""Lanes that there is room for at first; then it doubles."""


@final
class CellGraph:
    """All lanes of cells that a search has met.

    ``leaving`` has the arcs of a part of the object graph by their tails; None: all of it. ``tree``
    makes the cells; None: those of the problem's placements.

    Attributes:
        nodes: the object graph's nodes, in the order in which they are numbered here.
        start: the number of the start's.
        cells: the cells.
        cuts: the cuts, over cells.
        lanes: what is known of lanes.
        resting: what is known of rests.

    Raises:
        LimitError: ``stop`` said so while the tables were made.
    """

    def __init__(
        self, problem: Problem, judge: Judge, backend: KernelBackend, stop: Stop = never,
        leaving: Leaving | None = None, tree: MakeTree | None = None,
    ) -> None:  # fmt: skip
        self._backend, hand = backend, problem.fingers
        self._objects = problem.object_graph
        self.nodes, self._table = lane_table(judge, stop, leaving)
        self.start = self.nodes.index(problem.object_graph.start)
        tables, self._known = self._table.measured, Known(judge, self._table)
        self.cells: CellTree = _of_grid(judge, self._table) if tree is None else tree(self._table)
        self._f_max = hand.max_normal_force / backend.scale
        self._columns = self.cells.by_face(backend.tips)
        self._edges = problem.mechanics.cone_edges
        self.cuts = CellCuts(self._columns, self._f_max, DIRECTIONS)
        self.sets = PlacementSets(hand.groups())
        self._least = judge.least_distances()
        self._alike = {i: group[0] for group in hand.groups() for i in group}
        n, (K, P), V = hand.count, tables.states.shape, len(tables.goal)
        self.lanes = LaneRoom(
            np.empty((FIRST, n), dtype=np.int64), np.empty((FIRST, K, P)),
            np.zeros((FIRST, K, P), dtype=np.bool_), np.empty((FIRST, K)), np.empty((FIRST, V)),
        )  # fmt: skip
        self.resting = RestRoom(np.empty((FIRST, V)), np.zeros((FIRST, V), dtype=np.bool_))
        self._lane_numbers: dict[Tuple, int] = {}
        self._rest_numbers: dict[Tuple, int] = {}
        self._lane_versions: list[int] = []
        self._rests: list[tuple[Tuple, int]] = []
        self._rest_states: IntArray | None = None
        self._separating: dict[int, Separation] = {}
        self._closed: dict[int, set[int]] = {}

    @property
    def lanes_met(self) -> int:
        """Number of lanes of cells looked at."""
        return len(self._lane_numbers)

    def coordinates(self, config: int) -> Coordinates:
        """Return the object's coordinates at a node."""
        return self._objects.coordinates(self.nodes[config])

    def likeness(self, finger: int) -> int:
        """Return the first of the fingers that are interchangeable with a finger."""
        return self._alike[finger]

    def end(self, steps: IntArray) -> int:
        """Return the node where a way of steps, as ``follow`` writes them, ends."""
        arcs = steps[steps[:, 1] != REGRASP, 1]
        return int(self.cells.tables.head[arcs[-1]]) if len(arcs) else self.start

    def lane(self, cells: Tuple, like: int | None = None) -> int:
        """Return the number of a lane; a new one knows the margins of the lane that it is from."""
        cells = self.sets.canonical(cells)
        number = self._lane_numbers.setdefault(cells, len(self._lane_numbers))
        if number == len(self._lane_versions):
            if number == len(self.lanes.sets):
                limits.claim(
                    float(sum(a.nbytes for a in self.lanes)), "the bounds of lanes",
                    "use a coarser fingers.placements.grid",
                )  # fmt: skip
                self.lanes = LaneRoom._make(_doubled(a) for a in self.lanes)
            self.lanes.sets[number] = cells
            self.lanes.z[number] = np.inf if like is None else self.lanes.z[like]
            self.lanes.looked[number] = False
            self._lane_versions.append(-1)
            self.renewed(number)
        return number

    def renewed(self, lane: int) -> int:
        """Return ``lane`` with its bounds renewed if cuts were added."""
        version = self.cuts.version
        if self._lane_versions[lane] != version:
            self._add_new_cells()
            renew_lane(lane, self.lanes, self.tables_of(lane), self.cuts.tables)
            self._lane_versions[lane] = version
        return lane

    def tables_of(self, lane: int) -> Tables:
        """Return the tables, the goal without the nodes that are closed to a lane."""
        tables = self.cells.tables
        if lane not in self._closed:
            return tables
        goal = tables.goal.copy()
        goal[list(self._closed[lane])] = False
        return tables._replace(goal=goal)

    def rest(self, cells: Tuple, like: int | None = None) -> int:
        """Return the number of a rest, one finger LIFTED; see ``lane``."""
        cells = self.sets.canonical(cells)
        number = self._rest_numbers.get(cells)
        if number is None:
            number = self._rest_numbers[cells] = self.rest_renewed(self._new_rest(cells, like))
        return number

    def _new_rest(self, cells: Tuple, like: int | None) -> int:
        number = len(self._rests)
        if number == len(self.resting.z):
            self.resting = RestRoom._make(_doubled(a) for a in self.resting)
        self._rests.append((cells, -1))
        z = self.resting.z[number]
        z[:] = np.inf if like is None else self.resting.z[like]
        for i, cell in enumerate(cells):
            if cell != LIFTED:
                z[~self.cells.tables.node_free[i, cell]] = FAILED
        self.resting.looked[number] = False
        return number

    def barred(self, rest: int, node: int) -> int:
        """Return a rest as another, at which nothing can be regrasped at a node."""
        number = self._new_rest(self._rests[rest][0], rest)
        self.resting.looked[number] = self.resting.looked[rest]
        self.resting.z[number, node] = FAILED
        return number

    def rest_renewed(self, rest: int) -> int:
        """Return ``rest`` with its bounds renewed if cuts were added."""
        cells, known = self._rests[rest]
        if known != self.cuts.version:
            self._add_new_cells()
            fingers = [i for i, cell in enumerate(cells) if cell != LIFTED]
            if self._rest_states is None:
                known_states = [self._table.rest_state(c) for c in range(len(self.nodes))]
                self._rest_states = np.array(known_states)
            rows = np.array([cells[i] for i in fingers], dtype=np.int64)
            if len(fingers):
                cuts = self.cuts.of(fingers)
                renew_rest(self.resting.z[rest], rows, self._rest_states, cuts)
            self._rests[rest] = cells, self.cuts.version
        return rest

    def _add_new_cells(self) -> None:
        if self.cuts.cells < len(self.cells):
            self.cuts.widen(self.cells.boxes, len(self.cells))

    def apart(self, cells: Sequence[int]) -> bool:
        """Whether somewhere in these cells no two fingertips penetrate each other."""
        for i, cell in enumerate(cells):
            for j in range(i):
                if cell == cells[j] and self._alike[i] == self._alike[j]:
                    if self.cells.width(cell) == 0.0:
                        return False  # a set has a placement once
                    continue
                if not self.cells.apart(i, cell, j, cells[j], self._least[i, j]):
                    return False
        return True

    def placements(self, cells: Tuple) -> Placements | None:
        """Return a canonical set of placements where no cell has several."""
        rows = tuple(c if c == LIFTED else self.cells.row(c) for c in cells)
        single = all(c == LIFTED or row >= 0 for c, row in zip(cells, rows, strict=True))
        return self.sets.canonical(rows) if single else None

    def look(self, lane: int, arc: int, part: int) -> bool:
        """Look at a segment of a lane: decided for placements, else bounded; whether it may hold.

        A segment whose state nobody asked for is only asked for it.
        """
        tables = self.cells.tables
        state = int(tables.states[tables.kind[arc], part])
        if state == UNASKED:
            self._table.ask(arc)
            self._lane_versions = [-1] * len(self._lane_versions)
            return True
        cells = tuple(self.lanes.sets[lane].tolist())
        rows = self.placements(cells)
        if rows is None:
            z = self._bound(state, list(range(len(cells))), cells)
        else:
            z = self._known.decide(rows, state)
        holds = z >= tables.z_min
        note(lane, state, z if holds else FAILED, self.lanes, tables)
        self._lane_versions[lane] = -1
        return holds

    def look_at_rest(self, rest: int, node: int) -> bool:
        """Look at a rest at a node, see ``look``."""
        cells = self._rests[rest][0]
        fingers, rows = [i for i, c in enumerate(cells) if c != LIFTED], self.placements(cells)
        if rows is not None:
            z = np.inf if self._known.rest_holds(rows, node) else FAILED
        else:
            state = self._table.rest_state(node)
            z = self._bound(state, fingers, tuple(cells[i] for i in fingers))
        holds = z >= self.cells.tables.z_min
        self.resting.z[rest, node] = min(self.resting.z[rest, node], z if holds else FAILED)
        self.resting.looked[rest, node] = True
        return bool(holds)

    def _bound(self, state: int, fingers: list[int], cells: Tuple) -> float:
        """Bound z of some fingers in their cells at a contact state; the cut is kept."""
        limits.check()
        env, q, _, _ = self._backend.columns(state)
        if state not in self._separating:
            self._separating[state] = separates_environment(env)
        y, hand = np.zeros(6), np.array(fingers, dtype=np.int64)
        tips = corner_columns(self._columns, hand, np.array(cells), self.cells.boxes)
        program = Program(env, q, tips, self._f_max[hand], DIRECTIONS)
        below = self.cells.tables.z_min
        z = cell_margin(program, self._separating[state], below, y)
        self.cuts.add(state, q, y)
        return z if z < below else min(z, self._mode_bound(state, program, cells, y))

    def _mode_bound(self, state: int, program: Program, cells: Tuple, y: Array) -> float:
        """Bound z of some fingers in their cells, as far as not all can be position-controlled."""
        tips = program.tips
        corners = corner_points(self.cells.planes, np.array(cells), self.cells.boxes)
        pairs = squeezed(tips[:, : self._edges, :3].copy(), corners)
        if not pairs:
            return np.inf
        below, masks = self.cells.tables.z_min, largest_sets(len(tips), pairs)
        return mode_margin(program, self._separating[state], below, masks, y)

    def close(self, lane: int, node: int) -> None:
        """Take note that a lane cannot end at a goal node."""
        self._closed.setdefault(lane, set()).add(node)
        self._lane_versions[lane] = -1


def _of_grid(judge: Judge, table: ArcTable) -> Cells:
    """Return the cells of the problem's placements."""
    hand = judge.problem.fingers
    centres = np.array([judge.centres(i) for i in range(hand.count)])
    return Cells(hand.placements, table.measured, centres)


def _doubled(array: np.ndarray) -> np.ndarray:
    """Return an array with room for twice as many."""
    return np.concatenate([array, np.zeros_like(array)])
