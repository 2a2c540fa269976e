"""Trees of sampling searches, told vertex by vertex to whoever listens: see ``trace``."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Final, final

from gm_ompl.holds.extraction import PhysicalHand, shared_hub
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.planners.trace import Trace, Vertex
from gm_ompl.problem import Move, Placements, Problem
from gm_ompl.sampling.explorer import Course
from gm_ompl.sampling.lane_store import LaneStore
from gm_ompl.sampling.motions import HybridState
from gm_ompl.sampling.stages import states_along
from gm_ompl.sampling.tree import ROOT, Tree


@final
class Vertices:
    """Tells of states as they join the trees, as vertices.

    Within one of the two kinds of tree the same state is the same vertex, whichever way led to it
    first.

    Args:
        trace: who hears of it.
    """

    def __init__(self, trace: Trace) -> None:
        self._trace, self._numbers = trace, itertools.count()
        self._known: dict[tuple[str, HybridState], Vertex] = {}

    def known(self, root: str, state: HybridState) -> Vertex | None:
        """Return the vertex of a state in the tree from ``root``, "start" or "goal"."""
        return self._known.get((root, state))

    def reached(self, root: str, state: HybridState, parent: Vertex | None) -> Vertex:
        """Return the vertex of a state; tell of it if it is new."""
        return self.known(root, state) or self.hung(root, state, parent)

    def hung(self, root: str, state: HybridState, parent: Vertex | None) -> Vertex:
        """Return the vertex of a state after telling that it hangs on ``parent`` from now on."""
        known = self.known(root, state)
        number = next(self._numbers) if known is None else known.number
        hangs_on, kind = None, "root"
        if parent is not None:
            hangs_on = parent.number
            kind = "regrasp" if parent.placements != state.placements else "displacement"
        vertex = Vertex(number, hangs_on, *state, kind, root)
        self._known[root, state] = vertex
        self._trace(vertex)
        return vertex


START: Final = "start"
GOAL: Final = "goal"


@final
class Growth:
    """Tells of every stride of every branch, and of the plans found, as vertices.

    Args:
        problem: what is planned.
        trace: who hears of it.
    """

    def __init__(self, problem: Problem, trace: Trace) -> None:
        self._sets, self._vertices = PlacementSets(problem.fingers.groups()), Vertices(trace)
        self._placements: dict[Tree, list[Placements]] = {}

    def grown(self, courses: Sequence[Course]) -> None:
        """Tell of the branches that ``courses`` have gained."""
        for course in courses:
            for tree in course.trees:
                told = self._placements.setdefault(tree, [])
                for number in range(len(told), len(tree.branches)):
                    told.append(self._branch(course.store, tree, number, told))

    def _branch(
        self, store: LaneStore, tree: Tree, number: int, told: Sequence[Placements]
    ) -> Placements:
        """Tell of one branch; return where its physical fingers are."""
        branch, root = tree.branches[number], START if tree.ahead else GOAL
        vertices, placements = store.route.way.coordinates, branch.lane
        parent = None
        if branch.parent != ROOT:
            before, at = tree.branches[branch.parent].lane, told[branch.parent]
            parent = self._vertices.known(root, HybridState(vertices[branch.enter], at))
            hand = PhysicalHand(self._sets.groups, at)
            hand.move(*hand.regrasped(shared_hub(self._sets, before, branch.lane), branch.lane))
            placements = hand.placements
        step = 1 if branch.reach >= branch.enter else -1
        for vertex in range(branch.enter, branch.reach + step, step):
            state = HybridState(vertices[vertex], placements)
            parent = self._vertices.reached(root, state, parent)
        return placements

    def planned(self, moves: Sequence[Move]) -> None:
        """Tell of a plan: its states become a way in the start's tree, rewired where need be."""
        parent: Vertex | None = None
        passed: set[HybridState] = set()
        for state in states_along(moves):
            vertex = self._vertices.known(START, state)
            hangs_on = None if parent is None else parent.number
            if vertex is None or (state not in passed and vertex.parent != hangs_on):
                vertex = self._vertices.hung(START, state, parent)
            passed.add(state)
            parent = vertex
