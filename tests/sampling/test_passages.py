"""Regrasps anywhere along a way, against a search over every point and every hand."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, final

import numpy as np
import pytest

from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.ompl.draws import StateDraws
from gm_ompl.planners.ompl.motions import MacroMotions
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Displacement, Placements, Problem, Regrasp
from gm_ompl.sampling.lines import same
from gm_ompl.sampling.motions import CoordinateModel, HybridState
from gm_ompl.sampling.passages import regrasping
from gm_ompl.sampling.stages import after, changed, states_along


@final
class Made:
    """A passage whose answers are drawn; its moves are tuples that say what they are."""

    def __init__(self, arcs: int, rng: np.random.Generator) -> None:
        self.arcs, self._rng, self._holds = arcs, rng, float(rng.uniform(0.5, 1.0))
        self._known: dict[Any, bool] = {}

    def _drawn(self, *what: Any) -> bool:
        return self._known.setdefault(what, bool(self._rng.random() < self._holds))

    def carried(self, arc: int, placements: Placements) -> Any:
        return (("arc", arc, placements),) if self._drawn("arc", arc, placements) else None

    def rests(self, point: int, placements: Placements, finger: int) -> bool:
        staying = (*placements[:finger], *placements[finger + 1 :])
        return self._drawn("rest", point, finger, staying)

    def regrasped(self, point: int, placements: Placements, finger: int, target: int) -> Any:
        if not (self.rests(point, placements, finger) and self._drawn("air", point, placements)):
            return None
        return ("regrasp", point, placements, finger, target)


def _reachable(passage: Made, before: Placements, wanted: Placements) -> bool:
    """Whether the last point is reached with ``wanted``, by all points and all hands."""
    hands = list(itertools.product(*({a, b} for a, b in zip(before, wanted, strict=True))))
    reached = {before}
    for point in range(passage.arcs + 1):
        for _ in hands:
            for hand in sorted(reached):
                for i in changed(hand, wanted):
                    if passage.regrasped(point, hand, i, wanted[i]) is not None:
                        reached.add((*hand[:i], wanted[i], *hand[i + 1 :]))
        if point < passage.arcs:
            reached = {hand for hand in reached if passage.carried(point, hand) is not None}
    return wanted in reached


@pytest.mark.parametrize("fingers", [1, 2, 3])
def test_found_where_there_is_a_way_and_only_there(fingers: int) -> None:
    """On random answers regrasps are found exactly where trying everything finds some."""
    found = 0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        passage = Made(int(rng.integers(0, 6)), rng)
        before = tuple(range(fingers))
        wanted = tuple(k + 10 * int(rng.integers(0, 2)) for k in before)
        moves: Any = regrasping(passage, before, wanted)
        assert (moves is not None) is _reachable(passage, before, wanted)
        if moves is None:
            continue
        found += 1
        point, hand = 0, before
        for move in moves:
            if move[0] == "arc":
                assert move == ("arc", point, hand)
                point += 1
            else:
                assert move[:3] == ("regrasp", point, hand)
                assert passage.regrasped(*move[1:]) is not None
                hand = (*hand[: move[3]], move[4], *hand[move[3] + 1 :])
        assert (point, hand) == (passage.arcs, wanted)
        assert sum(move[0] == "regrasp" for move in moves) == len(changed(before, wanted))
    assert 40 < found < 400


def test_the_optimal_regrasp_is_in_the_middle_of_a_motion(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """From the optimal plan's first hand to its last, start to goal, is one motion."""
    problem = small("regrasp")
    judge = new_judge(problem)
    moves = make_planner("astar").solve(problem, judge, Budget(), np.random.default_rng(0)).moves
    states = list(states_along(moves))
    motions = MacroMotions(CoordinateModel(problem, judge), states[0])
    found = motions.expand(states[0], states[-1])
    assert found is not None
    at = [move for move in found if isinstance(move, Regrasp)]
    assert len(at) == 1
    assert states[0].q < at[0].at < states[-1].q
    assert sum(move.cost for move in found) <= 1.05 * sum(move.cost for move in moves)
    ends = [HybridState(at[0].at, hand) for hand in (at[0].placements, after(at[0]))]
    parts = [(states[0], ends[0]), ends, (ends[1], states[-1])]
    assert all(motions.expand(*part) is not None for part in parts)


def test_a_planar_motion_changes_a_finger_where_it_may(
    small: Callable[[str], Problem], new_judge: Callable[[Problem], Judge]
) -> None:
    """With more coordinates, too, at its end if not before; each move follows on the last."""
    problem = small("turn")
    model = CoordinateModel(problem, new_judge(problem))
    rng, rows = np.random.default_rng(1), len(problem.fingers.placements)
    motions = MacroMotions(model, model.start_state())
    hand = StateDraws(motions, rng).goal()
    assert hand is not None
    early = late = 0
    for _ in range(100):
        finger, row = int(rng.integers(2)), int(rng.integers(rows))
        other = (*hand.placements[:finger], row, *hand.placements[finger + 1 :])
        here = HybridState(problem.start, hand.placements)
        for move in motions.expand(here, HybridState(hand.q, other)) or ():
            if isinstance(move, Displacement):
                assert (move.start, move.placements) == here
                here = HybridState(move.end, move.placements)
            else:
                assert (move.at, move.placements) == here
                here, ends = HybridState(move.at, after(move)), (move.at, hand.q)
                early, late = early + (move.at == problem.start), late + same(problem, *ends)
    assert early > 0
    assert late > 0
