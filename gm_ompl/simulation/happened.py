"""What a plan promises in each segment, beside what happened there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.environment import contacts_at
from gm_ompl.simulation.engine import STEP
from gm_ompl.simulation.measure import FAINT, Allowed, Measurement
from gm_ompl.simulation.play import EVERY
from gm_ompl.simulation.segments import PlannedSegment, planned_segments


@dataclass(frozen=True)
class FingerPart:
    """One finger in one segment; forces and lengths in the scenario's units."""

    finger: int  # its number
    mode: str  # "force" or "position"
    asked: float  # the commanded normal force, or that with which it is to lean on the object
    least: float | None  # least normal force with which the object can be in balance, if any
    most: float | None  # the greatest
    came: float  # mean normal force
    slip: float  # farthest from where it came down, over the object, so far
    off_contact: float  # time in which it did not touch [s]


@dataclass(frozen=True)
class SegmentReport:
    """One segment of a plan as it was executed; scenario's units, degrees."""

    step: int  # of the plan
    segment: int  # of the step
    begin: float  # when it begins [s]
    end: float  # when it ends [s]
    z: float  # the stability margin that the plan promises
    position: float  # error of the centre of mass at its end
    angle: float  # error of the orientation at its end
    static_slip: float  # farthest that a static contact is from its place, along its face
    opened: float  # farthest that a contact lifts off floor or obstacle
    fingers: tuple[FingerPart, ...]  # per finger
    beyond: tuple[str, ...]  # what goes beyond a limit here; empty if nothing does

    def words(self) -> str:
        """Return promise and outcome as lines of text."""
        lines = [
            f"step {self.step}, segment {self.segment} ({self.begin:.2f} to {self.end:.2f} s), "
            f"z {self.z:.4g} promised: at its end {self.position:.3g} and {self.angle:.2f} deg "
            f"off; static contacts moved by {self.static_slip:.3g}, contacts opened by "
            f"{self.opened:.3g}"
        ]
        for part in self.fingers:
            given = "" if part.least is None else f" (balance: {part.least:.3g} to {part.most:.3g})"
            lines.append(
                f"  finger {part.finger}, {part.mode}: {part.asked:.3g} asked{given}, "
                f"{part.came:.3g} came; slipped {part.slip:.3g}"
            )
        return "\n".join(lines)


def happened(measured: Measurement, allowed: Allowed) -> tuple[SegmentReport, ...]:
    """Return every segment's promise beside its outcome, in order."""
    line, problem = measured.timeline, measured.problem
    slip, off = measured.slip(), (measured.position_error(), measured.angle_error())
    found = []
    for number, step in enumerate(measured.plan.steps):
        of_step = measured.moving & (line.step[measured.rows] == number)
        for segment in planned_segments(problem, number, step):
            here = of_step & (line.segment[measured.rows] == segment.number)
            rows = np.flatnonzero(here)
            if len(rows):
                found.append(_report(measured, segment, rows, (slip, *off), allowed))
    return tuple(found)


def first_beyond(segments: Sequence[SegmentReport]) -> SegmentReport | None:
    """Return where a limit was first passed; else where the object went astray the most."""
    beyond = next((segment for segment in segments if segment.beyond), None)
    if beyond is not None or not segments:
        return beyond
    before = [0.0, *(segment.position for segment in segments[:-1])]
    grown = [segment.position - was for segment, was in zip(segments, before, strict=True)]
    return segments[int(np.argmax(grown))]


def _report(
    measured: Measurement,
    segment: PlannedSegment,
    rows: IntArray,
    errors: tuple[Array, Array, Array],
    allowed: Allowed,
) -> SegmentReport:
    slip, position, angle = errors
    state = contacts_at(segment.part.middle, measured.problem.body, measured.problem.environment)
    along, lifted = measured.moved(rows, state.points, state.normals)
    static = ~state.slip.any(axis=1)
    moved = float(along[:, static].max(initial=0.0))
    D = measured.problem.body.diagonal
    limits = [
        ("the object is off", position[rows].max() / D, allowed.position),
        ("the object is turned", angle[rows].max(), allowed.angle),
        ("a static contact moves", moved / D, allowed.static_slip),
    ]
    for i, way in enumerate(slip[rows].max(axis=0)):
        limits.append((f"finger {i} slips", way / D, allowed.slip))
    time = measured.timeline.time[measured.rows[rows]]
    return SegmentReport(
        step=segment.step,
        segment=segment.number,
        begin=float(time[0]),
        end=float(time[-1]),
        z=segment.record.z,
        position=float(np.nan_to_num(position[rows[-1]], nan=math.inf)),
        angle=float(np.nan_to_num(angle[rows[-1]], nan=180.0)),
        static_slip=moved,
        opened=float(lifted.max(initial=0.0)),
        fingers=tuple(
            _finger(measured, i, segment.record.modes[i], rows, slip)
            for i in range(measured.timeline.fingers)
        ),
        beyond=tuple(what for what, value, limit in limits if not value <= limit),
    )


def _finger(measured: Measurement, i: int, mode: str, rows: IntArray, slip: Array) -> FingerPart:
    line, instants = measured.timeline, measured.rows[rows]
    force, normal = measured.normal_force[rows, i], line.normal[instants, i]
    leaning = float((line.lean[instants, i] * normal).sum(axis=1).mean())
    least, most = line.least[instants[0], i], line.most[instants[0], i]
    known = bool(np.isfinite(least))
    return FingerPart(
        finger=i,
        mode=mode,
        asked=float(line.f_com[instants, i].mean()) if mode == "force" else leaning,
        least=float(least) if known else None,
        most=float(most) if known else None,
        came=float(force.mean()),
        slip=float(slip[rows, i].max()),
        off_contact=float((force < FAINT * measured.weight).sum() * EVERY * STEP),
    )
