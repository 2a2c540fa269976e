"""The public functions: load a scenario, plan it, check a plan, judge one instant."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from gm_ompl import clock
from gm_ompl.errors import InputError
from gm_ompl.explain.values import SECONDS
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Verdict
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.arc import Moment
from gm_ompl.plan.assemble import assemble
from gm_ompl.plan.model import Plan
from gm_ompl.planners.planner import Budget, Report, SearchResult, Status, silent
from gm_ompl.planners.prepare import prepare
from gm_ompl.planners.price import at_true_cost, priced
from gm_ompl.planners.registry import make_planner
from gm_ompl.planners.steady import steady_moves
from gm_ompl.problem import Move, Problem
from gm_ompl.scenario.load import load as load_scenario
from gm_ompl.scenario.scenario import Scenario

if TYPE_CHECKING:
    from gm_ompl.check.report import CheckReport
    from gm_ompl.explain.values import Explanation

ScenarioLike: TypeAlias = Scenario | str | os.PathLike[str]
"""A loaded scenario, a shipped name, or a file."""

PlacementLike: TypeAlias = int | tuple[str, Sequence[int]]
"""A row of the placement table, or (face, cell), for example ``("-x", (3, 2))``."""


def load(name_or_path: str | os.PathLike[str], overrides: Iterable[str] = ()) -> Scenario:
    """Return the scenario of a shipped name ("paper/slide"), a random family's, or a file.

    Args:
        name_or_path: the name, or the file.
        overrides: "KEY=VALUE", each replacing a value; KEY is a dotted path, list items by
            number, VALUE is read as YAML: ``["fingers.max_normal_force=5"]``.

    Raises:
        ScenarioError: no such scenario, or one line per mistake in it.
    """
    return load_scenario(name_or_path, overrides)


def plan(
    scenario: ScenarioLike,
    planner: str = "astar",
    *,
    time_limit: float | None = None,
    max_iterations: int | None = None,
    memory_limit: float | None = None,
    seed: int = 0,
    parameters: Mapping[str, Any] | None = None,
    report: Report | None = None,
) -> Plan:
    """Plan a scenario.

    Ctrl-C ends the search and returns what is known, with the status "interrupted".

    Args:
        scenario: what to plan.
        planner: its name.
        time_limit: wall time [s]; None is no limit.
        max_iterations: node expansions, or a sampling planner's own iterations.
        memory_limit: resident memory of the process [MiB].
        seed: of randomised planners.
        parameters: the planner's own parameters.
        report: called now and then with the search's progress.

    Returns:
        The plan, or why there is none: see ``Plan.status``.

    Raises:
        InputError: the scenario, the planner's name or a limit is wrong.
    """
    searcher = make_planner(planner, parameters)
    budget = _budget(time_limit, max_iterations, memory_limit)
    if seed < 0:
        raise InputError(f"seed: {seed}: must be a whole number >= 0")
    given = _loaded(scenario)
    problem = given.problem
    rng = np.random.default_rng(seed)
    started, moves = clock.now(), tuple[Move, ...]()
    fallbacks = 0
    try:
        judging = _judge(priced(problem))
        result = searcher.solve(judging.problem, judging, budget, rng, report or silent)
        fallbacks = judging.backend.fallbacks
        moves = at_true_cost(problem, _steady(judging, result.moves))
    except KeyboardInterrupt:  # before the search could begin, or twice
        spent = {"time_s": clock.now() - started, "expanded": 0, "mode_decisions": 0}
        result = SearchResult(Status.INTERRUPTED, statistics={**spent, "history": []})
    return assemble(
        problem,
        given.resolved(),
        moves,
        status=result.status.value,
        planner=planner,
        statistics={**result.statistics, "fallback_decisions": fallbacks},
        seed=seed,
        parameters=searcher.settings,
        optimal=result.optimal,
        lower_bound=result.lower_bound,
    )


def check(plan: Plan) -> CheckReport:
    """Judge a plan anew, from the scenario inside it alone, with HiGHS.

    Returns:
        Per step what holds, and every violation with its reason; ``holds`` sums it up.

    Raises:
        ScenarioError: the scenario inside the plan cannot be used.
    """
    from gm_ompl.check.check import check  # loads HiGHS

    return check(plan)


def judge(
    scenario: ScenarioLike,
    q: Sequence[float] | None = None,
    direction: Sequence[float] | None = None,
    placements: Sequence[PlacementLike] = (),
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
        InputError: coordinates or placements do not fit the scenario, or both forms are mixed.
    """
    problem = _loaded(scenario).problem
    moment, rows = _moment(problem, q, direction, pose, twist), _rows(problem, placements)
    return _judge(problem).segment(moment, rows)


def _moment(
    problem: Problem,
    q: Sequence[float] | None,
    direction: Sequence[float] | None,
    pose: Pose | None,
    twist: Twist | None,
) -> Moment:
    if (q is None) == (pose is None) or (pose is None and twist is not None):
        raise InputError("judge: give either q (and direction) or pose (and twist)")
    if pose is not None:
        if direction is not None:
            raise InputError("judge: direction: goes with q; with pose, give twist")
        return Moment(pose, twist)
    assert q is not None
    _fit("q", q, problem)
    if direction is not None:
        _fit("direction", direction, problem)
    return problem.motion.moment(q, direction)


def explain(
    scenario: ScenarioLike,
    at: Sequence[float] | float | None = None,
    placements: Sequence[PlacementLike] | None = None,
    *,
    samples: int | None = None,
    seed: int = 0,
    time_limit: float = SECONDS,
) -> Explanation:
    """Explain why a scenario has no plan on its lattice, or none through coordinates or placements.

    Args:
        scenario: what is to be explained.
        at: object coordinates (d,), on a path also a plain number; None for the whole motion.
        placements: per finger, a row of the placement table or (face, cell); None for many sets.
        samples: sets of placements judged at most; beyond, they are drawn at random.
        seed: of the drawing.
        time_limit: for all of it [s]; 0 for no search.

    Raises:
        InputError: coordinates, placements or the scenario do not fit.
    """
    from gm_ompl.explain.explain import explain

    if not (math.isfinite(time_limit) and time_limit >= 0):
        raise InputError(f"time limit: {time_limit}: must be a number of seconds >= 0")
    given = _loaded(scenario)
    problem, q = given.problem, None
    prepare(problem)
    if at is not None:
        q = (float(at),) if isinstance(at, (int, float)) else tuple(map(float, at))
        _fit("at", q, problem)
        motion = problem.motion
        bounds = zip(motion.low, motion.high, motion.periods, strict=True)
        for value, (low, high, period) in zip(q, bounds, strict=True):
            if period is None and not low <= value <= high:
                raise InputError(f"at: {list(q)}: {value:g} must be from {low:g} to {high:g}")
    rows = None if placements is None else _rows(problem, placements)
    return explain(given, q, rows, samples=samples, seed=seed, seconds=time_limit)


def _steady(judging: Judge, moves: tuple[Move, ...]) -> tuple[Move, ...]:
    """Return a planner's moves under steady control; as they are where that is interrupted."""
    try:
        return steady_moves(judging, moves)
    except KeyboardInterrupt:
        return moves


def _loaded(scenario: ScenarioLike) -> Scenario:
    return scenario if isinstance(scenario, Scenario) else load(scenario)


def _judge(problem: Problem) -> Judge:
    prepare(problem)
    return Judge(problem, make_backend(problem))


def _budget(
    time_limit: float | None, max_iterations: int | None, memory_limit: float | None
) -> Budget:
    for name, value, unit in (
        ("time limit", time_limit, "seconds"),
        ("max iterations", max_iterations, "iterations"),
        ("memory limit", memory_limit, "MiB"),
    ):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise InputError(f"{name}: {value}: must be a positive number of {unit}")
    return Budget(time_limit, max_iterations, memory_limit)


def _fit(name: str, values: Sequence[float], problem: Problem) -> None:
    wanted = ", ".join(problem.motion.names)
    if len(values) != problem.motion.dimension or not all(map(math.isfinite, values)):
        raise InputError(f"{name}: {list(values)}: must be finite numbers for ({wanted})")


def _rows(problem: Problem, placements: Sequence[PlacementLike]) -> tuple[int, ...]:
    """Return the placements' rows in the table."""
    table, count = problem.fingers.placements, problem.fingers.count
    if len(placements) != count:
        raise InputError(f"placements: {len(placements)} given; the scenario has {count} fingers")
    rows = []
    for finger, place in enumerate(placements):
        row = place if isinstance(place, int) else table.find(*place)
        if row is None or not 0 <= row < len(table):
            raise InputError(
                f"placements[{finger}]: {place}: no such placement; there are {len(table)}, "
                f"on the faces {', '.join(table.labels)}"
            )
        rows.append(row)
    return tuple(rows)
