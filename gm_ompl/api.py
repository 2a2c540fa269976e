"""The public functions: load a scenario, plan it, check a plan and what it tolerates, judge."""

from __future__ import annotations

import dataclasses
import numbers
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, SupportsFloat, SupportsIndex

import numpy as np

from gm_ompl import clock, limits
from gm_ompl.arguments import whole
from gm_ompl.asking import (
    Coordinates,
    PlacementsLike,
    ScenarioLike,
    budget,
    coordinates,
    judge_of,
    loaded,
    placed,
    seconds,
    warned,
)
from gm_ompl.asking import load as load
from gm_ompl.diagnosis import SECONDS
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.ways import with_ways
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.again import settled, with_hand
from gm_ompl.planners.planner import Budget, Planner, Report, SearchResult, Status, silent
from gm_ompl.planners.prepare import prepare
from gm_ompl.planners.price import at_true_cost, priced
from gm_ompl.planners.registry import make_planner, suited
from gm_ompl.planners.steady import Steady
from gm_ompl.problem import Move, Problem
from gm_ompl.scenario.overrides import Changes
from gm_ompl.scenario.scenario import Scenario

if TYPE_CHECKING:
    from gm_ompl.checking.report import CheckReport
    from gm_ompl.diagnosis.values import Explanation
    from gm_ompl.tolerance.report import Tolerance
    from gm_ompl.tolerance.strong import StrongReport


def plan(
    scenario: ScenarioLike,
    planner: str | Planner = "astar",
    *,
    time_limit: SupportsFloat | None = None,
    max_iterations: SupportsIndex | None = None,
    memory_limit: SupportsFloat | None = None,
    seed: SupportsIndex = 0,
    parameters: Mapping[str, Any] | None = None,
    report: Report | None = None,
) -> Plan:
    """Plan a scenario.

    Ctrl-C ends the search and returns what is known, with the status "interrupted".

    Args:
        scenario: what to plan.
        planner: its name, or one of your own.
        time_limit: wall time for all of it [s]; None is no limit.
        max_iterations: node expansions, or a sampling planner's own iterations.
        memory_limit: resident memory of the process [MiB].
        seed: of randomised planners.
        parameters: the named planner's own parameters.
        report: called now and then with the search's progress.

    Returns:
        The plan, or why there is none: see ``Plan.status``.

    Raises:
        InputError: the scenario, the planner's name or a limit is wrong.
        LimitError: a limit is reached before the scenario is loaded.
    """
    searcher = planner if isinstance(planner, Planner) else make_planner(planner, parameters)
    asked, seed = budget(time_limit, max_iterations, memory_limit), whole("seed", seed, 0)
    with limits.holding(asked.time_limit, asked.memory_limit_mb):
        given = warned(loaded(scenario))
        suited(searcher, given.problem)
        return _planned(given, searcher, asked, seed, report or silent)


def _planned(given: Scenario, searcher: Planner, asked: Budget, seed: int, report: Report) -> Plan:
    problem = given.problem
    rng = np.random.default_rng(seed)
    started, moves = clock.now(), tuple[Move, ...]()
    steady, fallbacks, pockets, paths = Steady((), ()), 0, 0, None
    try:
        judging = judge_of(priced(problem))
        result = searcher.solve(judging.problem, judging, asked, rng, report)
        result, steady = settled(searcher, judging, result, asked, rng)
        problem, judging = _with_hand(problem, result), with_hand(judging, result)
        if judging.hand is not None:
            from gm_ompl.planners.joints import jointed  # loads OMPL

            result, steady, paths = jointed(searcher, judging, result, steady, asked, rng)
        fallbacks, pockets = judging.backend.fallbacks, judging.reach.pockets
        with limits.lifted():  # a plan that was found is not lost
            moves = at_true_cost(problem, with_ways(judging.reach, steady.moves))
    except LimitError as stopped:  # before the search could begin
        result = _unbegun(Status.BUDGET, started, ended_by=str(stopped))
    except KeyboardInterrupt:  # likewise, or twice
        result = _unbegun(Status.INTERRUPTED, started)
    statistics = {**result.statistics, "fallback_decisions": fallbacks, **steady.statistics()}
    if pockets:
        statistics["pockets"] = pockets
    if result.status is Status.BUDGET and limits.reached():
        statistics.setdefault("ended_by", limits.reached())
    return assemble(
        problem,
        given.resolved(),
        moves,
        status=result.status.value,
        planner=searcher.name,
        statistics=statistics,
        seed=seed,
        parameters=searcher.settings,
        optimal=result.optimal,
        lower_bound=result.lower_bound,
        paths=paths,
    )


def _with_hand(problem: Problem, result: SearchResult) -> Problem:
    """Return the problem with the placements that a result's moves name."""
    if result.fingers is None:
        return problem
    return dataclasses.replace(problem, fingers=result.fingers)


def _unbegun(status: Status, started: float, **more: str) -> SearchResult:
    spent = {"time_s": clock.now() - started, "expanded": 0, "mode_decisions": 0, "history": []}
    return SearchResult(status, statistics={**spent, **more})


def check(plan: Plan) -> CheckReport:
    """Judge a plan anew, from the scenario inside it alone, with HiGHS.

    Returns:
        Per step what holds, and every violation with its reason; ``holds`` sums it up.

    Raises:
        ScenarioError: the scenario inside the plan cannot be used.
    """
    from gm_ompl.checking.check import check  # loads HiGHS

    return check(plan)


def tolerate(plan: Plan, overrides: Changes = ()) -> Tolerance:
    """Find how far a plan's world may be off before its modes and forces no longer hold.

    Args:
        plan: the plan.
        overrides: what replaces values of the scenario inside it, as for ``load``: the ranges of
            ``uncertainty``, say, or ``mechanics.z_min``.

    Returns:
        Per step and for the whole plan: an interval for each quantity, the others nominal, and by
        how much all ranges may be widened together.

    Raises:
        InputError: the scenario inside the plan cannot be used, or the plan has no steps.
    """
    from gm_ompl.planfile.fit import problem_of
    from gm_ompl.tolerance.measure import measured  # loads HiGHS

    if overrides:
        scenario = load(plan.scenario, overrides).resolved()
        plan = plan.model_copy(update={"scenario": scenario})
    return measured(plan, problem_of(plan))


def strong(plan: Plan) -> StrongReport:
    """Find how much of a plan's margins holds whatever the contacts do: z_strong beside z.

    Args:
        plan: the plan; its modes and commands are taken as they are, its world as modelled.

    Raises:
        InputError: the scenario inside the plan cannot be used, or the plan has no steps.
    """
    from gm_ompl.planfile.fit import problem_of
    from gm_ompl.tolerance.strong import strong  # loads HiGHS

    return strong(plan, problem_of(plan))


def explain(
    scenario: ScenarioLike,
    at: Coordinates | SupportsFloat | None = None,
    placements: PlacementsLike | None = None,
    *,
    samples: SupportsIndex | None = None,
    seed: SupportsIndex = 0,
    time_limit: SupportsFloat = SECONDS,
    memory_limit: SupportsFloat | None = None,
) -> Explanation:
    """Explain why a scenario has no plan on its lattice, or none through coordinates or placements.

    Args:
        scenario: what is to be explained.
        at: object coordinates (d,), on a path also a plain number; None for the whole motion.
        placements: per finger, a row of the placement table or (face, cell); None for many sets.
        samples: sets of placements judged at most; beyond, they are drawn at random.
        seed: of the drawing.
        time_limit: for all of it [s]; 0 for no search.
        memory_limit: resident memory of the process [MiB].

    Raises:
        InputError: coordinates, placements or the scenario do not fit.
        LimitError: a limit is reached before there is anything to tell.
    """
    from gm_ompl.diagnosis.explain import explain

    limit = seconds(time_limit)
    memory = budget(None, None, memory_limit).memory_limit_mb
    with limits.holding(limit or None, memory):
        given = warned(loaded(scenario))
    problem, q = given.problem, None
    prepare(problem)
    if at is not None:
        q = coordinates("at", [at] if isinstance(at, numbers.Real) else at, problem)
    if samples is not None:
        samples = whole("samples", samples, 1)
    seed = whole("seed", seed, 0)
    rows = None if placements is None else placed(problem, placements)
    with limits.holding(None, memory):
        return explain(given, q, rows, samples=samples, seed=seed, seconds=limit)
