"""A* and Dijkstra's algorithm on the manipulation-feasibility graph, against the plain search."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable

import pytest

from gm_ompl.errors import InputError, UnknownPlannerError
from gm_ompl.motion.lattice import Goal
from gm_ompl.plain.search import plain_search
from gm_ompl.planners.planner import Budget, SearchResult, Status
from gm_ompl.planners.registry import PLANNERS, make_planner
from gm_ompl.problem import Displacement, Problem, Regrasp
from gm_ompl.scenario.load import load

Solve = Callable[..., SearchResult]
EXACT = ("astar", "dijkstra")

QUICK = (0, 1, 4, 7, 10, 14, 15, 19, 22, 25, 33, 36, 41, 44, 68, 70, 72, 73, 74, 81, 83, 88)
"""Seeds of ``random/small`` that need few mode decisions; ``verify`` has the others."""


def agree(problem: Problem, result: SearchResult, optimum: float) -> None:
    """Check a finished search against the optimum, and its moves against each other."""
    if optimum == math.inf:
        assert result.status is Status.INFEASIBLE
        assert result.lower_bound == math.inf
        assert result.moves == ()
        return
    assert result.status is Status.SOLVED
    assert result.optimal
    assert result.cost is not None
    assert result.cost == pytest.approx(optimum, rel=1e-6, abs=1e-12)
    assert result.lower_bound <= result.cost <= result.lower_bound * (1 + 1e-6)
    joined(problem, result)


def joined(problem: Problem, result: SearchResult) -> None:
    """Check that moves join start and goal, each starting where the last ended."""
    q, hand = problem.start, None
    for move in result.moves:
        if isinstance(move, Displacement):
            assert move.start == pytest.approx(q)
            q = move.end
        else:
            assert move.at == pytest.approx(q)
        assert hand is None or move.placements == hand
        hand = move.placements
        if isinstance(move, Regrasp):
            assert len(move.rest.modes) == problem.fingers.count - 1
            hand = (*hand[: move.finger], move.target, *hand[move.finger + 1 :])
    assert problem.goal.contains(q, 1e-6)
    if hand is not None:
        ends = ((problem.fingers.start, result.moves[0].placements), (problem.fingers.goal, hand))
        for wanted, have in ends:
            assert all(w is None or w == h for w, h in zip(wanted, have, strict=True))


@pytest.mark.parametrize("seed", QUICK)
def test_planners_agree_with_the_plain_search(
    seed: int, solve: Solve, shared_decisions: Callable[[Problem], object]
) -> None:
    """astar, dijkstra and the plain search find the same optimum or none, on random problems."""
    problem = load(f"random/small/{seed}").problem
    decide = shared_decisions(problem)
    optimum = plain_search(problem, decide).cost  # type: ignore[arg-type]
    for planner in ("astar", "dijkstra"):
        agree(problem, solve(problem, planner, decide), optimum)


def test_the_random_problems_are_of_all_kinds() -> None:
    """The compared problems have one to three fingers, unequal ones, obstacles, given places."""
    problems = [load(f"random/small/{seed}").problem for seed in QUICK]
    assert len(set(QUICK)) >= 20
    assert {p.fingers.count for p in problems} == {1, 2, 3}
    assert any(len(p.fingers.groups()) > 1 for p in problems)
    assert any(len(p.fingers.groups()) == 1 < p.fingers.count for p in problems)
    assert any(p.environment.obstacles for p in problems)
    assert any(set(p.fingers.start) != {None} for p in problems)
    assert any(set(p.fingers.goal) != {None} for p in problems)


@pytest.mark.parametrize("seed", [10, 88])
def test_independent_decisions_agree(seed: int, solve: Solve) -> None:
    """The two searches agree also when each makes its own mode decisions."""
    problem = load(f"random/small/{seed}").problem
    agree(problem, solve(problem), plain_search(problem).cost)


def test_two_coordinates(
    solve: Solve,
    small_slide: Problem,
    sliding_xy: Callable[..., Problem],
    shared_decisions: Callable[[Problem], object],
) -> None:
    """A motion of two coordinates is searched likewise; cheap regrasps make turning pay."""
    for regrasp in (0.5, 100.0):
        problem = sliding_xy(small_slide, (2, 1))
        problem = dataclasses.replace(
            problem, cost=dataclasses.replace(problem.cost, regrasp=regrasp, samples_per_arc=1)
        )
        decide = shared_decisions(problem)
        optimum = plain_search(problem, decide).cost  # type: ignore[arg-type]
        assert optimum < math.inf
        for planner in EXACT:
            agree(problem, solve(problem, planner, decide), optimum)


def test_a_goal_region(
    solve: Solve,
    small_slide: Problem,
    sliding_xy: Callable[..., Problem],
    shared_decisions: Callable[[Problem], object],
) -> None:
    """Of a goal region the cheapest node is reached, for either planner."""
    region = Goal((1.0, None), (2.0, None), (None, None))
    problem = sliding_xy(small_slide, (2, 1), region)
    decide = shared_decisions(problem)
    optimum = plain_search(problem, decide).cost  # type: ignore[arg-type]
    assert optimum == pytest.approx(1.0, rel=0.1)
    for planner in EXACT:
        agree(problem, solve(problem, planner, decide), optimum)


@pytest.mark.parametrize("X_regr", [0.0, 0.01, 1.0, 50.0])
def test_any_cost_of_regrasping(X_regr: float, solve: Solve, shared_decisions: object) -> None:
    """A* is exact and ends for every X_regr, zero and less than the distance included."""
    problem = load("random/small/88").problem
    problem = dataclasses.replace(problem, cost=dataclasses.replace(problem.cost, regrasp=X_regr))
    decide = shared_decisions(problem)  # type: ignore[operator]
    agree(problem, solve(problem, "astar", decide), plain_search(problem, decide).cost)


def test_a_start_in_the_goal_is_solved_at_once(solve: Solve, small_slide: Problem) -> None:
    """Where the start satisfies the goal, the plan has no steps and costs nothing."""
    problem = dataclasses.replace(small_slide, goal=Goal(small_slide.start, small_slide.start,
                                                         small_slide.goal.periods))  # fmt: skip
    for planner in EXACT:
        result = solve(problem, planner)
        assert result.status is Status.SOLVED
        assert (result.cost, result.lower_bound, result.moves) == (0.0, 0.0, ())
        assert result.optimal


def test_a_start_off_the_lattice_is_bad_input(solve: Solve, small_slide: Problem) -> None:
    """The message names the start and the lattice's step."""
    problem = dataclasses.replace(small_slide, start=(0.123,))
    with pytest.raises(InputError, match=r"start \(s = 0\.123\).*steps of 0\.333333"):
        solve(problem)


def test_a_goal_off_the_lattice_is_bad_input(solve: Solve, small_slide: Problem) -> None:
    """The message names the goal and the lattice's step."""
    problem = dataclasses.replace(small_slide, goal=Goal((0.9,), (0.95,), (None,)))
    with pytest.raises(InputError, match=r"goal \(s = 0\.9 to 0\.95\).*steps of 0\.333333"):
        solve(problem)


def test_a_goal_no_hand_fits_is_infeasible_at_once(solve: Solve, small_slide: Problem) -> None:
    """Two fingers that must end at one placement cannot: proven without a mode decision."""
    fingers = dataclasses.replace(small_slide.fingers, goal=(0, 0))
    result = solve(dataclasses.replace(small_slide, fingers=fingers))
    assert result.status is Status.INFEASIBLE
    assert result.lower_bound == math.inf
    assert result.statistics["mode_decisions"] == 0


def test_budgets_end_with_a_valid_bound(
    solve: Solve, small_slide: Problem, shared_decisions: Callable[[Problem], object]
) -> None:
    """Each kind of budget ends with BUDGET and a bound below the optimum, or with a plan."""
    decide = shared_decisions(small_slide)
    optimum = plain_search(small_slide, decide).cost  # type: ignore[arg-type]
    budgets = [Budget(time_limit=0.0), Budget(memory_limit_mb=1.0)]
    budgets += [Budget(max_iterations=n) for n in (0, 1, 2, 5)]
    bounds = []
    for budget in budgets:
        result = solve(small_slide, "astar", decide, budget)
        assert result.lower_bound <= optimum * (1 + 1e-9)
        assert result.status is Status.BUDGET
        assert (result.cost, result.moves, result.optimal) == (None, (), False)
        bounds.append(result.lower_bound)
    assert bounds[:3] == [0.0, 0.0, 0.0]


def test_a_plan_in_hand_survives_the_budget(
    solve: Solve, sliding_xy: Callable[..., Problem], small_slide: Problem,
    shared_decisions: Callable[[Problem], object],
) -> None:  # fmt: skip
    """Whatever number of expansions is allowed: BUDGET without a plan, else a sound plan."""
    problem = sliding_xy(small_slide, (1, 1))
    decide = shared_decisions(problem)
    optimum = plain_search(problem, decide).cost  # type: ignore[arg-type]
    for limit in itertools.count(0, 10):
        result = solve(problem, "dijkstra", decide, Budget(max_iterations=limit))
        assert result.lower_bound <= optimum * (1 + 1e-6)
        if result.status is Status.SOLVED:
            assert result.cost is not None
            assert result.cost >= optimum * (1 - 1e-9)
            joined(problem, result)
        if result.optimal:
            break
        assert limit < 10_000


def test_an_interrupt_ends_with_what_is_known(solve: Solve, small_slide: Problem) -> None:
    """Ctrl-C during a mode decision ends the search as INTERRUPTED, with bound and counts."""
    asked = []

    def decide(instant: object, prefer: object) -> None:
        asked.append((instant, prefer))
        raise KeyboardInterrupt

    result = solve(small_slide, "astar", decide)
    assert len(asked) == 1
    assert result.status is Status.INTERRUPTED
    assert result.cost is None
    assert result.lower_bound == pytest.approx(15.0)
    assert result.statistics["expanded"] > 0
    assert result.statistics["history"][-1][2] == result.lower_bound


def test_same_problem_same_plan(
    solve: Solve, small_slide: Problem, shared_decisions: Callable[[Problem], object]
) -> None:
    """Two runs return the same moves and do the same work."""
    decide = shared_decisions(small_slide)
    first, second = (solve(small_slide, "astar", decide) for _ in range(2))
    assert first.moves == second.moves
    assert first.statistics["expanded"] == second.statistics["expanded"]


def test_unknown_planner() -> None:
    """An unknown name is refused with the valid ones."""
    with pytest.raises(UnknownPlannerError, match="did you mean 'astar'"):
        make_planner("a-star")
    assert all(make_planner(name).name == name for name in PLANNERS)


def test_every_status_has_its_sentence() -> None:
    """No two outcomes read alike."""
    assert len({status.sentence for status in Status}) == len(Status)
