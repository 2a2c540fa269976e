"""Judges one step: Sec. 4.2, Eqs. (9) and (10), and whether its arc is the scenario's motion."""

from __future__ import annotations

import math

import numpy as np

from gm_ompl.checking.coordinates import crossed, lattice_steps
from gm_ompl.checking.hold import (
    check_coordinates,
    check_hold,
    check_placement,
    check_placements,
    check_pose,
    named,
)
from gm_ompl.checking.recheck import Hold, Recheck
from gm_ompl.checking.report import Findings
from gm_ompl.checking.ways import check_way
from gm_ompl.contact.decision import ControlMode
from gm_ompl.motion.arc import Arc
from gm_ompl.planfile.arcs import arc_record
from gm_ompl.planfile.model import DisplacementStep, RegraspStep
from gm_ompl.planfile.record import ArcRecord, RotationArc, StraightArc, TranslationArc, Turn
from gm_ompl.problem import Placements


def check_displacement(recheck: Recheck, step: DisplacementStep, found: Findings) -> None:
    """Judge a displacement step by itself; note what does not hold."""
    rows = check_placements(recheck, step.placements, found)
    if not _check_coordinates(recheck, step, found):
        return
    arc = recheck.problem.motion.arc(step.from_, step.to)
    check_pose(recheck, "pose_from", step.pose_from, arc.start, found)
    check_pose(recheck, "pose_to", step.pose_to, arc.end, found)
    check_arc(recheck, step.arc, arc, found)
    if rows is None or not _check_density(recheck, step, found):
        return
    for name, q, pose in (("from", step.from_, arc.start), ("to", step.to, arc.end)):
        reason = recheck.blocked(pose, rows)
        found.check("geometry", reason is None, f"at '{name}' {list(q)}: {reason}")
    reason = recheck.blocked_along(arc, rows)
    found.check("geometry", reason is None, f"on the way: {reason}")
    _check_segments(recheck, step, rows, arc, found)
    _check_cost(recheck, step, rows, arc, found)


def _check_coordinates(recheck: Recheck, step: DisplacementStep, found: Findings) -> bool:
    """Judge the coordinates; return whether the rest of the step can be judged."""
    problem, tolerances = recheck.problem, recheck.tolerances
    ends = (("from", step.from_), ("to", step.to))
    if not all(check_coordinates(recheck, name, q, found) for name, q in ends):
        return False
    span = float(np.abs(np.subtract(step.to, step.from_)).max())
    if not found.check(
        "coordinates",
        span > 0.0 and lattice_steps(problem, step.from_, step.to) > tolerances.coordinate,
        f"'from' and 'to' are both {list(step.from_)}: the object does not move",
    ):
        return False
    boundary = crossed(problem, step.from_, step.to, tolerances.coordinate)
    return found.check(
        "coordinates",
        boundary is None,
        f"the arc from {list(step.from_)} to {list(step.to)} spans the piece boundary at "
        f"{boundary}; an arc ends there",
    )


def _check_density(recheck: Recheck, step: DisplacementStep, found: Findings) -> bool:
    """Judge number and form of the segments; return whether they can be judged one by one."""
    problem, parts = recheck.problem, len(step.segments)
    steps = lattice_steps(problem, step.from_, step.to)
    tolerances, P = recheck.tolerances, problem.cost.samples_per_arc
    # An arc that little over a whole number of steps may be counted either way.
    margins = (tolerances.count, tolerances.rounding)
    wanted = [P * max(1, math.ceil(steps - margin)) for margin in margins]
    found.check(
        "segments",
        parts in wanted,
        f"{parts} segments; an arc over {steps:.6g} lattice steps has exactly {wanted[0]} "
        f"({P} per step begun)",
    )
    count = problem.fingers.count
    for j, segment in enumerate(step.segments):
        have = (len(segment.modes), len(segment.f_com))
        if not found.check(
            "segments",
            have == (count, count),
            f"{have[0]} modes and {have[1]} values of f_com; the hand has {count} fingers",
            j,
        ):
            return False
    return parts > 0


def _check_segments(
    recheck: Recheck, step: DisplacementStep, rows: Placements, arc: Arc, found: Findings
) -> None:
    middles = arc.middles(len(step.segments))
    for j, (moment, segment) in enumerate(zip(middles, step.segments, strict=True)):
        reason = recheck.blocked(moment.pose, rows)
        found.check("geometry", reason is None, f"at its midpoint: {reason}", j)
        hold = Hold(
            contacts=recheck.contacts(moment),
            fingers=tuple(range(len(rows))),
            rows=rows,
            modes=tuple(ControlMode(mode) for mode in segment.modes),
            f_com=segment.f_com,
            z=segment.z,
            segment=j,
        )
        check_hold(recheck, hold, found)


def _check_cost(
    recheck: Recheck, step: DisplacementStep, rows: Placements, arc: Arc, found: Findings
) -> None:
    """Judge Eq. (9), with the margins that the plan states (they are judged by themselves)."""
    z = np.array([segment.z for segment in step.segments])
    if not (z > 0).all():
        return  # reported as a margin below z_min; Eq. (9) has no finite value
    weights = 1.0 + recheck.problem.cost.stability / z
    cost = float(
        (weights @ arc.chords(recheck.problem.fingers.centres(rows), len(z))).max(initial=0.0)
    )
    found.cost = cost
    allowed = recheck.tolerances.cost * max(cost, 0.0)
    found.claim("cost", "cost", (step.cost, cost), allowed, where="by Eq. (9)")


def check_arc(recheck: Recheck, claimed: ArcRecord, arc: Arc, found: Findings) -> None:
    """Judge whether ``claimed`` is ``arc``, the motion between the step's coordinates."""
    wanted = arc_record(arc)
    kinds = [type(record).__name__.removesuffix("Arc").lower() for record in (claimed, wanted)]
    if not found.check(
        "arc",
        kinds[0] == kinds[1],
        f"a {kinds[0]} is claimed; between these coordinates the scenario has a {kinds[1]}",
    ):
        return
    length = recheck.tolerances.length * max(
        recheck.diagonal, *np.abs([arc.start.position, arc.end.position]).ravel().tolist()
    )
    for what, have, want, allowed in _parts(claimed, wanted, length, recheck.tolerances.direction):
        found.claim("arc", what, (have, want), allowed, where="between these coordinates")


Part = tuple[str, tuple[float, ...], tuple[float, ...], float]
"""What is compared, what is claimed, what it is, and by how much they may differ."""


def _parts(claimed: ArcRecord, wanted: ArcRecord, length: float, angle: float) -> list[Part]:
    if isinstance(claimed, TranslationArc) and isinstance(wanted, TranslationArc):
        return [("translation", claimed.translation, wanted.translation, length)]
    if isinstance(claimed, RotationArc) and isinstance(wanted, RotationArc):
        return _turns(claimed.rotation, wanted.rotation, length, angle)
    assert isinstance(claimed, StraightArc) and isinstance(wanted, StraightArc)
    parts: list[Part] = []
    for name, have, want in (
        ("straight.from", claimed.straight.from_, wanted.straight.from_),
        ("straight.to", claimed.straight.to, wanted.straight.to),
    ):
        parts += [(name, have[:2], want[:2], length), (f"{name} (yaw)", have[2:], want[2:], angle)]
    return parts


def _turns(claimed: Turn, wanted: Turn, length: float, angle: float) -> list[Part]:
    """Compare two turns: any point of the line will do, and the axis may point either way."""
    sign = 1.0 if np.dot(claimed.axis, wanted.axis) >= 0.0 else -1.0
    axis = np.array(wanted.axis)
    arm = np.subtract(claimed.point, wanted.point)
    beside = arm - (arm @ axis) * axis
    point = tuple(np.subtract(claimed.point, beside).tolist())
    return [
        ("rotation.point", claimed.point, point, length),
        ("rotation.axis", claimed.axis, tuple((sign * axis).tolist()), angle),
        ("rotation.angle", (claimed.angle,), (sign * wanted.angle,), angle),
    ]


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
        check_way(recheck, step, rows, target, found)
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
