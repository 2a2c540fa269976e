"""Arcs to and from what a plan file says of them."""

from __future__ import annotations

import numpy as np

from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.planar import UPRIGHT, Straight
from gm_ompl.motion.screw import UP, Screw, Slide, Tumble
from gm_ompl.planfile.model import DisplacementStep
from gm_ompl.planfile.record import (
    ArcRecord,
    RotationArc,
    StraightArc,
    StraightLine,
    TranslationArc,
    Turn,
)

ROUNDING = 1e-12  # what a quaternion in a file may have rounded away


def arc_record(arc: Arc) -> ArcRecord:
    """Return what a plan file says of ``arc``, beside the pose where it begins."""
    if isinstance(arc, Straight):
        return StraightArc(straight=StraightLine(from_=arc.tail, to=arc.head))
    if not isinstance(arc, Screw):
        raise InputError(f"a plan file has no form for arcs of the kind {type(arc).__name__}")
    piece = arc.piece
    if isinstance(piece, Slide):
        return TranslationArc(translation=tuple(piece.by.tolist()))
    point, axis = tuple(piece.pivot.tolist()), tuple(piece.axis.tolist())
    return RotationArc(rotation=Turn(point=point, axis=axis, angle=float(piece.angle)))


def arc_of(step: DisplacementStep) -> Arc:
    """Return the arc of a displacement step, from what the file says of it alone."""
    record = step.arc
    start = Pose.from_quaternion(step.pose_from.position, step.pose_from.quaternion)
    if isinstance(record, TranslationArc):
        return Screw(start, Slide(np.array(record.translation)))
    if isinstance(record, RotationArc):
        turn = record.rotation
        return Screw(start, Tumble(np.array(turn.point), np.array(turn.axis), turn.angle))
    line = record.straight
    attitude = rotation_about(UP, -line.from_[2]) @ start.rotation
    if np.abs(attitude - UPRIGHT).max() <= ROUNDING:
        attitude = UPRIGHT
    return Straight(line.from_, line.to, step.pose_from.position[2], attitude)
