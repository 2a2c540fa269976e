"""The project's own randomised planners."""

from __future__ import annotations

import numpy as np
import pytest

import gm_ompl
from gm_ompl.errors import InputError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.planner import Budget, Progress, SearchResult, Status
from gm_ompl.planners.registry import PLANNERS, make_planner
from gm_ompl.problem import Problem
from gm_ompl.sampling.stages import stages_of
from gm_ompl.scenario.load import load

NAMES = ["HybridRRT", "HybridRRTConnect", "HybridRRTstar"]


def _solve(problem: Problem, name: str, seed: int = 0, iterations: int = 200) -> SearchResult:
    judge = Judge(problem, make_backend(problem))
    budget = Budget(max_iterations=iterations)
    return make_planner(name).solve(problem, judge, budget, np.random.default_rng(seed))


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_gives_the_same_plan(name: str) -> None:
    """Under an iteration limit a seed decides everything; another seed finds another plan."""
    problem = load("paper/tumble", ["fingers.placements.grid=[4, 4]"]).problem
    iterations = 15 if name == "HybridRRTstar" else 200
    first, again, other = (_solve(problem, name, seed, iterations) for seed in (7, 7, 8))
    assert first.moves
    assert first.moves == again.moves
    assert first.moves != other.moves or name == "HybridRRTstar"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "scenario",
    ["random/small/1", "random/small/2", "random/small/3", "random/push/0", "random/regrasp/1",
     "planar/corner", "planar/turn"],
)  # fmt: skip
def test_every_plan_passes_the_check(name: str, scenario: str) -> None:
    """What is returned as a plan holds when judged anew by other code."""
    iterations = 60 if name == "HybridRRTstar" else 400
    plan = gm_ompl.plan(scenario, name, max_iterations=iterations, seed=1)
    assert plan.status in ("solved", "budget", "infeasible")
    if plan.status == "solved":
        assert gm_ompl.check(plan).holds
    elif scenario != "planar/turn":
        assert gm_ompl.plan(scenario).status == "infeasible"


@pytest.mark.parametrize("scenario", ["paper/slide", "paper/push", "paper/tumble"])
@pytest.mark.parametrize("name", NAMES[:2])
def test_success_rate(name: str, scenario: str) -> None:
    """Five of five seeds solve a paper's problem within 200 iterations."""
    problem = load(scenario).problem
    assert all(_solve(problem, name, seed).status is Status.SOLVED for seed in range(5))


def test_the_anytime_planner_approaches_the_optimum() -> None:
    """On a coarse regrasp problem it comes within 1 % of the lattice's optimum."""
    small = ["fingers.placements.grid=[3, 3]", "lattice.segments=10"]
    problem = load("paper/regrasp", small).problem
    best = _solve(problem, "astar", iterations=1_000_000).cost
    found = _solve(problem, "HybridRRTstar", iterations=120)
    assert best is not None
    assert found.cost is not None
    assert found.cost <= 1.01 * best
    costs = [row[1] for row in found.statistics["history"] if row[1] is not None]
    assert costs == sorted(costs, reverse=True)


@pytest.mark.parametrize("name", NAMES)
def test_infeasible_only_with_proof(name: str) -> None:
    """No valid set at the start is a proof; a mechanical impossibility is not."""
    walls = ["environment.obstacles.lid={box: {min: [-9, -9, 5.5], max: [9, 9, 9]}}",
             "fingers.placements.faces=[+z]"]  # fmt: skip
    assert _solve(load("paper/slide", walls).problem, name).status is Status.INFEASIBLE
    weak = load("paper/slide", ["fingers.max_normal_force=0.01"]).problem
    assert _solve(weak, name, iterations=20).status is Status.BUDGET


@pytest.mark.parametrize("name", NAMES)
def test_given_placements_are_kept(name: str) -> None:
    """Start and goal placements that the scenario gives are where the plan starts and ends."""
    given = [
        "fingers.start=[{face: -x, cell: [0, 2]}, {face: -x, cell: [2, 2]}]",
        "fingers.goal=[any, {face: +z, cell: [1, 1]}]",
        "fingers.placements.grid=[3, 3]",
        "lattice.segments=6",
    ]
    plan_ = _solve(load("paper/slide", given).problem, name, iterations=100)
    problem = load("paper/slide", given).problem
    table = problem.fingers.placements
    assert plan_.moves
    assert plan_.moves[0].placements == (table.find("-x", (0, 2)), table.find("-x", (2, 2)))
    assert stages_of(plan_.moves)[-1].placements[1] == table.find("+z", (1, 1))


@pytest.mark.parametrize("name", NAMES)
def test_an_interrupt_keeps_what_is_known(name: str) -> None:
    """Ctrl-C during the search ends it with the status "interrupted" and the best plan so far."""
    problem = load("paper/slide").problem
    judge = Judge(problem, make_backend(problem))
    calls = 0

    def report(_: Progress) -> None:
        nonlocal calls
        calls += 1
        if calls == 3:
            raise KeyboardInterrupt

    rng = np.random.default_rng(0)
    result = make_planner(name).solve(problem, judge, Budget(max_iterations=5000), rng, report)
    if name == "HybridRRTstar":
        assert result.status is Status.INTERRUPTED
    assert result.moves
    assert result.cost == pytest.approx(sum(move.cost for move in result.moves))


@pytest.mark.parametrize("name", NAMES)
def test_parameters_are_declared_and_checked(name: str) -> None:
    """Defaults lie in their ranges; a value out of range or an unknown name is refused."""
    for parameter in PLANNERS[name].parameters:
        assert parameter.checked(parameter.default) == parameter.default
        assert parameter.meaning.endswith(".")
    with pytest.raises(InputError, match="root_share"):
        make_planner(name, {"root_share": 2.0})
    with pytest.raises(InputError, match="did you mean 'progress_bias'"):
        make_planner(name, {"progres_bias": 2.0})
    for parameter in PLANNERS[name].parameters:
        if parameter.was:
            with pytest.raises(InputError, match=f"it is called '{parameter.name}' now"):
                make_planner(name, {parameter.was: parameter.default})
    assert make_planner(name, {"batch": 7}).settings["batch"] == 7


@pytest.mark.parametrize("name", NAMES)
def test_extreme_parameters_do_no_harm(name: str) -> None:
    """At either end of every range a search runs to its end."""
    problem = load("paper/slide", ["fingers.placements.grid=[2, 2]"]).problem
    judge = Judge(problem, make_backend(problem))
    for parameter in PLANNERS[name].parameters:
        for value in (parameter.low, parameter.high):
            assert value is not None
            planner = make_planner(name, {parameter.name: parameter.kind(value)})
            rng = np.random.default_rng(0)
            result = planner.solve(problem, judge, Budget(max_iterations=5), rng)
            assert result.status in (Status.SOLVED, Status.BUDGET)
