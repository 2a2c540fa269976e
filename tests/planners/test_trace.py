"""What searches tell of themselves: trees as vertices, expansions, and OMPL's planner data."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
import pytest

import gm_ompl
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.ompl.motions import MacroMotions
from gm_ompl.planners.planner import Budget, Progress, SearchResult
from gm_ompl.planners.registry import make_planner
from gm_ompl.planners.trace import Expansion, Vertex
from gm_ompl.problem import Problem
from gm_ompl.sampling.motions import CoordinateModel, HybridState
from gm_ompl.sampling.stages import states_along
from gm_ompl.scenario.load import load

SMALL = ["lattice.segments=4", "fingers.placements.grid=[2, 2]"]
OURS = ["HybridRRT", "HybridRRTConnect", "HybridRRTstar"]
OMPLS = ["RRT", "RRTConnect", "RRTstar", "BITstar", "FMT", "KPIECE1"]


@dataclass
class Listener:
    """A report that keeps what it hears."""

    events: list[Expansion | Vertex] = field(default_factory=list)

    def __call__(self, _: Progress) -> None:
        """Pass over progress."""

    def trace(self, event: Expansion | Vertex) -> None:
        """Keep an event."""
        self.events.append(event)

    @property
    def vertices(self) -> dict[int, Vertex]:
        """Every vertex as last told."""
        return {event.number: event for event in self.events if isinstance(event, Vertex)}


def _solve(
    problem: Problem, name: str, heard: Listener | None, iterations: int = 60
) -> SearchResult:
    judge, rng = Judge(problem, make_backend(problem)), np.random.default_rng(3)
    given = () if heard is None else (heard,)
    return make_planner(name).solve(problem, judge, Budget(max_iterations=iterations), rng, *given)


@pytest.mark.parametrize("scenario", ["paper/push", "planar/corner"])
@pytest.mark.parametrize("name", [*OURS, *OMPLS])
def test_a_trace_does_not_change_the_plan(name: str, scenario: str) -> None:
    """The same seed gives the same moves whether or not somebody listens."""
    problem = load(scenario, SMALL if scenario == "paper/push" else []).problem
    heard = Listener()
    with_trace = _solve(problem, name, heard)
    assert with_trace.moves == _solve(problem, name, None).moves
    if with_trace.moves:
        assert heard.vertices


@pytest.mark.parametrize("name", [*OURS, *OMPLS])
def test_vertices_make_trees_of_single_changes(name: str) -> None:
    """Parents come first, and an arc moves the object or one finger, as its kind says."""
    heard = Listener()
    _solve(load("paper/tumble", ["fingers.placements.grid=[3, 3]"]).problem, name, heard, 80)
    told: dict[int, Vertex] = {}
    for event in heard.events:
        assert isinstance(event, Vertex)
        assert event.parent is None or event.parent in told
        told[event.number] = event
    assert told
    for vertex in told.values():
        assert (vertex.kind == "root") == (vertex.parent is None)
        if vertex.parent is None:
            continue
        parent = told[vertex.parent]
        assert parent.tree == vertex.tree
        pairs = zip(parent.placements, vertex.placements, strict=True)
        changed = sum(a != b for a, b in pairs)
        moved = parent.q != vertex.q
        assert (changed, moved) == ((0, True) if vertex.kind == "displacement" else (1, False))
        assert _rooted(told, vertex)


def _rooted(told: dict[int, Vertex], vertex: Vertex) -> bool:
    """Whether the way up ends at a root."""
    for _ in range(len(told)):
        if vertex.parent is None:
            return True
        vertex = told[vertex.parent]
    return False


@pytest.mark.parametrize("name", OURS)
def test_arcs_of_own_trees_hold(name: str) -> None:
    """Judged anew, in the direction of execution, each arc of the trees is possible."""
    problem = load("paper/tumble", ["fingers.placements.grid=[3, 3]"]).problem
    heard = Listener()
    result = _solve(problem, name, heard)
    model = CoordinateModel(problem, Judge(problem, make_backend(problem)))
    motions = MacroMotions(model, model.start_state())
    told = heard.vertices
    trees = {"start"} if name == "HybridRRT" else {"start", "goal"}
    assert {v.tree for v in told.values()} == trees
    for vertex in told.values():
        if vertex.parent is not None:
            ends = [told[vertex.parent], vertex]
            before, after = ends if vertex.tree == "start" else ends[::-1]
            states = [HybridState(v.q, v.placements) for v in (before, after)]
            assert motions.expand(*states) is not None
    reached = {HybridState(v.q, v.placements) for v in told.values() if v.tree == "start"}
    assert result.moves
    assert set(states_along(result.moves)) <= reached


def test_lattice_searches_tell_what_they_expand() -> None:
    """On the paper's graph each expansion is told, with a bound that is at most the optimum."""
    problem = load("paper/push", SMALL).problem
    for name in ("astar", "dijkstra"):
        heard = Listener()
        result = _solve(problem, name, heard, 10_000)
        told = [event for event in heard.events if isinstance(event, Expansion)]
        assert result.cost is not None
        assert max(event.bound for event in told) <= result.cost * (1 + 1e-9)
        if name == "dijkstra":
            assert len(told) == result.statistics["expanded"]
            assert {event.why for event in told} <= {"hub", "set of placements"}


@pytest.mark.parametrize("name", OURS)
def test_planner_data_of_own_planners_is_their_trees(name: str) -> None:
    """Under OMPL's setup: all vertices, finite weights, a way from the start to a goal."""
    setup = gm_ompl.setup(gm_ompl.load("paper/push", SMALL), name, seed=1)
    setup.solve(0.5)
    plan = gm_ompl.plan_from(setup)
    data = setup.planner_data()
    setup.clear()
    states = [setup.codec.read(data.getVertex(k).getState()) for k in range(data.numVertices())]
    assert len(set(states)) == len(states) > len(plan.steps)
    tags = {data.getVertex(k).getTag() for k in range(data.numVertices())}
    assert tags == ({1} if name == "HybridRRT" else {1, 2})
    weights = [float(text) for text in re.findall(r'"key\d+">([^<]+)</data></edge>', _flat(data))]
    assert len(weights) == data.numEdges() > 0
    assert all(np.isfinite(weights))
    waiting = [k for k in range(len(states)) if data.isStartVertex(k)]
    assert [states[k] for k in waiting] == [setup.codec.start]
    seen = set(waiting)
    while waiting:
        new = {int(k) for k in data.getEdges(waiting.pop())} - seen
        seen |= new
        waiting.extend(new)
    assert any(data.isGoalVertex(k) for k in seen)


def _flat(data: object) -> str:
    return re.sub(r"\s+", "", data.printGraphML())  # type: ignore[attr-defined]
