"""Object graphs: laws of the lattices', and searches on a graph that is none."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest

from gm_ompl.arrays import read_only
from gm_ompl.errors import InputError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.lattice import Coordinates, Goal, Lattice
from gm_ompl.motion.object_graph import GraphArc, LatticeGraph, ObjectGraph, Way
from gm_ompl.motion.planar import PlanarMotion
from gm_ompl.planners.planner import Budget, SearchResult, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Displacement, Problem
from gm_ompl.scenario.load import load

SMALL = ["fingers.placements.grid=[2, 1]", "lattice.segments=3"]
CORRIDOR = ["lattice.steps={x: 2, y: 1, yaw: 30 deg}", "fingers.placements.grid=[3, 1]"]
GRAPHS = [("paper/slide", SMALL), ("paper/regrasp", SMALL), ("planar/corridor", CORRIDOR)]


def near(a: Pose, b: Pose) -> bool:
    return np.allclose(a.rotation, b.rotation, atol=1e-9) and np.allclose(
        a.position, b.position, atol=1e-9
    )


@pytest.mark.parametrize(("name", "overrides"), GRAPHS)
def test_arcs_join_the_poses_of_their_nodes(name: str, overrides: list[str]) -> None:
    """An arc begins at its tail's pose and ends at its head's; no two lead to the same node."""
    graph = load(name, overrides).problem.object_graph
    waiting, met = [graph.start], {graph.start}
    while waiting:
        node = waiting.pop()
        arcs = graph.arcs_from(node)
        assert len({arc.head for arc in arcs}) == len(arcs)
        for arc in arcs:
            assert near(arc.arc.start, graph.pose(node))
            assert near(arc.arc.end, graph.pose(arc.head))
            if arc.head not in met:
                met.add(arc.head)
                waiting.append(arc.head)
    assert graph.goal_nodes == tuple(sorted(node for node in met if graph.in_goal(node)))


@pytest.mark.parametrize(("name", "overrides"), GRAPHS)
def test_a_way_goes_on_where_it_has_come(name: str, overrides: list[str]) -> None:
    """Along a random walk each arc begins where the last one ended, coordinates included."""
    problem = load(name, overrides).problem
    graph, rng = problem.object_graph, np.random.default_rng(0)
    nodes = [graph.start]
    for _ in range(40):
        arcs = graph.arcs_from(nodes[-1])
        nodes.append(arcs[int(rng.integers(len(arcs)))].head)
    way = graph.way(nodes)
    assert len(way.poses) == len(way.coordinates) == len(way.arcs) + 1 == len(nodes)
    assert way.coordinates[0] == pytest.approx(problem.start)
    for k, arc in enumerate(way.arcs):
        assert arc.head == k + 1
        assert near(way.poses[k], graph.pose(nodes[k]))
        assert near(arc.arc.start, way.poses[k]) and near(arc.arc.end, way.poses[k + 1])
        assert near(problem.motion.pose(way.coordinates[k]), way.poses[k])


def test_yaw_is_unwrapped() -> None:
    """Turning on and on, the coordinates grow steadily though lattice nodes wrap."""
    step, turn = math.pi / 2, 2 * math.pi
    axes = tuple(
        read_only(values, (None,), "axis")
        for values in ([0.0], [0.0], [k * step for k in range(4)])
    )
    motion = PlanarMotion((-1, -1, 0), (1, 1, turn), 2.5)
    lattice = Lattice(axes, (None, None, turn))
    anywhere = Goal((None,) * 3, (None,) * 3, motion.periods)
    graph = LatticeGraph(motion, lattice, (0.0, 0.0, turn), anywhere, 3)
    way = graph.way([k % 4 for k in range(10)])
    for k, q in enumerate(way.coordinates):
        assert q == pytest.approx((0.0, 0.0, turn + k * step))


@pytest.mark.parametrize(
    "change", [{"start": (0.1,)}, {"goal": Goal((0.9,), (0.95,), (None,))}], ids=["start", "goal"]
)
def test_ends_off_the_lattice_are_bad_input(change: dict[str, object]) -> None:
    """The message names the end that is off, and the lattice's steps."""
    problem = dataclasses.replace(
        load("paper/slide", SMALL).problem,
        **change,  # type: ignore[arg-type]
    )
    with pytest.raises(InputError, match=f"{next(iter(change))} .*in steps of 0.333333"):
        _ = problem.object_graph


class Sparse:
    """A lattice as a graph of poses alone: ways back are missing, nodes are large numbers.

    Each arc of the lattice is two, of one and of two parts, by way of a node of its own; another
    node is a dead end.
    """

    def __init__(self, whole: ObjectGraph) -> None:
        self._whole = whole
        self._numbers: dict[tuple[int, int], int] = {}
        self._names: dict[int, tuple[int, int]] = {}
        self.start = self._number(whole.start, -1)

    goal_nodes = None

    def _number(self, tail: int, head: int) -> int:
        known = self._numbers.setdefault((tail, head), 2**63 - 1 - 7 * len(self._numbers))
        self._names[known] = tail, head
        return known

    def _arc(self, tail: int, head: int) -> Arc:
        return next(arc.arc for arc in self._whole.arcs_from(tail) if arc.head == head)

    def arcs_from(self, node: int) -> list[GraphArc]:
        tail, head = self._names[node]
        if head == tail:
            return []
        if head >= 0:
            second = Part(self._arc(tail, head), 1 / 3, 1.0)
            return [GraphArc(self._number(head, -1), second, 2)]
        ahead = [arc for arc in self._whole.arcs_from(tail) if arc.head > tail]
        firsts = [
            GraphArc(self._number(tail, arc.head), Part(arc.arc, 0.0, 1 / 3), 1) for arc in ahead
        ]
        stubs = [
            GraphArc(self._number(tail, tail), Part(arc.arc, 0.0, 0.1), 1) for arc in ahead[:1]
        ]
        return firsts + stubs

    def in_goal(self, node: int) -> bool:
        tail, head = self._names[node]
        return head < 0 and self._whole.in_goal(tail)

    def pose(self, node: int) -> Pose:
        tail, head = self._names[node]
        if head < 0:
            return self._whole.pose(tail)
        if head == tail:
            ahead = next(arc.arc for arc in self._whole.arcs_from(tail) if arc.head > tail)
            return ahead.pose(0.1)
        return self._arc(tail, head).pose(1 / 3)

    def coordinates(self, node: int) -> Coordinates:  # noqa: ARG002
        return ()

    def way(self, nodes: Sequence[int]) -> Way:
        arcs = [
            next(arc for arc in self.arcs_from(a) if arc.head == b)
            for a, b in itertools.pairwise(nodes)
        ]
        steps = tuple(arc.leading_to(k) for k, arc in enumerate(arcs, start=1))
        return Way(tuple(map(self.pose, nodes)), ((),) * len(nodes), steps)


class Part(Arc):
    """A stretch of another arc."""

    def __init__(self, whole: Arc, first: float, last: float) -> None:
        self._whole, self._first, self._last = whole, first, last

    def pose(self, t: float) -> Pose:
        return self._whole.pose(self._first + t * (self._last - self._first))

    def twist(self, t: float) -> Twist:
        return self._whole.twist(self._first + t * (self._last - self._first))

    @property
    def sweeps(self) -> tuple[Sweep, ...]:
        return self._whole.sweeps  # of the whole: more than is swept, and free here

    @property
    def key(self) -> tuple[object, ...]:
        return self._whole.key, self._first, self._last


def solve(problem: Problem, **parameters: str) -> SearchResult:
    judge = Judge(problem, make_backend(problem))
    planner = make_planner("astar", parameters)
    return planner.solve(problem, judge, Budget(), np.random.default_rng(0))


@pytest.mark.parametrize("name", ["paper/slide", "paper/regrasp", "paper/tumble"])
def test_searches_need_no_coordinates(name: str) -> None:
    """On a one-way graph with branches, arcs of unequal length and nodes up to 2^63: same optimum.

    A path is only travelled ahead, so nothing is lost; two arcs of one and two thirds have the
    segments of the lattice's arc of three.
    """
    problem = load(name, [*SMALL, "cost.samples_per_arc=3"]).problem
    plain = solve(problem, heuristic="travel")
    sparse = dataclasses.replace(problem)
    object.__setattr__(sparse, "object_graph", Sparse(problem.object_graph))
    found = solve(sparse, heuristic="travel")
    assert found.status is plain.status is Status.SOLVED
    assert found.cost is not None and plain.cost is not None
    ways = [move for move in found.moves if isinstance(move, Displacement)]
    assert [len(move.segments) for move in ways] == [1, 2] * (len(ways) // 2)
    assert all(move.start == move.end == () for move in ways)
    # A sum of two largest travels is at least the largest sum.
    assert found.cost >= plain.cost * (1 - 1e-9)
    assert found.cost == pytest.approx(plain.cost, rel=0.01)
