"""What decides where a problem asks for more than the plain question of Sec. 3.4."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gm_ompl.arrays import Array
from gm_ompl.feasibility.keys import spots
from gm_ompl.mechanics.columns import hand_columns
from gm_ompl.problem import Problem

if TYPE_CHECKING:
    from gm_ompl.feasibility.case_decider import CaseDecider
    from gm_ompl.feasibility.strong_decider import StrongDecider


def deciders(problem: Problem, U: Array) -> tuple[CaseDecider | None, StrongDecider | None]:
    """Return what decides all cases at once, and by z_strong; each is loaded where it is asked for.

    Args:
        problem: whose.
        U: (6, 6), see ``wrench_norm``.
    """
    cases, strong = None, None
    if problem.uncertainty:
        from gm_ompl.feasibility.case_decider import CaseDecider

        cases = CaseDecider(problem, U)
    if problem.mechanics.strong:
        from gm_ompl.feasibility.strong_decider import StrongDecider

        strong = StrongDecider(problem, U)
    return cases, strong


def tips_for_cuts(problem: Problem, U: Array, cases: CaseDecider | None) -> Array:
    """Return all fingers' columns for unit normal force at all placements (n, P, s, 6).

    Of several cases the first one's: what bounds one case bounds the worst.
    """
    if cases is not None:
        tips: Array = cases.tips.tables[0]
        return tips
    hand, s = problem.fingers, problem.mechanics.cone_edges
    return hand_columns(*spots(problem), hand.friction, hand.soft, s, U)
