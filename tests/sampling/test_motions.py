"""The expansion of a motion between two states."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

import gm_ompl
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.ompl.motions import MacroMotions
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Displacement, Move, Problem, Regrasp
from gm_ompl.sampling.motions import UNPLACED, CoordinateModel, HybridState
from gm_ompl.sampling.stages import after


def _optimal(problem: Problem, judge: Judge) -> tuple[Move, ...]:
    rng = np.random.default_rng(0)
    return make_planner("astar").solve(problem, judge, Budget(), rng).moves


@pytest.mark.parametrize("name", ["slide", "tumble", "regrasp", "chain"])
def test_a_lattice_plan_expands_to_itself(
    name: str, small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """Arc by arc the expansion gives the lattice's moves, costs and decisions."""
    problem = small(name)
    judge = new_judge(problem)
    moves = _optimal(problem, judge)
    assert moves
    model = CoordinateModel(problem, new_judge(problem))
    motions = MacroMotions(model, model.start_state())
    for move in moves:
        if isinstance(move, Regrasp):
            here, there = (
                HybridState(move.at, move.placements), HybridState(move.at, after(move))
            )  # fmt: skip
        else:
            here = HybridState(move.start, move.placements)
            there = HybridState(move.end, move.placements)
        found = motions.expand(here, there)
        assert found is not None
        assert len(found) == 1
        assert found[0].cost == pytest.approx(move.cost, rel=1e-6)
        assert model.least_cost(here, there) <= move.cost * (1 + 1e-9)


def test_a_plan_of_long_arcs_passes_the_check(
    small: Callable[[str], Problem],
    new_judge: Callable[[Problem], Judge],
    as_plan: Callable[[str, Sequence[Move]], Plan],
) -> None:
    """One expansion per set of placements gives a plan that holds and is no dearer."""
    problem = small("regrasp")
    judge = new_judge(problem)
    moves = _optimal(problem, judge)
    at = next(move for move in moves if isinstance(move, Regrasp))
    model = CoordinateModel(problem, judge)
    motions = MacroMotions(model, model.start_state())
    first = motions.expand(model.start_state(), HybridState(at.at, at.placements))
    last = HybridState((1.0,), moves[-1].placements)
    second = motions.expand(HybridState(at.at, at.placements), last)
    assert first is not None
    assert second is not None
    assert model.in_goal(last)
    optimum = sum(move.cost for move in moves)
    assert sum(move.cost for move in first + second) <= optimum * (1 + 1e-9)
    assert gm_ompl.check(as_plan("regrasp", first + second)).holds


def test_a_displacement_is_split_where_pieces_meet(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """Over all pieces there is one displacement per piece, each with its own (9)."""
    problem = small("chain")
    judge = new_judge(problem)
    moves = _optimal(problem, judge)
    assert all(isinstance(move, Displacement) for move in moves)
    found = CoordinateModel(problem, judge).displacement((0.0,), (1.0,), moves[0].placements)
    assert found is not None
    assert [move.end for move in found] == [*((b,) for b in problem.motion.breakpoints[0]), (1.0,)]


def test_motions_are_directed(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """Two fingers behind the box push it onwards; backwards they cannot."""
    problem = small("slide")
    table = problem.fingers.placements
    behind = (table.find("-x", (0, 0)), table.find("-x", (1, 0)))
    assert None not in behind
    placements = tuple(int(row or 0) for row in behind)
    model = CoordinateModel(problem, new_judge(problem))
    assert model.displacement((0.0,), (1.0,), placements) is not None
    assert model.displacement((1.0,), (0.0,), placements) is None


def test_what_is_refused(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """No finger gets unplaced; two fingers on one placement, or one that stays, do not regrasp."""
    problem = small("slide")
    model = CoordinateModel(problem, new_judge(problem))
    motions = MacroMotions(model, model.start_state())
    state = HybridState((0.0,), (0, 4))
    assert motions.expand(state, HybridState((0.5,), (0, UNPLACED))) is None
    assert model.regrasp((0.0,), (0, 4), 1, 0) is None
    assert model.regrasp((0.0,), (0, 4), 1, 4) is None
    assert not model.state_valid((0.0,), (0, 0))
