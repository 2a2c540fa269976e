"""What is proven before any search: that no plan can begin, or end."""

from __future__ import annotations

from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.goals import has_set, some_set
from gm_ompl.motion.free import FreeMotion
from gm_ompl.problem import Problem


def impossible(problem: Problem, judge: Judge) -> bool:
    """Whether it is proven that no plan exists: no set is valid at the start, or at the goal.

    Of a goal that is a region, free motion is asked for placements that may be free there.
    """
    hand, pose = problem.fingers, problem.motion.pose
    if not has_set(judge, pose(problem.start), hand.start):
        return True
    if isinstance(problem.motion, FreeMotion):
        from gm_ompl.graph.goal_sets import GoalSets  # other motions need nothing of it

        return not some_set(judge, GoalSets(judge).free(), hand.goal)
    low, high = problem.goal.low, problem.goal.high
    if None in low or low != high:
        return False
    goal = tuple(float(value or 0.0) for value in low)
    return not has_set(judge, pose(goal), hand.goal)
