"""The public functions: load a scenario, plan it, check a plan, judge one instant."""

from __future__ import annotations

import math
import numbers
import os
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, SupportsFloat, SupportsIndex, TypeAlias

import numpy as np

from gm_ompl import clock, limits
from gm_ompl.arguments import finite, kind_of, whole
from gm_ompl.asking import Coordinates, PlacementsLike, budget, coordinates, placed, seconds
from gm_ompl.diagnosis.values import SECONDS
from gm_ompl.errors import InputError, LimitError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Verdict
from gm_ompl.feasibility.ways import with_ways
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.arc import Moment
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.planner import Budget, Planner, Report, SearchResult, Status, silent
from gm_ompl.planners.prepare import prepare
from gm_ompl.planners.price import at_true_cost, priced
from gm_ompl.planners.registry import make_planner, suited
from gm_ompl.planners.steady import Steady, steady_moves
from gm_ompl.problem import Move, Problem
from gm_ompl.scenario.load import load as load_scenario
from gm_ompl.scenario.overrides import Changes
from gm_ompl.scenario.scenario import Scenario

if TYPE_CHECKING:
    from gm_ompl.checking.report import CheckReport
    from gm_ompl.diagnosis.values import Explanation

STEADY_SECONDS = 0.5
"""What steady control may take after a search with a time limit [s]."""

ScenarioLike: TypeAlias = Scenario | str | os.PathLike[str] | Mapping[str, Any]
"""A loaded scenario, a shipped name, a file, or a mapping with a file's keys."""


def load(
    name_or_path: str | os.PathLike[str] | Mapping[str, Any], overrides: Changes = ()
) -> Scenario:
    """Return the scenario of a shipped name ("paper/slide"), a random family's, or a file.

    Args:
        name_or_path: the name, or the file; or a mapping with a file's keys, whose numbers and
            arrays may be numpy's.
        overrides: what replaces values: "KEY=VALUE", where KEY is a dotted path, list items by
            number, and VALUE is read as YAML; a list of such; or values by their keys:
            ``{"fingers.max_normal_force": 5}``.

    Raises:
        ScenarioError: no such scenario, or one line per mistake in it.
    """
    return load_scenario(name_or_path, overrides)


def plan(
    scenario: ScenarioLike,
    planner: str = "astar",
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
        planner: its name.
        time_limit: wall time for all of it [s]; None is no limit.
        max_iterations: node expansions, or a sampling planner's own iterations.
        memory_limit: resident memory of the process [MiB].
        seed: of randomised planners.
        parameters: the planner's own parameters.
        report: called now and then with the search's progress.

    Returns:
        The plan, or why there is none: see ``Plan.status``.

    Raises:
        InputError: the scenario, the planner's name or a limit is wrong.
        LimitError: a limit is reached before the scenario is loaded.
    """
    searcher = make_planner(planner, parameters)
    asked, seed = budget(time_limit, max_iterations, memory_limit), whole("seed", seed, 0)
    with limits.holding(asked.time_limit, asked.memory_limit_mb):
        given = _warned(loaded(scenario))
        suited(searcher, given.problem)
        return _planned(given, searcher, asked, seed, report or silent)


def _planned(given: Scenario, searcher: Planner, asked: Budget, seed: int, report: Report) -> Plan:
    problem = given.problem
    rng = np.random.default_rng(seed)
    started, moves = clock.now(), tuple[Move, ...]()
    steady, fallbacks, pockets = Steady((), ()), 0, 0
    try:
        judging = _judge(priced(problem))
        result = searcher.solve(judging.problem, judging, asked, rng, report)
        fallbacks, pockets = judging.backend.fallbacks, judging.reach.pockets
        steady = _finished(judging, result.moves)
        moves = at_true_cost(problem, steady.moves)
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
    )


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


def judge(
    scenario: ScenarioLike,
    q: Coordinates | None = None,
    direction: Coordinates | None = None,
    placements: PlacementsLike = (),
    *,
    pose: Pose | None = None,
    twist: Twist | None = None,
) -> Verdict:
    """Judge one instant (Sec. 4.2): geometry, the choice of modes, and the margin z.

    The instant is given by the scenario's coordinates (``q``, ``direction``) or, whatever the
    scenario's motion, by ``pose`` and ``twist``.

    Args:
        scenario: where it happens.
        q: object coordinates (d,): ``[s]`` on a path, ``[x, y, yaw]`` in the plane.
        direction: of the object's motion (d,); None at rest.
        placements: per finger, a row of the placement table or (face, cell).
        pose: instead of ``q``, where the object is.
        twist: with ``pose``, the object's velocity, of any magnitude; None at rest.

    Raises:
        InputError: coordinates or placements do not fit the scenario (a path's s is from 0 to 1,
            planar coordinates lie in their ranges), or both forms are mixed.
    """
    problem = loaded(scenario).problem
    moment, rows = _moment(problem, q, direction, pose, twist), placed(problem, placements)
    return _judge(problem).segment(moment, rows)


def _moment(
    problem: Problem,
    q: Coordinates | None,
    direction: Coordinates | None,
    pose: Pose | None,
    twist: Twist | None,
) -> Moment:
    for name, value, kind in (("pose", pose, Pose), ("twist", twist, Twist)):
        if not (value is None or isinstance(value, kind)):
            raise InputError(f"judge: {name}: {kind_of(value)}: must be a gm_ompl.{kind.__name__}")
    if (q is None) == (pose is None) or (pose is None and twist is not None):
        raise InputError("judge: give either q (and direction) or pose (and twist)")
    if pose is not None:
        if direction is not None:
            raise InputError("judge: direction: goes with q; with pose, give twist")
        return Moment(pose, twist)
    moving = None if direction is None else finite("direction", direction, problem.motion.names)
    return problem.motion.moment(coordinates("q", q, problem), moving)


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
        given = _warned(loaded(scenario))
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


def _finished(judging: Judge, moves: tuple[Move, ...]) -> Steady:
    """Return a planner's moves under steady control and with ways through the air.

    A search that used its time up leaves none for control: it gets a little of its own.
    """
    try:
        with limits.lifted(STEADY_SECONDS if limits.left() < math.inf else None):
            steady = steady_moves(judging, moves)
    except (KeyboardInterrupt, LimitError):
        steady = Steady(moves, None)
    with limits.lifted():  # a plan that was found is not lost
        return steady._replace(moves=with_ways(judging.reach, steady.moves))


def loaded(scenario: ScenarioLike) -> Scenario:
    """Return the scenario itself, whatever way it is given in."""
    return scenario if isinstance(scenario, Scenario) else load(scenario)


def _warned(scenario: Scenario) -> Scenario:
    """Return the scenario after a warning for everything in it that looks like a mistake."""
    for warning in scenario.warnings:
        warnings.warn(warning, stacklevel=3)
    return scenario


def _judge(problem: Problem) -> Judge:
    prepare(problem)
    return Judge(problem, make_backend(problem))
