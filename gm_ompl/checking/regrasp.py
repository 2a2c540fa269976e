"""Judges one regrasping arc: Sec. 4.2, Eq. (10)."""

from __future__ import annotations

from gm_ompl.checking.hold import (
    check_coordinates,
    check_hold,
    check_placement,
    check_placements,
    named,
)
from gm_ompl.checking.recheck import Hold, Recheck
from gm_ompl.checking.report import Findings
from gm_ompl.contact.decision import ControlMode
from gm_ompl.planfile.model import RegraspStep
from gm_ompl.problem import Placements


def check_regrasp(recheck: Recheck, step: RegraspStep, found: Findings) -> None:
    """Judge a regrasping step by itself; note what does not hold."""
    rows = check_placements(recheck, step.placements, found)
    target = check_placement(recheck, "to", step.to, found)
    judged = check_coordinates(recheck, "at", step.at, found) and _check_finger(
        recheck, step, found
    )
    if not judged or rows is None:
        return
    reason = recheck.blocked(recheck.problem.motion.pose(step.at), rows)
    found.check("geometry", reason is None, f"before the regrasp: {reason}")
    if target is not None:
        _check_target(recheck, step, rows, target, found)
    _check_rest(recheck, step, rows, found)
    found.cost = recheck.problem.cost.regrasp
    allowed = recheck.tolerances.cost * found.cost
    found.claim("cost", "cost", (step.cost, found.cost), allowed, where="by Eq. (10)")


def _check_finger(recheck: Recheck, step: RegraspStep, found: Findings) -> bool:
    """Judge which finger is lifted and the lists with one entry per finger."""
    count, finger = recheck.problem.fingers.count, step.finger
    if not found.check(
        "lifted finger",
        finger < count,
        f"finger {finger} is lifted; the hand's fingers are 0 to {count - 1}",
    ):
        return False
    sizes = (len(step.modes), len(step.f_com), len(step.placements))
    if not found.check(
        "lifted finger",
        sizes == (count, count, count),
        f"modes, f_com and placements have {sizes} entries; the hand has {count} fingers",
    ):
        return False
    held = step.placements[finger]
    check_placement(recheck, "from", step.from_, found)
    found.check(
        "lifted finger",
        (step.from_.face, step.from_.cell) == (held.face, held.cell),
        f"'from' is {step.from_.face}:{list(step.from_.cell)}; finger {finger} is at "
        f"{held.face}:{list(held.cell)}",
    )
    missing = [i for i, mode in enumerate(step.modes) if mode is None]
    return found.check(
        "lifted finger",
        missing == [finger] and step.f_com[finger] is None,
        f"finger {finger} is lifted, so its mode and f_com, and no other finger's mode, are "
        f"null; modes are {list(step.modes)}, f_com {list(step.f_com)}",
    )


def _check_target(
    recheck: Recheck, step: RegraspStep, rows: Placements, target: int, found: Findings
) -> None:
    found.check(
        "target",
        target != rows[step.finger],
        f"finger {step.finger} is set down at {named(recheck, target)}, where it was",
    )
    taken = [i for i, row in enumerate(rows) if row == target and i != step.finger]
    found.check(
        "target",
        not taken,
        f"{named(recheck, target)} is taken by finger {taken[0] if taken else ''}",
    )
    after = (*rows[: step.finger], target, *rows[step.finger + 1 :])
    reason = recheck.blocked(recheck.problem.motion.pose(step.at), after)
    found.check(
        "target", reason is None, f"finger {step.finger} at {named(recheck, target)}: {reason}"
    )


def _check_rest(recheck: Recheck, step: RegraspStep, rows: Placements, found: Findings) -> None:
    rest = tuple(i for i in range(len(rows)) if i != step.finger)
    hold = Hold(
        contacts=recheck.contacts(recheck.problem.motion.moment(step.at)),
        fingers=rest,
        rows=tuple(rows[i] for i in rest),
        modes=tuple(ControlMode(step.modes[i]) for i in rest),
        f_com=tuple(step.f_com[i] for i in rest),
        z=step.z,
    )
    check_hold(recheck, hold, found)
