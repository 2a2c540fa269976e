"""Judges one instant: poses and placements, modes, commanded forces and the stability margin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gm_ompl.checking.coordinates import outside
from gm_ompl.checking.recheck import Hold, Recheck
from gm_ompl.checking.report import Findings, listed
from gm_ompl.errors import SolverError
from gm_ompl.geometry.pose import Pose
from gm_ompl.planfile.model import PlacementRecord
from gm_ompl.planfile.record import PoseRecord
from gm_ompl.problem import Placements


def check_coordinates(recheck: Recheck, name: str, q: Sequence[float], found: Findings) -> bool:
    """Judge how many coordinates there are and their bounds; return whether both hold."""
    motion = recheck.problem.motion
    if not found.check(
        "coordinates",
        len(q) == motion.dimension,
        f"'{name}' has {len(q)} coordinates; the motion has {motion.dimension} "
        f"({', '.join(motion.names)})",
    ):
        return False
    off = outside(recheck.problem, q)
    return found.check(
        "coordinates",
        off <= recheck.tolerances.coordinate,
        f"'{name}' {list(q)} is out of bounds {list(motion.low)} to {list(motion.high)} by "
        f"{off:.3g} of the range",
    )


def check_pose(
    recheck: Recheck,
    name: str,
    claimed: PoseRecord,
    pose: Pose,
    found: Findings,
    where: str = "at these coordinates",
) -> None:
    """Judge whether ``claimed`` is the ``pose`` that the object has at ``where``."""
    tolerances = recheck.tolerances
    # Positions far from the origin carry the rounding of their own size.
    allowed = tolerances.length * max(recheck.diagonal, float(np.abs(pose.position).max()))
    values = (claimed.position, pose.position)
    found.claim("pose", f"{name}.position", values, allowed, where=where)
    length = float(np.linalg.norm(claimed.quaternion))
    unit = found.check(
        "pose",
        abs(length - 1.0) <= tolerances.direction,
        f"{name}.quaternion {listed(claimed.quaternion)} has length {length:.9g}, not 1",
    )
    if unit:
        turned = Pose.from_quaternion(claimed.position, claimed.quaternion)
        off = float(np.abs(turned.rotation - pose.rotation).max())
        found.check(
            "pose",
            off <= 4.0 * tolerances.direction,  # an entry moves up to 4 times a component
            f"{name}.quaternion {listed(claimed.quaternion)} is claimed; {where} "
            f"it is {listed(pose.quaternion())} (rotation off by {off:.3g})",
        )


def check_placements(
    recheck: Recheck, claimed: Sequence[PlacementRecord], found: Findings
) -> Placements | None:
    """Judge a whole hand's placements; return their rows in the table, None if one has none."""
    count = recheck.problem.fingers.count
    if not found.check(
        "placements",
        len(claimed) == count,
        f"{len(claimed)} placements are listed; the hand has {count} fingers",
    ):
        return None
    rows = [
        check_placement(recheck, f"placements[{finger}]", record, found)
        for finger, record in enumerate(claimed)
    ]
    known = tuple(row for row in rows if row is not None)
    return known if len(known) == count else None


def check_placement(
    recheck: Recheck, name: str, claimed: PlacementRecord, found: Findings
) -> int | None:
    """Judge one placement; return its row in the table, or None if it is not in it."""
    tolerances, table = recheck.tolerances, recheck.problem.fingers.placements
    row = claimed.row(table)
    what = (
        "cell among them"
        if claimed.cell is not None
        else "point on them: "
        + (
            "it is off its face, covered, or nearer to the rim than the margin"
            if recheck.problem.fingers.anywhere is not None
            else "the scenario asks for no continuous placements"
        )
    )
    if not found.check(
        "placements",
        row is not None,
        f"{name} is at {claimed.words}; the scenario's fingers may be placed on faces "
        f"{', '.join(table.labels)}, and there is no such {what}",
    ):
        return None
    for what, have, want, allowed in (
        ("point", claimed.point, table.points[row], tolerances.length * recheck.diagonal),
        ("normal", claimed.normal, table.normals[row], tolerances.direction),
    ):
        where = f"at {claimed.words}"
        found.claim("placements", f"{name}.{what}", (have, want), allowed, where=where)
    return row


def named(recheck: Recheck, row: int) -> str:
    """Return ``+x:3,2`` for a row of the placement table."""
    table = recheck.problem.fingers.placements
    i, j = table.cell[row].tolist()
    place = f"{i},{j}" if i >= 0 else listed(table.points[row])
    return f"{table.labels[int(table.face[row])]}:{place}"


def check_hold(recheck: Recheck, hold: Hold, found: Findings) -> None:
    """Judge modes, f_com and z of one instant; note what does not hold.

    What neither HiGHS nor exact arithmetic decides is not shown to hold.
    """
    try:
        passes = _check_modes(recheck, hold, found)
        legal = _check_forces(recheck, hold, found)
        if passes and legal:
            _check_margin(recheck, hold, found)
    except SolverError as error:
        found.check("z", False, f"z = {hold.z:.9g} cannot be decided: {error}", hold.segment)


def _check_modes(recheck: Recheck, hold: Hold, found: Findings) -> bool:
    claimed = ", ".join(mode.value for mode in hold.modes)
    return found.check(
        "modes",
        not recheck.internal_force(hold),
        f"modes [{claimed}] are claimed; with them fingers can squeeze without bound: excessive "
        "internal force (5)",
        hold.segment,
    )


def _check_forces(recheck: Recheck, hold: Hold, found: Findings) -> bool:
    legal = True
    limits = recheck.problem.fingers.max_normal_force
    for finger, mode, force in zip(hold.fingers, hold.modes, hold.f_com, strict=True):
        limit = float(limits[finger])
        wrong = ""
        if (force is None) != (mode.value == "position"):
            have = "null" if force is None else f"{force:.9g}"
            wrong = f"f_com of finger {finger} is {have}; under {mode.value} control it is " + (
                "null" if mode.value == "position" else f"a number from 0 to {limit:.9g}"
            )
        elif force is not None:
            slack = recheck.tolerances.force * limit
            excess = max(-force, force - limit)
            if excess > slack:
                wrong = (
                    f"f_com of finger {finger} is {force:.9g}; it is {excess:.3g} outside "
                    f"0 to {limit:.9g}"
                )
        legal = found.check("f_com", not wrong, wrong, hold.segment) and legal
    return legal


def _check_margin(recheck: Recheck, hold: Hold, found: Findings) -> None:
    tolerances, strong = recheck.tolerances, recheck.problem.mechanics.strong
    if not found.check(
        "z_strong",
        strong == (hold.z_strong is not None),
        f"z_strong is {hold.z_strong}; with mechanics.margin: "
        + ("strong it is a number" if strong else "nominal the plan says nothing of it"),
        hold.segment,
    ):
        return
    z = recheck.margin(hold)
    found.margin(z)
    where = "with these modes and this f_com"
    found.claim("z", "z =", (hold.z, z), _slack(recheck, z), where=where, segment=hold.segment)
    name, least = ("z_strong", _strong(recheck, hold, z, found)) if strong else ("z", z)
    if not strong:
        best = z if recheck.unbeaten(hold, z + _slack(recheck, z)) else recheck.best(hold).z
        found.check(
            "best modes",
            z >= best - _slack(recheck, best),
            f"with these modes and this f_com z is {z:.9g}; the best of all modes and commands is "
            f"{best:.9g} ({best - z:.3g} more, allowed {_slack(recheck, best):.3g})",
            hold.segment,
        )
    z_min = recheck.problem.mechanics.z_min
    least = min(least, hold.z)
    found.check(
        "z_min",
        least >= z_min * (1.0 - tolerances.z_min),
        f"{name} is {least:.9g}, below z_min = {z_min:.9g} by {z_min - least:.3g}",
        hold.segment,
    )


def _slack(recheck: Recheck, z: float) -> float:
    tolerances = recheck.tolerances
    return tolerances.z * max(abs(z), tolerances.z_floor * recheck.force_scale)


def _strong(recheck: Recheck, hold: Hold, z: float, found: Findings) -> float:
    """Judge what is claimed to be strongly held; return what is.

    Beyond the claim z_strong is asked for only so far as it tells whether the claim is wrong.
    """
    claimed = hold.z_strong or 0.0
    slack = _slack(recheck, claimed)
    z_strong = recheck.strong(hold, min(z, claimed + 2.0 * slack))
    where = "with these modes and this f_com, at least" if z_strong > claimed + slack else ""
    values = claimed, z_strong
    found.claim("z_strong", "z_strong =", values, slack, where=where, segment=hold.segment)
    return min(z_strong, claimed)
