"""gm_ompl's own planners as planners of OMPL, and what any of them explored as OMPL's data."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from ompl import base as ob
from ompl import geometric as og

from gm_ompl.errors import InputError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.ompl.callbacks import GoalRegion, Guard
from gm_ompl.planners.ompl.convert import Codec
from gm_ompl.planners.ompl.motions import HybridMotions
from gm_ompl.planners.ompl.parts import motions_from
from gm_ompl.planners.planner import Budget, Planner, Progress, Report, SearchResult, Status, silent
from gm_ompl.planners.trace import Expansion, Vertex
from gm_ompl.sampling.motions import HybridState

START_TAG, GOAL_TAG = 1, 2
"""What OMPL's planners of two trees tag vertices with."""


@dataclass(frozen=True)
class ExploredTrees:
    """What a planner explored; with two trees, both and what joins them.

    Attributes:
        states: the vertices.
        edges: (from, to), numbers of vertices, in the direction of execution.
        starts: vertices that are starts.
        goals: vertices that are goals.
        backward: vertices that grew from the goal; OMPL tags them so.
    """

    states: tuple[HybridState, ...]
    edges: tuple[tuple[int, int], ...]
    starts: frozenset[int]
    goals: frozenset[int]
    backward: frozenset[int] = frozenset()


def tree_of(data: Any, codec: Codec) -> ExploredTrees:
    """Return what OMPL's ``data`` holds; its planner must not have been cleared."""
    count = data.numVertices()
    return ExploredTrees(
        states=tuple(codec.read(data.getVertex(k).getState()) for k in range(count)),
        edges=tuple((k, int(other)) for k in range(count) for other in data.getEdges(k)),
        starts=frozenset(k for k in range(count) if data.isStartVertex(k)),
        goals=frozenset(k for k in range(count) if data.isGoalVertex(k)),
        backward=frozenset(k for k in range(count) if data.getVertex(k).getTag() == GOAL_TAG),
    )


def planner_data(si: Any, codec: Codec, motions: HybridMotions, tree: ExploredTrees) -> Any:
    """Return ``tree`` as OMPL's ``PlannerData``, each edge weighted by Eqs. (9) and (10)."""
    data = ob.PlannerData(si)
    kept = []  # vertices are known by their states' addresses until they are decoupled
    for number, meaning in enumerate(tree.states):
        state = si.allocState()
        codec.write(state, meaning)
        tag = GOAL_TAG if number in tree.backward else START_TAG
        vertex = ob.PlannerDataVertex(state, tag)
        kept.append((state, vertex))
        if number in tree.starts:
            data.addStartVertex(vertex)
        elif number in tree.goals:
            data.addGoalVertex(vertex)
        else:
            data.addVertex(vertex)
    for a, b in tree.edges:
        cost = motions.cost(tree.states[a], tree.states[b])
        data.addEdge(a, b, ob.PlannerDataEdge(), ob.Cost(cost))
    data.decoupleFromPlanner()
    return data


_ENDS = {
    Status.SOLVED: "EXACT_SOLUTION",
    Status.INFEASIBLE: "INFEASIBLE",
    Status.BUDGET: "TIMEOUT",
    Status.INTERRUPTED: "ABORT",
}


@final
class Grown:
    """Hears of vertices, and makes what a planner of OMPL would call its data of them.

    It is a search's ``report``.
    """

    def __init__(self) -> None:
        self._vertices: dict[int, Vertex] = {}

    def __call__(self, _: Progress) -> None:
        """Pass over progress."""

    def trace(self, event: Expansion | Vertex) -> None:
        """Keep ``event`` if it is a vertex."""
        if isinstance(event, Vertex):
            self._vertices[event.number] = event

    def tree(
        self, in_goal: Callable[[HybridState], bool], start: HybridState,
        plan: Sequence[HybridState],
    ) -> ExploredTrees:  # fmt: skip
        """Return the trees and the plan as one graph, each state once, edges as executed.

        Of free motion, whose vertices have no coordinates, it is the plan alone.

        Args:
            in_goal: tells the goal.
            start: the virtual start, from which the roots are reached for free.
            plan: the states that the plan leads through, if any.
        """
        numbers = {start: 0}
        edges: dict[tuple[int, int], None] = {}

        def number(state: HybridState) -> int:
            return numbers.setdefault(state, len(numbers))

        backward = set()
        for vertex in (v for v in self._vertices.values() if v.q):
            here = number(_state(vertex))
            if vertex.tree == "goal":
                backward.add(here)
            if vertex.parent is not None:
                parent = number(_state(self._vertices[vertex.parent]))
                edges[(here, parent) if vertex.tree == "goal" else (parent, here)] = None
            elif vertex.tree == "start":
                edges[0, here] = None
        for before, after in itertools.pairwise([start, *plan]):
            edges[number(before), number(after)] = None
        edges.pop((0, 0), None)  # where the start's placements are given, it is a root itself
        return ExploredTrees(
            states=tuple(numbers),
            edges=tuple(edges),
            starts=frozenset([0]),
            goals=frozenset(k for state, k in numbers.items() if k and in_goal(state)),
            backward=frozenset(backward),
        )


def _state(vertex: Vertex) -> HybridState:
    return HybridState(vertex.q, vertex.placements)


def offer(si: Any, pdef: Any, states: Sequence[Any], name: str) -> None:
    """Make ``states`` the only solution path of ``pdef``, found by the planner ``name``."""
    path = og.PathGeometric(si)
    for state in states:
        path.append(state)  # a copy
    pdef.clearSolutionPaths()  # OMPL would rank by length in the space, not by cost
    pdef.addSolutionPath(path, False, 0.0, name)


@final
class PlainPlanner(ob.Planner):
    """A planner that knows nothing of OMPL, offered to it.

    Args:
        si: OMPL's space information.
        planner: who searches.
        judge: answers about the problem.
        codec: what states mean.
        guard: keeps exceptions.
        rng: the only source of randomness.

    Attributes:
        planner: likewise.
        result: what the last search found, or None.
    """

    def __init__(
        self,
        si: Any,
        planner: Planner,
        judge: Judge,
        codec: Codec,
        guard: Guard,
        rng: np.random.Generator,
    ) -> None:
        super().__init__(si, planner.name)
        self.planner = planner
        self.result: SearchResult | None = None
        self._grown = Grown()
        self._judge, self._codec, self._guard, self._rng = judge, codec, guard, rng

    def clear(self) -> None:
        """Forget the last search."""
        super().clear()
        self.result, self._grown = None, Grown()

    def solve(self, stop: Any) -> Any:
        """Search until ``stop``; hand a path to OMPL where one was found.

        Args:
            stop: OMPL's termination condition, or seconds.
        """
        try:
            status = self._search(stop)
        except BaseException as error:
            self._guard.keep(error)
            status = "ABORT"
        return ob.PlannerStatus(getattr(ob.PlannerStatus, status))

    def _search(self, stop: Any) -> str:
        limit = stop if callable(stop) else ob.timedPlannerTerminationCondition(float(stop))
        self.checkValidity()
        self._refuse_other_ends()
        problem = self._judge.problem
        budget = Budget(stop=lambda: bool(limit()))
        self._grown = Grown()
        heard: Report = self._grown if self.planner.specs.randomised else silent
        self.result = self.planner.solve(problem, self._judge, budget, self._rng, heard)
        if self.result.status is Status.SOLVED:
            self._offer([self._codec.start, *self._codec.along(self.result.moves)])
        return _ENDS[self.result.status]

    def _offer(self, states: list[HybridState]) -> None:
        si, made = self.getSpaceInformation(), []
        for meaning in states:
            made.append(si.allocState())
            self._codec.write(made[-1], meaning)
        offer(si, self.getProblemDefinition(), made, self.getName())

    def _refuse_other_ends(self) -> None:
        """Refuse start and goal states other than the scenario's.

        Raises:
            InputError: there are some.
        """
        pdef, start = self.getProblemDefinition(), self.getSpaceInformation().allocState()
        self._codec.write(start, self._codec.start)
        for what, own in (
            ("start", pdef.getStartStateCount() == 1 and pdef.hasStartState(start, 0)),
            ("goal", isinstance(pdef.getGoal(), GoalRegion)),
        ):
            if not own:
                raise InputError(
                    f"{self.getName()} plans for the scenario's own start and goal, not for a "
                    f"{what} state set in OMPL: say it in the scenario (fingers.{what}), or set "
                    "one of OMPL's planners"
                )

    def tree(self) -> ExploredTrees:
        """Return what the last search explored; of a search on the lattice, its plan.

        Not an override of ``getPlannerData``: called from C++, that would end the process.
        """
        moves = self.result.moves if self.result is not None else ()
        in_goal = motions_from(self._judge).model.in_goal
        return self._grown.tree(in_goal, self._codec.start, self._codec.along(moves))
