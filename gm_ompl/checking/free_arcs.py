"""Judges the object's motion where it moves freely.

Every arc is a screw along the axes that the scenario allows. Those of a plan that is said to be
optimal on the contact lattice must be the lattice's, besides: what arcs leave a pose is asked of
the reference, which knows the contacts and how the object came.
"""

from __future__ import annotations

import math
from typing import final

import numpy as np

from gm_ompl.checking.hold import check_pose
from gm_ompl.checking.kinematics import AnyStep, Kinematics, regrasp_in_words
from gm_ompl.checking.recheck import Recheck
from gm_ompl.checking.report import Findings, listed
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.free import AXES, FreeMotion, angle_between
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.motion.screw import Piece, Screw, Slide
from gm_ompl.plain.contact_arcs import ContactArcs, PlainOffer, PlainStand
from gm_ompl.plain.contact_lattice import PlainContactLattice
from gm_ompl.plain.contact_lines import SAME, PlainLine, parallel
from gm_ompl.planfile.arcs import arc_of, arc_record, pose_of, steps_of
from gm_ompl.planfile.model import DisplacementStep, RegraspStep
from gm_ompl.planfile.record import RotationArc, StraightArc
from gm_ompl.planfile.words import arc_in_words

MATCH = 1e-7
"""How far the length of a slide, relative to D, may be off the lattice's."""
MATCH_TURN = 1e-6
"""How far a turn's angle may be off [rad]: an end that only grazes is known no better."""
SHOWN = 6
"""At most so many arcs are listed in a message."""
SEARCHED = 1000
"""Poses looked at to count arcs from the start; what is not among them is too deep."""


@final
class FreeArcs(Kinematics):
    """Follows the object from the start, arc by arc.

    Args:
        recheck: answers what holds.
        motion: the problem's.
        on_lattice: whether every arc must be one of the contact lattice.
    """

    def __init__(self, recheck: Recheck, motion: FreeMotion, on_lattice: bool) -> None:
        problem = recheck.problem
        self._recheck, self._problem, self._motion = recheck, problem, motion
        self._on_lattice = on_lattice
        self._D, self._samples = problem.body.diagonal, problem.cost.samples_per_arc
        self._arcs = ContactArcs(problem.body, problem.environment, motion, self._samples)
        self._here = motion.start
        self._came_about: PlainLine | None = None
        self._reached: list[tuple[Pose, int]] = [(motion.start, 0)]

    def continuity(
        self,
        last: AnyStep | None,  # noqa: ARG002 (where it ended is known)
        step: AnyStep,
        found: Findings,
    ) -> None:
        """Judge where a displacement begins; a regrasp does not say where it is."""
        if isinstance(step, RegraspStep):
            return
        length = float(np.linalg.norm(step.pose_from.quaternion))
        tolerances = self._recheck.tolerances
        found.check(
            "pose",
            abs(length - 1.0) <= tolerances.direction,
            f"pose_from.quaternion {listed(step.pose_from.quaternion)} has length {length:.9g}, "
            "not 1",
        )
        topic, what, near, turn = "continuity", "where the last arc ended", SAME * self._D, SAME
        if self._moved == 0:
            far = float(np.abs(self._here.position).max())
            near, turn = tolerances.length * max(self._D, far), 4.0 * tolerances.direction
            topic, what = "start", "the scenario's start"
        here = pose_of(step.pose_from)
        off = float(np.linalg.norm(here.position - self._here.position))
        turned = angle_between(self._here.rotation, here.rotation)
        found.check(
            topic,
            off <= near and turned <= turn,
            f"begins at {_place(here)}; {what} is {_place(self._here)} ({off:.3g} away, turned by "
            f"{math.degrees(turned):.3g} deg)",
        )

    def displacement(self, step: DisplacementStep, found: Findings) -> Arc | None:
        """Judge that the lattice has this arc, so divided, from the pose where it begins."""
        for name, q in (("from", step.from_), ("to", step.to)):
            self._check_null(name, q, found)
        start, end = pose_of(step.pose_from), pose_of(step.pose_to)
        arc = arc_of(step, self._problem)
        if isinstance(step.arc, StraightArc) or not isinstance(arc, Screw):
            message = "a straight is claimed; free motion has translations and rotations"
            found.check("arc", False, message)
            self._go(end, None)
            return None
        piece, line = arc.piece, None
        if isinstance(step.arc, RotationArc):
            line = PlainLine(np.array(step.arc.rotation.point), np.array(step.arc.rotation.axis))
            self._check_axis(step.arc, found)
        check_pose(self._recheck, "pose_to", step.pose_to, arc.end, found, "where the arc ends")
        divided = self._check_arc(step, start, piece, found)
        if self._on_lattice:
            self._check_depth(start, found)
        self._go(arc.end, line)
        return arc if divided else None

    def rest(self, step: RegraspStep, found: Findings) -> Pose | None:
        """Return where the last arc ended."""
        self._check_null("at", step.at, found)
        return self._here

    def goal(self, last: AnyStep, found: Findings) -> None:  # noqa: ARG002 (its end is known)
        """Judge where the last arc ended."""
        self._check_goal("the plan ends", found)

    def at_once(self, found: Findings) -> None:
        """Judge the start."""
        self._check_goal("there are no steps, and the start lies", found)

    def place(self, step: AnyStep) -> str:
        """Return what the object does, or where it rests."""
        if isinstance(step, DisplacementStep):
            return arc_in_words(step.arc)
        return f"at {_place(self._here)}, {regrasp_in_words(step)}"

    @property
    def _moved(self) -> int:
        """How many arcs were judged."""
        return len(self._reached) - 1

    def _go(self, end: Pose, line: PlainLine | None) -> None:
        known = (arcs for pose, arcs in self._reached if self._equal(pose, end))
        arcs = min([self._fewest(self._here) + 1, *known])
        self._here, self._came_about = end, line
        self._reached.append((end, arcs))

    def _fewest(self, pose: Pose) -> int:
        """Return the least number of arcs of the plan that lead to a pose."""
        known = (arcs for other, arcs in self._reached if self._equal(pose, other))
        return min(known, default=self._moved)

    def _equal(self, a: Pose, b: Pose) -> bool:
        near = float(np.linalg.norm(a.position - b.position)) <= SAME * self._D
        return near and angle_between(a.rotation, b.rotation) <= SAME

    def _check_null(self, name: str, q: Coordinates, found: Findings) -> None:
        message = f"'{name}' is {list(q)}; with free motion the object has no coordinates: null"
        found.check("coordinates", not q, message)

    def _check_axis(self, record: RotationArc, found: Findings) -> None:
        length = float(np.linalg.norm(record.rotation.axis))
        allowed = self._recheck.tolerances.direction
        message = f"rotation.axis has length {length:.9g}, not 1"
        found.check("arc", abs(length - 1.0) <= allowed, message)

    def _check_arc(
        self, step: DisplacementStep, start: Pose, piece: Piece, found: Findings
    ) -> bool:
        """Judge arc and number of segments; return whether the segments can be judged."""
        region = self._motion.region
        found.check(
            "region",
            self._arcs.in_region(start, piece),
            f"{arc_in_words(step.arc)}: the centre of mass leaves the region {listed(region[0])} "
            f"to {listed(region[1])}",
        )
        stand = self._arcs.stand(start)
        if not self._on_lattice:
            self._check_axes(step, stand, piece, found)
            return self._check_number(step, piece, found)
        under_way = self._arcs.under_way(stand, self._came_about)
        offers = list(self._arcs.offers(stand, under_way))
        if not found.check(
            "arc",
            any(self._same(piece, offer) for offer in offers),
            self._mismatch(step, piece, offers, stand.begins),
        ):
            return True
        return self._check_number(step, piece, found)

    def _check_axes(
        self, step: DisplacementStep, stand: PlainStand, piece: Piece, found: Findings
    ) -> None:
        """Judge whether the scenario lets the object move in this direction at all."""
        steps = self._motion.steps
        if isinstance(piece, Slide):
            length = float(np.linalg.norm(piece.by))
            direction = piece.by / (length or 1.0)
            barred = [k for k in range(3) if k not in steps.translate]
            allowed = float(np.abs(direction[barred]).max(initial=0.0)) <= SAME
            allowed = allowed or self._arcs.slides_along(stand, direction)
            names = ", ".join(AXES[k] for k in steps.translate)
            message = f"motion.free.translate allows {names}, and slides along contact lines"
        else:
            length, message = piece.angle, "motion.free.rotate allows no turn of this direction"
            allowed = steps.rotate is None or any(parallel(piece.axis, a) for a in steps.rotate)
        if length == 0.0:
            allowed, message = False, "the object does not move"
        found.check("arc", allowed, f"{arc_in_words(step.arc)}: {message}")

    def _check_number(self, step: DisplacementStep, piece: Piece, found: Findings) -> bool:
        """Judge the number of segments; return whether they can be judged."""
        steps, tolerances = steps_of(piece, self._motion), self._recheck.tolerances
        # An arc that little over a whole number of segments may be counted either way.
        margins = (tolerances.count, tolerances.rounding)
        wanted = [self._parts(steps, margin) for margin in margins]
        return found.check(
            "segments",
            len(step.segments) in wanted,
            f"{len(step.segments)} segments; an arc over {steps:.6g} steps has exactly "
            f"{wanted[0]} ({self._samples} per step)",
        )

    def _parts(self, steps: float, margin: float) -> int:
        """Return how many segments an arc over so many steps has: all of each step begun."""
        segments = self._samples * steps
        if segments <= self._samples:
            return max(2 if self._motion.ends else 1, math.ceil(segments - margin))
        return self._samples * max(1, math.ceil(steps - margin))

    def _same(self, piece: Piece, offer: PlainOffer, *, any_length: bool = False) -> bool:
        """Whether a motion is the one on offer, or one that only goes on longer or less far."""
        other = offer.arc.piece
        if isinstance(piece, Slide) or isinstance(other, Slide):
            if not (isinstance(piece, Slide) and isinstance(other, Slide)):
                return False
            if any_length:
                way, wanted = np.linalg.norm(piece.by), np.linalg.norm(other.by)
                return float(np.linalg.norm(piece.by / (way or 1.0) - other.by / wanted)) <= SAME
            return float(np.linalg.norm(piece.by - other.by)) <= MATCH * self._D
        line = PlainLine(piece.pivot, piece.axis)
        if not line.equals(PlainLine(other.pivot, other.axis), self._D):
            return False
        angle = math.copysign(piece.angle, piece.angle * float(piece.axis @ other.axis))
        return angle * other.angle > 0.0 if any_length else abs(angle - other.angle) <= MATCH_TURN

    def _mismatch(
        self, step: DisplacementStep, piece: Piece, offers: list[PlainOffer], begins: bool
    ) -> str:
        """Return what is claimed, and what the lattice has instead."""
        instead = [o for o in offers if self._same(piece, o, any_length=True)]
        instead = instead or [offer for offer in offers if offer.inside]
        said = [arc_in_words(arc_record(offer.arc)) for offer in instead[:SHOWN]]
        more = f" and {len(instead) - SHOWN} more" if len(instead) > SHOWN else ""
        why = "" if begins or isinstance(piece, Slide) else "; off the grid no rotation may begin"
        return (
            f"{arc_in_words(step.arc)} is claimed; the contact lattice there has "
            f"{'; '.join(said) or 'no arc'}{more}{why}"
        )

    def _check_depth(self, start: Pose, found: Findings) -> None:
        """Judge the number of arcs from the start to where this one begins."""
        depth = self._motion.steps.depth
        if depth is None:
            return
        deep = self._fewest(start) >= depth
        if deep:  # there may be a shorter way than the plan's
            lattice = PlainContactLattice(self._problem, self._motion)
            shortest = lattice.arcs_to(start, SEARCHED)
            deep = shortest is None or shortest >= depth
        found.check(
            "depth",
            not deep,
            f"the arc begins {self._fewest(start)} arcs from the start; the lattice's depth is "
            f"{depth}",
        )

    def _check_goal(self, how: str, found: Findings) -> None:
        goal, here = self._motion.goal, self._here
        off, turned = goal.position_error(here), goal.rotation_error(here)
        slack = self._recheck.tolerances.length
        found.check(
            "goal",
            off <= goal.distance + slack * self._D and turned <= goal.angle + slack,
            f"{how} {off:.6g} from the goal's place (allowed {goal.distance:.6g}), turned "
            f"{math.degrees(turned):.6g} deg from its rotation (allowed "
            f"{math.degrees(goal.angle):.6g})",
        )


def _place(pose: Pose) -> str:
    return listed([round(float(value), 9) + 0.0 for value in pose.position])
