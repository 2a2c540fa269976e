"""Judges one step: Sec. 4.2, Eqs. (9) and (10), and whether its arc is the scenario's motion."""

from __future__ import annotations

import numpy as np

from gm_ompl.checking.hold import check_hold, check_placement, check_placements, named
from gm_ompl.checking.recheck import Hold, Recheck
from gm_ompl.checking.report import Findings
from gm_ompl.checking.ways import check_way
from gm_ompl.contact.decision import ControlMode
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.planfile.model import DisplacementStep, RegraspStep
from gm_ompl.problem import Placements


def check_displacement(
    recheck: Recheck, step: DisplacementStep, arc: Arc | None, found: Findings
) -> None:
    """Judge a displacement step along its arc; note what does not hold."""
    rows = check_placements(recheck, step.placements, found)
    if arc is None or rows is None or not _check_lists(recheck, step, found):
        return
    for name, q, pose in (("from", step.from_, arc.start), ("to", step.to, arc.end)):
        reason = recheck.blocked(pose, rows)
        place = f"{name!r} {list(q)}" if q else f"'pose_{name}'"
        found.check("geometry", reason is None, f"at {place}: {reason}")
    reason = recheck.blocked_along(arc, rows)
    found.check("geometry", reason is None, f"on the way: {reason}")
    _check_segments(recheck, step, rows, arc, found)
    _check_cost(recheck, step, rows, arc, found)


def _check_lists(recheck: Recheck, step: DisplacementStep, found: Findings) -> bool:
    """Judge the form of the segments; return whether they can be judged one by one."""
    count = recheck.problem.fingers.count
    for j, segment in enumerate(step.segments):
        have = (len(segment.modes), len(segment.f_com))
        if not found.check(
            "segments",
            have == (count, count),
            f"{have[0]} modes and {have[1]} values of f_com; the hand has {count} fingers",
            j,
        ):
            return False
    return len(step.segments) > 0


def _check_segments(
    recheck: Recheck, step: DisplacementStep, rows: Placements, arc: Arc, found: Findings
) -> None:
    middles = arc.middles(len(step.segments))
    for j, (moment, segment) in enumerate(zip(middles, step.segments, strict=True)):
        reason = recheck.blocked(moment.pose, rows)
        found.check("geometry", reason is None, f"where it is judged: {reason}", j)
        hold = Hold(
            contacts=recheck.contacts(moment),
            fingers=tuple(range(len(rows))),
            rows=rows,
            modes=tuple(ControlMode(mode) for mode in segment.modes),
            f_com=segment.f_com,
            z=segment.z,
            segment=j,
            z_strong=segment.z_strong,
        )
        check_hold(recheck, hold, found)


def _check_cost(
    recheck: Recheck, step: DisplacementStep, rows: Placements, arc: Arc, found: Findings
) -> None:
    """Judge Eq. (9), with the margins that the plan states (they are judged by themselves)."""
    counts = "z_strong" if recheck.problem.mechanics.strong else "z"
    z = np.array([getattr(segment, counts) or 0.0 for segment in step.segments])
    if not (z >= 0).all():
        return  # reported as a margin below z_min; Eq. (9) has no finite value
    problem = recheck.problem
    weights = 1.0 + problem.cost.stability / np.maximum(z, problem.z_floor)
    cost = float((weights @ arc.chords(problem.fingers.centres(rows), len(z))).max(initial=0.0))
    found.cost = cost
    allowed = recheck.tolerances.cost * max(cost, 0.0)
    found.claim(
        "cost", "cost", (step.cost, cost), allowed, where="as travel weighed by the margin (9)"
    )


def check_regrasp(recheck: Recheck, step: RegraspStep, pose: Pose | None, found: Findings) -> None:
    """Judge a regrasping step with the object at its pose; note what does not hold."""
    rows = check_placements(recheck, step.placements, found)
    target = check_placement(recheck, "to", step.to, found)
    if pose is None or not _check_finger(recheck, step, found) or rows is None:
        return
    reason = recheck.blocked(pose, rows)
    found.check("geometry", reason is None, f"before the regrasp: {reason}")
    if target is not None:
        _check_target(recheck, step, (rows, target), pose, found)
        check_way(recheck, step, (rows, target), pose, found)
    _check_rest(recheck, step, rows, pose, found)
    found.cost = recheck.problem.cost.regrasp
    allowed = recheck.tolerances.cost * found.cost
    found.claim("cost", "cost", (step.cost, found.cost), allowed, where="as a regrasp (10)")


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
        step.from_.spot == held.spot,
        f"'from' is {step.from_.words}; finger {finger} is at {held.words}",
    )
    missing = [i for i, mode in enumerate(step.modes) if mode is None]
    return found.check(
        "lifted finger",
        missing == [finger] and step.f_com[finger] is None,
        f"finger {finger} is lifted, so its mode and f_com, and no other finger's mode, are "
        f"null; modes are {list(step.modes)}, f_com {list(step.f_com)}",
    )


def _check_target(
    recheck: Recheck,
    step: RegraspStep,
    places: tuple[Placements, int],
    pose: Pose,
    found: Findings,
) -> None:
    rows, target = places
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
    reason = recheck.blocked(pose, after)
    found.check(
        "target", reason is None, f"finger {step.finger} at {named(recheck, target)}: {reason}"
    )


def _check_rest(
    recheck: Recheck, step: RegraspStep, rows: Placements, pose: Pose, found: Findings
) -> None:
    rest = tuple(i for i in range(len(rows)) if i != step.finger)
    hold = Hold(
        contacts=recheck.contacts(Moment(pose)),
        fingers=rest,
        rows=tuple(rows[i] for i in rest),
        modes=tuple(ControlMode(step.modes[i]) for i in rest),
        f_com=tuple(step.f_com[i] for i in rest),
        z=step.z,
        z_strong=step.z_strong,
    )
    check_hold(recheck, hold, found)
