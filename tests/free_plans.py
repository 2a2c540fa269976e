"""Plans with free motion, found by the plain search, for tests."""

from __future__ import annotations

from functools import cache

import numpy as np

from gm_ompl.geometry.pose import Pose
from gm_ompl.plain.search import plain_search
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from tests.airborne import airborne
from tests.free_scenes import (
    ACROSS,
    DEGREE,
    free_problem,
    over_and_against,
    steps,
    up_to_a_wall,
)


def tilted() -> Problem:
    """A turn in two arcs, the second of which begins off the grid of translations."""
    end = Pose(np.eye(3), np.array([0, 0, 0.5])).turned([0.5, 0, 0], ACROSS, 30 * DEGREE)
    return over_and_against(goal=end.position.tolist(), by=steps(rotation=15.0))


def in_the_way() -> Problem:
    """The goal is where the object is."""
    return free_problem(goal=(0, 0, 0.5))


SCENES = {
    "lean": over_and_against, "slide": up_to_a_wall, "tilted": tilted, "there": in_the_way,
}  # fmt: skip


@cache
def solved(scene: str) -> tuple[Problem, Plan]:
    """A scene's problem and its optimal plan."""
    problem = SCENES[scene]()
    found = plain_search(problem)
    moves = airborne(problem, found.moves)
    statistics = {
        "time_s": 0.0, "expanded": 0, "mode_decisions": 0, "history": [],
        "failing_junctions": None,  # the plain search does not judge them
    }  # fmt: skip
    plan = assemble(
        problem, {}, moves, status="solved", planner="plain", statistics=statistics,
        optimal=True, lower_bound=found.cost,
    )  # fmt: skip
    return problem, plan
