"""Refinement of any planner's plan under a budget."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.moves import Move
from gm_ompl.planners.planner import Budget
from gm_ompl.problem import Problem
from gm_ompl.sampling.refine import Refinement


def refine(
    problem: Problem,
    judge: Judge,
    moves: Sequence[Move],
    budget: Budget,
    rng: np.random.Generator,
) -> tuple[Move, ...]:
    """Return a plan that is at most as dear as ``moves``, judged anew; see ``sampling.refine``.

    Ctrl-C ends the refinement and returns the best plan so far.

    Args:
        problem: what was planned.
        judge: answers about it.
        moves: a plan from start to goal.
        budget: what may be spent; an iteration is one random change.
        rng: the source of randomness.
    """
    if not moves:
        return ()
    meter, tried = budget.start(), 0
    refinement = Refinement(problem, judge, moves, rng)
    try:
        refinement.tidy(meter.spent)
        while not meter.spent(tried):
            refinement.step()
            tried += 1
    except KeyboardInterrupt:
        pass  # what was reached so far is kept
    return refinement.moves
