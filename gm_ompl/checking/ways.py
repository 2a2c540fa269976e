"""Judges ways through the air: first touches, regrasps, and fingers that leave at the goal."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.checking.hold import named
from gm_ompl.checking.recheck import Recheck
from gm_ompl.checking.report import Findings, listed
from gm_ompl.geometry.pose import Pose
from gm_ompl.plain.air import Air, Freedom
from gm_ompl.planfile.model import RegraspStep
from gm_ompl.problem import Placements


def check_way(
    recheck: Recheck, step: RegraspStep, change: tuple[Placements, int], pose: Pose, found: Findings
) -> None:
    """Judge a regrasping step's way: its ends, and whether every stretch of it is clear.

    Args:
        recheck: of the problem.
        step: the step.
        change: the placements before, and the lifted finger's after.
        pose: where the object is.
        found: takes what is found.
    """
    hand, (rows, target) = recheck.problem.fingers, change
    if step.way is None:
        if hand.transit:
            freedom = recheck.air.goes(pose, rows, step.finger, target)
            why = "" if freedom is Freedom.FREE else f"; {freedom.value}"
            found.check("way", False, f"there is none, and fingers.transit asks for one{why}")
        return
    corners = pose.to_object(np.array(step.way).reshape(-1, 3))
    ends = (rows[step.finger], target)
    if _check_ends(recheck, step.finger, corners, ends, found):
        _check_stretches(recheck, step, (rows, corners), pose, found)


def _check_ends(
    recheck: Recheck, finger: int, corners: Array, ends: tuple[int, int], found: Findings
) -> bool:
    if not found.check("way", len(corners) >= 2, f"it has {len(corners)} corners, not 2 or more"):
        return False
    table, radius = recheck.problem.fingers.placements, recheck.problem.fingers.radius[finger]
    allowed = recheck.tolerances.way * recheck.diagonal
    holds = True
    for name, corner, row in zip(("starts", "ends"), corners[[0, -1]], ends, strict=True):
        centre = table.points[row] - radius * table.normals[row]
        off = float(np.linalg.norm(corner - centre))
        holds = (
            found.check(
                "way",
                off <= allowed,
                f"it {name} {off:.3g} from where the fingertip touches at {named(recheck, row)} "
                f"(allowed {allowed:.3g})",
            )
            and holds
        )
    return holds


def _check_stretches(
    recheck: Recheck, step: RegraspStep, way: tuple[Placements, Array], pose: Pose, found: Findings
) -> None:
    """Sweep every stretch; the first and the last not against the piece touched there.

    Of that it is enough that they do not go through the face that is touched: a convex piece lies
    behind it.
    """
    problem, finger, (rows, corners) = recheck.problem, step.finger, way
    table, target = problem.fingers.placements, len(corners) - 2
    staying = [(i, row) for i, row in enumerate(rows) if i != finger]
    air = Air(problem, pose, finger, staying)
    to = step.to.row(table)
    assert to is not None, "it was judged before"
    touched = {0: int(table.piece[rows[finger]]), target: int(table.piece[to])}
    for k in range(len(corners) - 1):
        (what,) = air.blocked(corners[k : k + 1], corners[k + 1 : k + 2], touched.get(k))
        along = corners[k + 1] - corners[k]
        sinks = [along @ table.normals[rows[finger]]] if k == 0 else []
        sinks += [-along @ table.normals[to]] if k == target else []
        if max(sinks, default=0.0) > recheck.tolerances.way * recheck.diagonal:
            what = "the object"
        found.check(
            "way",
            not what,
            f"between corners {k} and {k + 1}, {listed(np.array(step.way)[k])} and "
            f"{listed(np.array(step.way)[k + 1])}, fingertip {finger} meets {what}",
        )


def check_landing(recheck: Recheck, pose: Pose, rows: Placements, found: Findings) -> None:
    """Judge whether the fingers can touch the object at the start, one after the other."""
    freedom, who = recheck.air.landing(pose, rows, recheck.problem.fingers.standing)
    found.check(
        "first touches",
        freedom is Freedom.FREE,
        f"in no order can all fingers come to their placements; of the fingertip of finger {who}: "
        f"{freedom.value}",
    )


def check_leaving(recheck: Recheck, pose: Pose, rows: Placements, found: Findings) -> None:
    """Judge whether the fingers can leave the object at the goal, one after the other."""
    freedom, who = recheck.air.landing(pose, rows)
    found.check(
        "leaving",
        freedom is Freedom.FREE,
        f"in no order can all fingers leave; of the fingertip of finger {who}: {freedom.value}",
    )
