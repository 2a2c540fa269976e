from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import lil_array
from scipy.sparse.csgraph import dijkstra

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.arc import Arc, Motion
from gm_ompl.motion.lattice import Lattice
from gm_ompl.motion.object_graph import way_along
from gm_ompl.motion.planar import Straight
from gm_ompl.motion.screw import Screw, Slide
from gm_ompl.plain.judge import ReferenceJudge, Ruling
from gm_ompl.plain.search import SearchStatus, plain_search
from gm_ompl.problem import Displacement, Move, Problem, Regrasp
from gm_ompl.reference.modes import Modes

MakeProblem = Callable[..., Problem]


def whimsical(instant: Instant, prefer: Modes | None) -> ModeDecision:  # noqa: ARG001
    """A quick stand-in for Sec. 3.4: z varies with every placement and with the slip."""
    slip = instant.contacts.slip.sum(axis=0) @ np.array([1.0, 0.3, 0.1])
    tip = instant.contacts.rotation[2] @ np.array([0.4, 0.2, 0.1])
    z = 0.6 + np.sin(3.0 * instant.points.sum() + slip + 5 * tip) * (1.0 if slip or tip else 0.5)
    n = len(instant.points)
    return ModeDecision(
        Outcome.STABLE, max(float(z), 0.0), (ControlMode.POSITION,) * n, (None,) * n
    )


class TwoSlides(Motion):
    """A test motion of two coordinates: along x and along y."""

    names = ("u", "v")
    low, high = (0.0, 0.0), (1.0, 1.0)
    periods = (None, None)
    breakpoints = ((), ())

    def pose(self, q: Sequence[float] | Array) -> Pose:
        return Pose.from_yaw([3.0 * q[0], 4.0 * q[1], 2.5])

    def velocity(self, q: Sequence[float] | Array, dq: Sequence[float] | Array) -> Twist:  # noqa: ARG002
        return Twist(np.array([3.0 * dq[0], 4.0 * dq[1], 0.0]), np.zeros(3))

    def arc(self, tail: Sequence[float] | Array, head: Sequence[float] | Array) -> Arc:
        start = self.pose(tail)
        return Screw(start, Slide(self.pose(head).position - start.position))


def explicit_optimum(problem: Problem) -> float:
    """The optimum by listing every node of ordered placements and every arc, then scipy."""
    judge = ReferenceJudge(problem, whimsical)
    rows = range(len(problem.fingers.placements))
    n = problem.fingers.count
    nodes = [
        (at, p)
        for at in range(problem.lattice.size)
        for p in itertools.product(rows, repeat=n)
        if judge.node_valid(problem.motion.pose(problem.lattice.coordinates(at)), p)
    ]
    number = {node: k for k, node in enumerate(nodes)}
    arcs = lil_array((len(nodes) + 2, len(nodes) + 2))
    start, goal = len(nodes), len(nodes) + 1
    tiny = 1e-12  # scipy's sparse graphs take 0 for no arc
    for (at, p), k in number.items():
        q = problem.lattice.coordinates(at)
        if at == problem.lattice.find(problem.start) and fits(problem.fingers.start, p):
            arcs[start, k] = tiny
        if problem.goal.contains(q) and fits(problem.fingers.goal, p):
            arcs[k, goal] = tiny
        for other, end in problem.lattice.neighbours(at):
            way = way_along(problem.motion, (q, end), problem.cost.samples_per_arc)
            arc = judge.displacement(way, 0, p)
            if (other, p) in number and arc is not None:
                arcs[k, number[other, p]] = arc.cost
        for i in range(n):
            free = judge.rest(problem.motion.pose(q), p, i).finding is Ruling.HOLDS
            for target in rows:
                head = (at, (*p[:i], target, *p[i + 1 :]))
                if free and target != p[i] and head in number:
                    arcs[k, number[head]] = problem.cost.regrasp
    return float(dijkstra(arcs.tocsr(), indices=start)[goal])


def fits(given: tuple[int | None, ...], placements: tuple[int, ...]) -> bool:
    return all(g is None or g == p for g, p in zip(given, placements, strict=True))


def walk(problem: Problem, moves: tuple[Move, ...]) -> float:
    """Follow a plan move by move, fingers keeping their identity; return its cost."""
    at, placements = problem.start, moves[0].placements
    assert fits(problem.fingers.start, placements)
    judge = ReferenceJudge(problem)
    for move in moves:
        assert move.placements == placements
        if isinstance(move, Regrasp):
            assert move.at == pytest.approx(at)
            assert move.cost == problem.cost.regrasp
            assert len(move.rest.modes) == len(placements) - 1
            placements = tuple(
                move.target if i == move.finger else p for i, p in enumerate(placements)
            )
        else:
            assert isinstance(move, Displacement)
            assert move.start == pytest.approx(at)
            assert len(move.segments) == problem.cost.samples_per_arc
            assert problem.lattice.find(move.end) is not None
            at = move.end
        assert judge.node_valid(problem.motion.pose(at), placements)
    assert problem.goal.contains(at)
    assert fits(problem.fingers.goal, placements)
    return sum(move.cost for move in moves)


CASES: dict[str, dict[str, object]] = {
    "two equal fingers": {},
    "one finger": {"f_max": (10.0,)},
    "unequal fingers": {"f_max": (10.0, 4.0), "radius": (1.0, 0.5)},
    "three fingers": {"f_max": (10.0, 10.0, 4.0), "segments": 2, "faces": ["-x", "+y", "-y", "+z"]},
    "given start": {"start": (1, 3), "regrasp": 0.5},
    "given goal": {"goal": (0, None), "regrasp": 0.5},
    "both given": {"start": (0, 1), "goal": (2, 3), "regrasp": 0.7},
    "a wall beside": {"walls": [([-9, 5.5, 0], [20, 9, 9])], "regrasp": 1.0},
    "a wall further on": {"walls": [([1.5, 5.2, 0], [20, 9, 9])], "regrasp": 0.1},
    "tumble": {"tumble": np.pi / 2, "regrasp": 2.0, "segments": 4},
    "two coordinates": {
        "motion": TwoSlides(), "goal_at": (1.0, 0.5), "regrasp": 0.3,
        "lattice": Lattice((np.linspace(0, 1, 3), np.linspace(0, 1, 3)), (None, None)),
    },
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_optimum_equals_that_of_the_whole_graph(problem: MakeProblem, name: str) -> None:
    """The cost is scipy's shortest path over all nodes and arcs, fingers told apart."""
    p = problem(**CASES[name])
    result = plain_search(p, whimsical)
    assert result.cost == pytest.approx(explicit_optimum(p), abs=1e-9)
    if result.status is SearchStatus.SOLVED:
        assert walk(p, result.moves) == pytest.approx(result.cost)
    else:
        assert result.moves == ()
        assert result.cost == np.inf


def test_the_cases_are_not_all_alike(problem: MakeProblem) -> None:
    """Among the cases some need regrasps, and none is solved without moving."""
    regrasps = {}
    for name, changes in CASES.items():
        moves = plain_search(problem(**changes), whimsical).moves
        regrasps[name] = sum(isinstance(move, Regrasp) for move in moves)
        assert moves
    assert regrasps["both given"] >= 2  # both fingers end elsewhere
    assert len(set(regrasps.values())) > 2


def test_interchangeable_fingers_may_be_told_apart(problem: MakeProblem) -> None:
    """Fingers equal but for 1e-9 of their limit are kept in order: more nodes, the same cost."""
    same = plain_search(problem(tumble=np.pi / 2, regrasp=2.0), whimsical)
    told = plain_search(
        problem(tumble=np.pi / 2, regrasp=2.0, f_max=(10.0, 10.0 + 1e-9)), whimsical
    )
    assert same.cost == pytest.approx(told.cost)
    assert told.expanded > same.expanded


def test_regrasps_are_avoided_when_they_are_dear(problem: MakeProblem) -> None:
    """Raising X_regr never lowers the optimum, nor the cost without the regrasps in it."""
    cases = [problem(tumble=np.pi / 2, regrasp=r) for r in (0.01, 1.0, 100.0)]
    results = [plain_search(p, whimsical) for p in cases]
    counts = [sum(isinstance(m, Regrasp) for m in r.moves) for r in results]
    assert sorted(counts, reverse=True) == counts
    assert sorted(r.cost for r in results) == [r.cost for r in results]


def test_pushing_the_box_needs_no_regrasp(problem: MakeProblem) -> None:
    """With real mechanics: weak fingers push from behind under position control (Fig. 8)."""
    p = problem(f_max=(5.0, 5.0), grid=(3, 1), faces=["+x", "-x", "+z"], samples=1)
    result = plain_search(p)
    assert result.status is SearchStatus.SOLVED
    assert walk(p, result.moves) == pytest.approx(result.cost)
    labels = [
        p.fingers.placements.labels[p.fingers.placements.face[i]]
        for i in result.moves[0].placements
    ]
    assert labels == ["-x", "-x"]
    for move in result.moves:
        assert isinstance(move, Displacement)
        assert all(d.modes == (ControlMode.POSITION,) * 2 for d in move.segments)


def test_fingers_in_front_must_go_round(problem: MakeProblem) -> None:
    """With real mechanics: two fingers in front cannot pull; one goes behind and they pinch."""
    p = problem(f_max=(10.0, 10.0), grid=(2, 1), faces=["+x", "-x"], start=(0, 1), samples=1)
    result = plain_search(p)
    assert [type(m) for m in result.moves] == [Regrasp] + [Displacement] * 3
    assert walk(p, result.moves) == pytest.approx(result.cost)


def test_no_plan_is_infeasible(problem: MakeProblem) -> None:
    """A finger that can only touch the front cannot push forwards: the graph is exhausted."""
    result = plain_search(problem(f_max=(10.0,), faces=["+x"], samples=1))
    assert result.status is SearchStatus.INFEASIBLE
    assert result.expanded > 0


def test_a_blocked_goal_is_infeasible(problem: MakeProblem) -> None:
    """A wall in the way of the box itself leaves nothing to find."""
    p = problem(walls=[([4.0, -9, 0], [9, 9, 9])])
    assert plain_search(p, whimsical).status is SearchStatus.INFEASIBLE


def test_start_off_the_lattice_is_bad_input(problem: MakeProblem) -> None:
    """A start between lattice nodes is refused, with its coordinates in the message."""
    p = replace(problem(), start=(0.1,))
    with pytest.raises(InputError, match=r"0\.1"):
        plain_search(p, whimsical)


def test_planar_yaw_wraps(problem: MakeProblem) -> None:
    """Where yaw is periodic the plan turns the short way and its coordinates are unwrapped."""

    class Turn(Motion):
        names = ("yaw",)
        low, high = (-np.pi,), (np.pi,)
        periods = (2 * np.pi,)
        breakpoints = ((),)

        def pose(self, q: Sequence[float] | Array) -> Pose:
            return Pose.from_yaw([0.0, 0.0, 2.5], float(q[0]))

        def velocity(self, q: Sequence[float] | Array, dq: Sequence[float] | Array) -> Twist:  # noqa: ARG002
            return Twist(np.zeros(3), np.array([0.0, 0.0, float(dq[0])]))

        def arc(self, tail: Sequence[float] | Array, head: Sequence[float] | Array) -> Arc:
            return Straight((0.0, 0.0, float(tail[0])), (0.0, 0.0, float(head[0])), 2.5)

    axis: Array = np.array([-np.pi + np.pi / 4 * k for k in range(8)])
    p = problem(
        motion=Turn(), lattice=Lattice((axis,), (2 * np.pi,)), goal_at=(float(axis[1]),),
        regrasp=0.01,
    )  # fmt: skip
    p = replace(p, start=(float(axis[7]),))

    def steady(instant: Instant, prefer: Modes | None) -> ModeDecision:  # noqa: ARG001
        n = len(instant.points)
        return ModeDecision(Outcome.STABLE, 1.0, (ControlMode.POSITION,) * n, (None,) * n)

    moves = plain_search(p, steady).moves
    ends = [m.end[0] for m in moves if isinstance(m, Displacement)]
    np.testing.assert_allclose(ends, [np.pi, np.pi * 1.25], atol=1e-12)
