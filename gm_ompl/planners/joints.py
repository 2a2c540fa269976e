"""Searches again until a plan is found along which the hand's joints find their way.

Planners ask what each finger's chain reaches; what the whole hand does along a plan is only asked
of plans that were found. Where it fails, the finger that cannot is taken off its placement along
that arc and beside that pose, and the search begins anew. Nothing is then proven optimal, and no
plan proven not to exist: both are over what inverse kinematics with its restarts reached.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from gm_ompl import clock, limits
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.hand.paths import JointPaths, JointRefusal
from gm_ompl.planners.again import added, left, settled
from gm_ompl.planners.joint_paths import JointPlanner
from gm_ompl.planners.planner import Budget, Planner, SearchResult, Status
from gm_ompl.planners.steady import Steady
from gm_ompl.problem import Displacement, Move

SEARCHES = 100
"""At most."""


def jointed(
    searcher: Planner,
    judge: Judge,
    result: SearchResult,
    steady: Steady,
    budget: Budget,
    rng: np.random.Generator,
) -> tuple[SearchResult, Steady, JointPaths | None]:
    """Return how searches ended, their plan under steady control, and its joint paths.

    Args:
        searcher: has searched, and may again.
        judge: of a problem with a hand.
        result: of the first search.
        steady: its plan.
        budget: what all searches together may spend.
        rng: the only source of randomness.
    """
    joints = JointPlanner(judge, rng)
    refused, last, began = 0, "", clock.now() - result.statistics["time_s"]
    while steady.moves:
        found = joints.paths(steady.moves)
        if isinstance(found, JointPaths):
            return _told(result, refused, last, began), steady, found
        refused, last = refused + 1, in_words(found)
        _refuse(judge, steady.moves, found)
        budget_left = left(budget, result)
        if budget_left is None or refused == SEARCHES:
            break
        try:
            again = searcher.solve(judge.problem, judge, budget_left, rng)
            again, steady = settled(searcher, judge, again, budget_left, rng)
        except LimitError:
            break
        result = dataclasses.replace(again, statistics=added(result, again))
    if refused:
        result = dataclasses.replace(
            result, status=_without(result.status), moves=(), cost=None, lower_bound=0.0
        )
    return _told(result, refused, last, began), Steady((), ()), None


def _without(status: Status) -> Status:
    """Return how searches ended whose plans were all refused."""
    return Status.INTERRUPTED if status is Status.INTERRUPTED else Status.BUDGET


def _told(result: SearchResult, refused: int, last: str, began: float) -> SearchResult:
    """Return a result that says what the joints took and refused, and claims what is known."""
    more: dict[str, object] = {"time_s": clock.now() - began}
    if not refused:
        return dataclasses.replace(result, statistics={**result.statistics, **more})
    more |= {"joint_refusals": refused, "last_refusal": last}
    if result.status is Status.BUDGET and not limits.reached():
        more["ended_by"] = f"no joint paths: {last}"
    return dataclasses.replace(
        result, optimal=False, lower_bound=0.0, statistics={**result.statistics, **more}
    )


def in_words(found: JointRefusal) -> str:
    """Return who cannot what, and where."""
    return f"finger {found.finger} {found.why}, in step {found.move}"


def _refuse(judge: Judge, moves: tuple[Move, ...], found: JointRefusal) -> None:
    """Take a finger off the placement that it could not keep or reach."""
    move = moves[found.move]
    if isinstance(move, Displacement):
        pose, row = move.arc.pose(found.share), move.placements[found.finger]
        judge.refuse(move.arc, pose, found.finger, row)
    else:
        judge.refuse(None, move.pose, found.finger, move.target)
