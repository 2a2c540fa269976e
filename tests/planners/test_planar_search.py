"""A* in the plane: exact, bounded below by the object's own way, and what the scenarios promise."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.contact.environment import contact_state, environment_contacts
from gm_ompl.errors import InputError, LimitError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.heuristic import TravelHeuristic
from gm_ompl.graph.planar_heuristic import PlanarHeuristic, suits
from gm_ompl.holds.goals import valid_goals
from gm_ompl.plain.search import plain_search
from gm_ompl.planners.planner import Budget, SearchResult, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Displacement, Problem, Regrasp
from gm_ompl.scenario.load import load

TINY = [
    "lattice.steps={x: 2, y: 2, yaw: 90 deg}", "fingers.placements.grid=[1, 1]",
    "motion.planar={x: [-2, 2], y: [-2, 2], yaw: [-180 deg, 180 deg]}",
    "motion.goal={position: [2, 0, 1], yaw: 90 deg}", "cost.samples_per_arc=1",
]  # fmt: skip
CORRIDOR = ["lattice.steps={x: 2, y: 1, yaw: 30 deg}", "fingers.placements.grid=[3, 1]"]
COARSE = ["lattice.steps={x: 1, y: 1, yaw: 30 deg}", "fingers.placements.grid=[2, 1]"]


def search(problem: Problem, planner: str = "astar", limit: int | None = None) -> SearchResult:
    judge = Judge(problem, make_backend(problem))
    rng = np.random.default_rng(0)
    return make_planner(planner).solve(problem, judge, Budget(max_iterations=limit), rng)


@pytest.mark.parametrize("regrasp", [0.3, 15.0])
def test_the_plain_search_agrees(
    regrasp: float, shared_decisions: Callable[[Problem], object]
) -> None:
    """On a tiny lattice with wrapping yaw: astar, dijkstra and the reference's plain search."""
    problem = load("planar/turn", [*TINY, f"cost.regrasp={regrasp}"]).problem
    want = plain_search(problem, shared_decisions(problem)).cost  # type: ignore[arg-type]
    assert want < math.inf
    for planner in ("astar", "dijkstra"):
        assert search(problem, planner).cost == pytest.approx(want, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("planar/turn", COARSE),
        ("planar/corner", ["fingers.placements.grid=[2, 1]", "cost.regrasp=2"]),
        ("random/planar/7", ["fingers.placements.grid=[1, 1]", "cost.samples_per_arc=1"]),
    ],
)
def test_the_bound_is_admissible_and_no_weaker_than_travel(name: str, overrides: list[str]) -> None:
    """A* finds Dijkstra's cost; at random nodes the bound is at least (11), and fits its parts."""
    problem = load(name, overrides).problem
    assert suits(problem)
    found, plain = search(problem), search(problem, "dijkstra")
    assert found.status is plain.status
    assert found.cost == plain.cost or found.cost == pytest.approx(plain.cost, rel=1e-6)
    judge = Judge(problem, make_backend(problem))
    goals = valid_goals(judge) or ()
    bound, travel = PlanarHeuristic(judge, goals), TravelHeuristic(judge, goals)
    rng, P, n = np.random.default_rng(3), len(problem.fingers.placements), problem.fingers.count
    for _ in range(300):
        config = int(rng.integers(problem.lattice.size))
        hand = tuple(sorted(rng.choice(P, size=n, replace=False).tolist()))
        estimate = bound.estimate(config, hand)
        assert estimate >= travel.estimate(config, hand) * (1 - 1e-6)
        single = [
            table[row] for table, row in zip(bound.finger_estimates(config), hand, strict=True)
        ]
        assert max(single) <= estimate * (1 + 1e-12)


def test_making_the_bound_listens_to_the_budget() -> None:
    """Broken off while nodes are tested or distances are found, whichever comes first."""
    problem = load("planar/corridor", CORRIDOR).problem
    judge = Judge(problem, make_backend(problem))
    goals = valid_goals(judge) or ()
    for patience in (0, 10, problem.lattice.size + 1):
        asked = itertools.count()
        with pytest.raises(LimitError):
            PlanarHeuristic(judge, goals, lambda: next(asked) >= patience)  # noqa: B023
        assert next(asked) == patience + 1


def test_a_budget_ends_with_a_bound() -> None:
    """Cut short, the search still knows a bound, at most the optimum."""
    problem = load("planar/corridor", CORRIDOR).problem
    optimum = search(problem).cost
    assert optimum is not None
    cut = search(problem, limit=100)
    assert cut.status is Status.BUDGET
    assert 0.25 * optimum < cut.lower_bound <= optimum


@pytest.mark.parametrize(
    ("name", "coarse", "least"), [("planar/corner", [], 2), ("planar/corridor", CORRIDOR, 2)]
)
def test_some_scenarios_cannot_be_done_without_regrasping(
    name: str, coarse: list[str], least: int
) -> None:
    """With a regrasp as dear as a million lengths, the proven optimum still has its regrasps.

    A plan without one would cost at most arcs x step x (1 + X_stab / z_min), far less: the
    lattice has none.
    """
    problem = load(name, [*coarse, "cost.regrasp=1e6"]).problem
    found = search(problem)
    assert found.optimal and found.cost is not None
    assert sum(isinstance(move, Regrasp) for move in found.moves) == least
    step = 2.0 * problem.body.diagonal * (1 + problem.cost.stability / problem.mechanics.z_min)
    assert found.lower_bound > 1e6 * least > problem.lattice.size * step


def test_out_of_the_corner_the_object_slides_along_the_wall() -> None:
    """The optimal plan of planar/corner keeps touching the wall, which slides on it."""
    problem = load("planar/corner").problem
    judge = Judge(problem, make_backend(problem))
    found = search(problem)
    moves = [move for move in found.moves if isinstance(move, Displacement)]
    assert len(moves) == 12
    for move in moves:
        (middle,) = problem.motion.arc(move.start, move.end).middles(1)
        touching = environment_contacts(problem.body, problem.environment, middle.pose)
        state = contact_state(touching, middle.pose, middle.twist, problem.body)
        wall = state.normals[:, 1] < -0.5
        assert wall.sum() == 4
        np.testing.assert_allclose(state.slip[wall], [[1, 0, 0]] * 4, atol=1e-12)
        assert judge.placements_valid(middle.pose, move.placements)


def test_a_start_off_the_planar_lattice_is_bad_input() -> None:
    """The message names the start and the step."""
    shifted = ["motion.start={position: [0.3, 0, 1], yaw: 0 deg}"]
    with pytest.raises(InputError, match=r"start \(x = 0\.3.*step"):
        search(load("planar/turn", [*COARSE, *shifted]).problem)


def test_the_budget_is_heard_while_goals_are_looked_at() -> None:
    """A goal region of 160,000 nodes, told to stop after ten poses: no further is looked at."""
    fine = ["lattice.steps={x: 0.005, y: 0.005, yaw: 15 deg}"]
    problem = load("planar/turn", fine).problem
    judge = Judge(problem, make_backend(problem))
    budget = Budget(stop=lambda: judge.configurations >= 10)
    found = make_planner("astar").solve(problem, judge, budget, np.random.default_rng(0))
    assert found.status is Status.BUDGET
    assert judge.configurations == 10


def test_a_goal_between_the_nodes_is_named() -> None:
    """The message has the region's both ends."""
    goal = "motion.goal={x: [1.1, 1.2], y: [0.1, 0.2], yaw: any}"
    with pytest.raises(InputError, match=r"goal \(x = 1\.1 to 1\.2, y = 0\.1 to 0\.2, yaw = any"):
        search(load("planar/turn", [*COARSE, goal]).problem)


def test_yaw_wraps() -> None:
    """From 150 to -150 degrees the way leads over 180: two steps of 30, not ten."""
    overrides = [
        *COARSE, "motion.start={position: [0, 0, 1], yaw: 150 deg}",
        "motion.goal={position: [0, 0, 1], yaw: -150 deg}",
    ]  # fmt: skip
    found = search(load("planar/turn", overrides).problem)
    moves = [move for move in found.moves if isinstance(move, Displacement)]
    assert len(moves) == 2
    assert moves[0].end[2] == pytest.approx(math.pi)


def test_an_unreachable_goal_is_proven_so() -> None:
    """Walls across the whole range, or a goal no hand fits: infeasible, after little search."""
    wall = "environment.obstacles.across={box: {min: [3, -99, 0], max: [3.5, 99, 9]}}"
    far = "motion.planar={x: [-3, 12], y: [-2, 2], yaw: [-180 deg, 180 deg]}"
    goal = "motion.goal={position: [10, 0, 1], yaw: 0 deg}"
    found = search(load("planar/turn", [*COARSE, wall, far, goal]).problem)
    assert found.status is Status.INFEASIBLE
    assert found.statistics["expanded"] == 0
