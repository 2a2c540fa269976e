"""For users of OMPL: a scenario as ``og.SimpleSetup``, and its solution as a Plan."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, SupportsIndex

import numpy as np

from gm_ompl import clock
from gm_ompl.arguments import whole
from gm_ompl.errors import InputError, PathError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.ways import with_ways
from gm_ompl.hand.paths import JointPaths
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.joint_paths import JointPlanner
from gm_ompl.planners.joints import in_words
from gm_ompl.planners.ompl.run import judged_anew
from gm_ompl.planners.ompl.setup import HybridSetup
from gm_ompl.planners.ompl.table import refuse_unsound
from gm_ompl.planners.prepare import prepare
from gm_ompl.planners.registry import make_planner
from gm_ompl.planners.steady import steady_moves
from gm_ompl.problem import Move
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario


def setup(
    scenario: Scenario | str | os.PathLike[str] | Mapping[str, Any],
    planner: str | None = None,
    *,
    seed: SupportsIndex = 0,
    parameters: Mapping[str, Any] | None = None,
) -> HybridSetup:
    """Return a scenario as OMPL's ``og.SimpleSetup``, ready to be solved.

    State space, state validity, directed motion validity, objective, start and goal are set.
    Set any planner of OMPL that is sound for one-way motion, or name one here.

    Args:
        scenario: what to plan: a loaded scenario, a shipped name, a file, or a mapping.
        planner: any name that ``gm_ompl.plan`` takes; None is "RRTConnect".
        seed: of OMPL's random numbers and ours. OMPL's are global: of two setups, the last counts.
        parameters: the planner's own parameters.

    Raises:
        InputError: the scenario, the planner's name or a parameter is wrong.
    """
    seed = whole("seed", seed, 0)
    searcher = make_planner(planner or "RRTConnect", parameters)
    given = scenario if isinstance(scenario, Scenario) else load(scenario)
    prepare(given.problem)
    judge = Judge(given.problem, make_backend(given.problem))
    made = HybridSetup(judge, np.random.default_rng(seed))
    made.scenario, made.seed = given.resolved(), seed
    made.use(searcher, made.draws.goals if planner is None else None)
    return made


def plan_from(setup: Any) -> Plan:
    """Return the plan that a solved setup has found.

    Its path is expanded into moves and judged anew.

    Args:
        setup: made by ``gm_ompl.setup``.

    Returns:
        The plan, or why there is none: see ``Plan.status``.

    Raises:
        InputError: ``setup`` was not made by ``gm_ompl.setup``.
        UnsoundPlannerError: its planner ignores that motions are one-way.
        PathError: its path cannot be executed, or a hand's joints find no way along it.
    """
    if not isinstance(setup, HybridSetup) or setup.scenario is None:
        raise InputError(f"plan_from: {type(setup).__name__}: must be made by gm_ompl.setup")
    refuse_unsound(setup.getPlanner())
    started, problem = clock.now(), setup.judge.problem
    states = setup.solution()
    found = () if states is None else judged_anew(problem, states)
    steady = steady_moves(setup.judge, found)
    paths = _joint_paths(setup, steady.moves)
    moves = with_ways(setup.judge.reach, steady.moves)
    spent = setup.spent + clock.now() - started
    ending = setup.ending()
    statistics = {
        "time_s": spent,
        "expanded": setup.motions.asked,
        "valid_motions": setup.motions.valid,
        "mode_decisions": setup.judge.mode_decisions,
        "history": [[spent, sum(move.cost for move in moves) if states else None, None]],
        **ending.statistics,
        **steady.statistics(),
    }
    return assemble(
        problem,
        setup.scenario,
        moves,
        status="solved" if states is not None else ending.status.value,
        planner=setup.getPlanner().getName(),
        statistics=statistics,
        seed=setup.seed,
        parameters=setup.parameters(),
        optimal=ending.optimal,
        lower_bound=ending.lower_bound,
        paths=paths,
    )


def _joint_paths(setup: HybridSetup, moves: tuple[Move, ...]) -> JointPaths | None:
    """Return a hand's joint paths along moves; None where there is no hand, or nothing moves."""
    if setup.judge.hand is None or not moves:
        return None
    found = JointPlanner(setup.judge, np.random.default_rng(setup.seed)).paths(moves)
    if isinstance(found, JointPaths):
        return found
    raise PathError(
        f"plan_from: no joint paths: {in_words(found)}; solve with another seed, or use "
        "gm_ompl.plan, which searches on"
    )
