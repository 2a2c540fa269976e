"""Arcs to and from what a plan file says of them."""

from __future__ import annotations

import numpy as np

from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.planar import UPRIGHT, Straight
from gm_ompl.motion.screw import UP, Piece, Screw, Slide, Tumble
from gm_ompl.planfile.model import DisplacementStep, Plan
from gm_ompl.planfile.record import (
    ArcRecord,
    PoseRecord,
    RotationArc,
    StraightArc,
    StraightLine,
    TranslationArc,
    Turn,
)
from gm_ompl.problem import Problem

ROUNDING = 1e-12  # what a quaternion in a file may have rounded away
WHOLE = 1e-9  # what an arc may lack of a step, relative to it, to be one


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


def arc_of(step: DisplacementStep, problem: Problem) -> Arc:
    """Return the arc of a displacement step, from what the file says of it."""
    record, start = step.arc, pose_of(step.pose_from)
    if isinstance(record, StraightArc):
        line = record.straight
        attitude = rotation_about(UP, -line.from_[2]) @ start.rotation
        if np.abs(attitude - UPRIGHT).max() <= ROUNDING:
            attitude = UPRIGHT
        height = step.pose_from.position[2]
        return Straight(line.from_, line.to, height, attitude, problem.motion.ends)
    piece: Piece
    if isinstance(record, TranslationArc):
        piece = Slide(np.array(record.translation))
    else:
        turn = record.rotation
        piece = Tumble(np.array(turn.point), np.array(turn.axis), turn.angle)
    pitch = _pitch(piece, problem, len(step.segments))
    return Screw(start, piece, pitch=pitch, ends=problem.motion.ends)


def steps_of(piece: Piece, motion: FreeMotion) -> float:
    """Return over how many steps of the contact lattice a motion goes."""
    if isinstance(piece, Slide):
        return float(np.linalg.norm(piece.by)) / motion.steps.translation
    return abs(piece.angle) / motion.steps.rotation


def _pitch(piece: Piece, problem: Problem, parts: int) -> float | None:
    """Return how long a segment is, in t: an arc shorter than a step has a shorter last one.

    None where all are equal, and where ``parts`` segments of the nominal length do not fit.
    """
    if not isinstance(problem.motion, FreeMotion):
        return None
    segments = problem.cost.samples_per_arc * steps_of(piece, problem.motion)
    short = parts - 1 < segments < problem.cost.samples_per_arc * (1.0 - WHOLE)
    return 1.0 / segments if short else None


def pose_of(record: PoseRecord) -> Pose:
    """Return the pose that a plan file states."""
    return Pose.from_quaternion(record.position, record.quaternion)


def pose_before(plan: Plan, number: int, problem: Problem) -> Pose:
    """Return the pose at which step ``number`` begins."""
    step = plan.steps[number]
    if step.kind == "displacement":
        return pose_of(step.pose_from)
    if step.at:
        return problem.motion.pose(step.at)
    ends = [s.pose_to for s in plan.steps[:number] if s.kind == "displacement"]
    return pose_of(ends[-1]) if ends else problem.motion.pose(())
