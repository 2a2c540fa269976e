"""Steps in words: what the object does, and where; and a whole plan's chain of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.deeds import Doing, axis_name, doing
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.screw import Screw, Slide
from gm_ompl.planfile.arcs import arc_of
from gm_ompl.planfile.model import Plan
from gm_ompl.planfile.record import ArcRecord, RotationArc, TranslationArc
from gm_ompl.problem import Problem

SAME = 1e-6
"""Lines and directions that differ by at most this are one."""


def arc_in_words(arc: ArcRecord) -> str:
    """Return "slides 1.8 along -x", or "turns 15 deg about +y through [0.5, 0, 0]"."""
    if isinstance(arc, TranslationArc):
        return _along("slides", np.array(arc.translation))
    if isinstance(arc, RotationArc):
        turn = arc.rotation
        return f"{_about('turns', np.array(turn.axis), turn.angle)} through {listed(turn.point)}"
    line = arc.straight
    return f"moves from {listed(line.from_)} to {listed(line.to)}"


def screw_in_words(arc: Screw, done: Doing) -> str:
    """Return "slides 1.8 along -x", or "tumbles 15 deg about +y over its +x edge"."""
    piece, verb = arc.piece, done.deed.value
    if isinstance(piece, Slide):
        return _along(verb, piece.by)
    over = "" if done.over is None else f" over {done.over}"
    return _about(verb, piece.axis, piece.angle) + over


def pose_in_words(pose: Pose, start: Pose) -> str:
    """Return "[0.5, 0, 0.5], turned 90 deg about +y since the start"."""
    turn = Pose(pose.rotation @ start.rotation.T, pose.position).quaternion()
    sine = float(np.linalg.norm(turn[1:]))
    place = listed(pose.position.tolist())
    if sine <= SAME:
        return f"{place}, not turned since the start"
    angle = 2.0 * math.atan2(sine, float(turn[0]))
    return f"{place}, {_about('turned', turn[1:] / sine, angle)} since the start"


class ChainLink(NamedTuple):
    """One thing that the object does in a plan, over one arc or several, or a regrasp.

    Attributes:
        steps: numbers of the first and the last of the plan's steps that belong to it.
        words: "slides 1.8 along -x".
    """

    steps: tuple[int, int]
    words: str


def chain(plan: Plan, problem: Problem) -> tuple[ChainLink, ...]:
    """Return what the object does in a plan, step by step; the same going on is one link.

    A regrasp is a link of its own, before which the object may do the same as after it. Nothing for
    planar motion: its arcs are straight lines in x, y and yaw.

    Args:
        plan: the plan.
        problem: the one that it is for.
    """
    return tuple(_links(plan, problem))


def _links(plan: Plan, problem: Problem) -> Iterator[ChainLink]:
    whole: tuple[int, Screw, Doing] | None = None
    last = 0
    for number, step in enumerate(plan.steps):
        if step.kind == "regrasp":
            if whole is not None:
                yield ChainLink((whole[0], last), screw_in_words(whole[1], whole[2]))
            whole, place = None, step.to
            words = f"finger {step.finger} moves to {place.words}"
            yield ChainLink((number, number), words)
            continue
        arc = arc_of(step, problem)
        if not isinstance(arc, Screw):
            return
        done = doing(arc, problem.body, problem.environment)
        if whole is not None:
            first, before, was = whole
            longer = _joined(before, arc) if was.deed is done.deed else None
            if longer is not None:
                whole, last = (first, longer, was), number
                continue
            yield ChainLink((first, last), screw_in_words(before, was))
        whole, last = (number, arc, done), number
    if whole is not None:
        yield ChainLink((whole[0], last), screw_in_words(whole[1], whole[2]))


def _joined(before: Screw, arc: Screw) -> Screw | None:
    """Return two screws as one, from where the first begins; None where they are not."""
    a, b = before.piece, arc.piece
    if isinstance(a, Slide) or isinstance(b, Slide):
        if not (isinstance(a, Slide) and isinstance(b, Slide)):
            return None
        off = np.cross(a.by, b.by)
        size = float(np.linalg.norm(a.by) * np.linalg.norm(b.by))
        if float(np.linalg.norm(off)) > SAME * size or a.by @ b.by < 0.0:
            return None
        return Screw(before.start, Slide(a.by + b.by))
    ahead = float(a.axis @ b.axis)
    if abs(abs(ahead) - 1.0) > SAME or a.angle * b.angle * ahead < 0.0:
        return None
    arm = b.pivot - a.pivot
    size = float(np.linalg.norm(before.start.position - a.pivot))
    if float(np.linalg.norm(np.cross(arm, a.axis))) > SAME * max(size, SAME):
        return None
    angle = a.angle + math.copysign(abs(b.angle), a.angle)
    return Screw(before.start, type(a)(a.pivot, a.axis, angle))


def _along(verb: str, by: Array) -> str:
    length = float(np.linalg.norm(by))
    return f"{verb} {length:.6g} along {direction_in_words((by / (length or 1.0)).tolist())}"


def _about(verb: str, axis: Array, angle: float) -> str:
    size = math.copysign(float(np.linalg.norm(axis)) or 1.0, angle)
    about = direction_in_words((axis / size).tolist())
    return f"{verb} {math.degrees(abs(angle)):.6g} deg about {about}"


def direction_in_words(unit: Sequence[float]) -> str:
    """Return "-x", or the unit vector (3,) where it is no axis."""
    return axis_name(unit) or listed(unit)


def listed(values: Sequence[float]) -> str:
    """Return "[1, 0.5, 0]"."""
    return "[" + ", ".join(f"{round(value, 9) + 0.0:.4g}" for value in values) + "]"
