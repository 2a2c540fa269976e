"""Judges the object's motion where it has coordinates: a path, or x, y and yaw."""

from __future__ import annotations

import math
from typing import TypeAlias, final

import numpy as np

from gm_ompl.checking.coordinates import crossed, gap, in_goal, lattice_steps
from gm_ompl.checking.hold import check_coordinates, check_pose
from gm_ompl.checking.kinematics import AnyStep, Kinematics, regrasp_in_words
from gm_ompl.checking.recheck import Recheck
from gm_ompl.checking.report import Findings
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planfile.arcs import arc_record
from gm_ompl.planfile.model import DisplacementStep, RegraspStep
from gm_ompl.planfile.record import ArcRecord, RotationArc, StraightArc, TranslationArc, Turn


def tail(step: AnyStep) -> Coordinates:
    """Return the coordinates where ``step`` starts."""
    return step.from_ if isinstance(step, DisplacementStep) else step.at


def head(step: AnyStep) -> Coordinates:
    """Return the coordinates where ``step`` ends."""
    return step.to if isinstance(step, DisplacementStep) else step.at


@final
class ByCoordinates(Kinematics):
    """A step's coordinates say everything: poses and arcs must be the motion's there.

    Args:
        recheck: answers what holds.
    """

    def __init__(self, recheck: Recheck) -> None:
        self._recheck, self._problem = recheck, recheck.problem

    def continuity(self, last: AnyStep | None, step: AnyStep, found: Findings) -> None:
        """Judge the step's coordinates by the last one's; poses by each other."""
        allowed, here = self._recheck.tolerances.coordinate, list(tail(step))
        if last is None:
            start = self._problem.start
            found.check(
                "start",
                gap(self._problem, tail(step), start) <= allowed,
                f"the first step starts at {here}; the scenario's start is {list(start)}",
            )
            return
        found.check(
            "continuity",
            gap(self._problem, tail(step), head(last)) <= allowed,
            f"starts at {here}; the last step ended at {list(head(last))}",
        )
        if isinstance(step, DisplacementStep) and isinstance(last, DisplacementStep):
            begin, there = step.pose_from.position, last.pose_to.position
            off = max(abs(u - v) for u, v in zip(begin, there, strict=True))
            slack = self._recheck.tolerances.length * max(self._recheck.diagonal, *map(abs, there))
            found.check(
                "continuity",
                off <= 2 * slack,
                f"pose_from is {off:.3g} away from the last step's pose_to "
                f"(allowed {2 * slack:.3g})",
            )

    def displacement(self, step: DisplacementStep, found: Findings) -> Arc | None:
        """Judge coordinates, poses, arc and number of segments."""
        recheck = self._recheck
        if not self._check_ends(step, found):
            return None
        arc = self._problem.motion.arc(step.from_, step.to)
        check_pose(recheck, "pose_from", step.pose_from, arc.start, found)
        check_pose(recheck, "pose_to", step.pose_to, arc.end, found)
        check_arc(recheck, step.arc, arc, found)
        self._check_number(step, found)
        return arc

    def rest(self, step: RegraspStep, found: Findings) -> Pose | None:
        """Judge the coordinates of a regrasp."""
        good = check_coordinates(self._recheck, "at", step.at, found)
        return self._problem.motion.pose(step.at) if good else None

    def goal(self, last: AnyStep, found: Findings) -> None:
        """Judge the last coordinates."""
        problem, end = self._problem, head(last)
        inside = len(end) == problem.motion.dimension and self._arrived(end)
        low, high = list(problem.goal.low), list(problem.goal.high)
        message = f"the last step ends at {list(end)}; the goal is {low} to {high}"
        found.check("goal", inside, message)

    def at_once(self, found: Findings) -> None:
        """Judge the start's coordinates."""
        start, goal = self._problem.start, self._problem.goal
        found.check(
            "goal",
            self._arrived(start),
            f"there are no steps, and the start {list(start)} is not in the goal "
            f"{list(goal.low)} to {list(goal.high)}",
        )

    def place(self, step: AnyStep) -> str:
        """Return the coordinates."""
        start, end = (", ".join(f"{value:.6g}" for value in q) for q in (tail(step), head(step)))
        if isinstance(step, DisplacementStep):
            return f"[{start}] to [{end}]"
        return f"[{start}], {regrasp_in_words(step)}"

    def _arrived(self, q: Coordinates) -> bool:
        return in_goal(self._problem, q, self._recheck.tolerances.coordinate)

    def _check_ends(self, step: DisplacementStep, found: Findings) -> bool:
        """Judge the coordinates; return whether the rest of the step can be judged."""
        problem, tolerances = self._problem, self._recheck.tolerances
        ends = (("from", step.from_), ("to", step.to))
        if not all(check_coordinates(self._recheck, name, q, found) for name, q in ends):
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

    def _check_number(self, step: DisplacementStep, found: Findings) -> None:
        steps, parts = lattice_steps(self._problem, step.from_, step.to), len(step.segments)
        tolerances, P = self._recheck.tolerances, self._problem.cost.samples_per_arc
        # An arc that little over a whole number of steps may be counted either way.
        margins = (tolerances.count, tolerances.rounding)
        wanted = [P * max(1, math.ceil(steps - margin)) for margin in margins]
        found.check(
            "segments",
            parts in wanted,
            f"{parts} segments; an arc over {steps:.6g} lattice steps has exactly {wanted[0]} "
            f"({P} per step begun)",
        )


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


Part: TypeAlias = tuple[str, tuple[float, ...], tuple[float, ...], float]
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
