"""Refinement is never dearer, and its plans hold."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

import gm_ompl
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.hybrid_planners import refine
from gm_ompl.planners.ompl.motions import MacroMotions
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Move, Problem, Regrasp
from gm_ompl.sampling.motions import CoordinateModel, HybridState


def _cost(moves: Sequence[Move]) -> float:
    return math.fsum(move.cost for move in moves)


@pytest.mark.parametrize("name", ["tumble", "regrasp", "turn"])
@pytest.mark.parametrize("seed", [0, 1])
def test_refined_plans_hold_and_are_not_dearer(
    name: str,
    seed: int,
    small: Callable[[str], Problem],
    new_judge: Callable[[Problem], Judge],
    as_plan: Callable[[str, Sequence[Move]], Plan],
) -> None:
    """A first plan gets cheaper or stays; the check accepts what comes out."""
    problem = small(name)
    judge = new_judge(problem)
    rng = np.random.default_rng(seed)
    budget = Budget(max_iterations=300)
    found = make_planner("HybridRRT").solve(problem, judge, budget, rng)
    assert found.moves
    moves = refine(problem, judge, found.moves, Budget(max_iterations=25), rng)
    assert _cost(moves) <= _cost(found.moves)
    assert gm_ompl.check(as_plan(name, moves)).holds


def test_needless_regrasps_are_dropped(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """Regrasps to and fro on the way of a set that holds throughout disappear at once."""
    problem = small("slide")
    judge = new_judge(problem)
    rng = np.random.default_rng(0)
    good = make_planner("astar").solve(problem, judge, Budget(), rng).moves[0].placements
    model = CoordinateModel(problem, judge)
    motions = MacroMotions(model, model.start_state())
    plan = None
    for row in range(len(problem.fingers.placements)):
        other = (good[0], row)
        states = [
            HybridState((s,), p) for s, p in ((0.0, good), (0.5, good), (0.5, other), (0.5, good))
        ]
        parts = [motions.expand(a, b) for a, b in itertools.pairwise(states)]
        last = motions.expand(states[-1], HybridState((1.0,), good))
        if row not in good and last is not None and None not in parts:
            plan = [move for part in [*parts, last] for move in part or ()]
            break
    assert plan is not None
    assert sum(isinstance(move, Regrasp) for move in plan) == 2
    moves = refine(problem, judge, plan, Budget(max_iterations=1), rng)
    assert not any(isinstance(move, Regrasp) for move in moves)
    assert _cost(moves) < problem.cost.regrasp


def test_nothing_to_refine(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """A plan without moves stays empty."""
    problem = small("slide")
    judge = new_judge(problem)
    assert refine(problem, judge, (), Budget(max_iterations=1), np.random.default_rng(0)) == ()
