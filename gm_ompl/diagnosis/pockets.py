"""Which fingertips cannot come to where they touch, or could not get away."""

from __future__ import annotations

from gm_ompl.diagnosis.instants import Explainer
from gm_ompl.diagnosis.regions import names
from gm_ompl.diagnosis.values import InstantLine
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements


def pocket_line(explainer: Explainer, q: Coordinates, placements: Placements) -> InstantLine | None:
    """Return which fingertips cannot come to the object at rest; None where all can.

    At the start those with a given placement are there already.
    """
    problem, reach = explainer.problem, explainer.judge.reach
    pose = problem.motion.pose(q)
    standing = problem.fingers.standing if tuple(q) == tuple(problem.start) else ()
    if not explainer.judge.placements_valid(pose, placements):
        return None
    if reach.landing(pose, placements, standing) is not None:
        return None
    shown = names(problem, placements)
    blocked = tuple(
        f"finger {i} at {shown[i]} is in a pocket: no way through the air leads there"
        for i, row in enumerate(placements)
        if i not in standing and not reach.outside(pose, i, (), row)
    )
    each_other = "the fingertips are in a pocket of their own making: they can touch in no order"
    return InstantLine(
        q=tuple(q), direction=None, finding=Finding.POCKET, blocked_by=blocked or (each_other,)
    )
