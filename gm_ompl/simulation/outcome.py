"""What came of an execution: the report, in words and as values."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from gm_ompl.simulation.happened import SegmentReport, first_beyond
from gm_ompl.simulation.measure import FingerReport
from gm_ompl.writing import plain


@dataclass(frozen=True)
class ExecutionReport:
    """One execution of a plan; lengths and forces in the scenario's units, angles in degrees."""

    name: str  # the scenario's
    findings: tuple[str, ...]  # why it did not hold; empty if it held
    notes: tuple[str, ...]  # what a reader should know
    duration: float  # of the execution [s]
    speed: float  # of the object's fastest vertex [D/s]
    # metres per unit of length, kilograms per unit of mass, newtons per unit of force
    scale: tuple[float, float, float]
    size: float  # D
    end_position: float  # error of the centre of mass at the end
    end_angle: float  # error of the orientation at the end
    position: float  # largest error of the centre of mass while the object moves
    angle: float  # largest error of the orientation while it moves
    static_slip: float  # largest way of a static contact over floor or obstacle
    fingers: tuple[FingerReport, ...]  # one report per finger
    segments: tuple[SegmentReport, ...]  # promise and outcome of every segment, in order
    # the smallest stability margin that the plan states; None if no segment has a finite one
    z: float
    inertia: float  # largest inertia force in the norm (7)
    inertia_share: float  # largest ratio of that to the plan's z at the same instant
    # per hinge of a robot hand, the greatest torque asked for, over its motor's
    torque: dict[str, float] = field(default_factory=dict)
    # bodies that a link other than a fingertip touched, by pairs of names
    touching: tuple[tuple[str, str], ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the plan could be played back."""
        return not self.findings

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON: no NaN, no infinity."""
        return {"holds": self.holds, **plain(self)}

    def table(self) -> str:
        """Return the report as lines of text."""
        D = self.size
        length, mass, force = self.scale
        lines = [
            f"{self.name}: {self.duration:.1f} s of motion simulated, fastest vertex "
            f"{self.speed:g} D/s, D = {D:.4g}",
            f"  scale        1 unit of length = {length:.4g} m, of mass = {mass:.4g} kg, "
            f"of force = {force:.4g} N",
            f"  at the end   {_of(self.end_position, D)} off, {self.end_angle:.3f} deg",
            f"  on the way   {_of(self.position, D)} off, {self.angle:.3f} deg at most",
            f"  static contacts of the object moved by {_of(self.static_slip, D)} at most",
            f"  inertia      {self.inertia:.3g} at most, {100 * self.inertia_share:.2g}% of z; "
            f"least z {self.z:.4g}",
        ]
        lines += [f"  {_finger(report, D)}" for report in self.fingers]
        if self.torque:
            shares = ", ".join(f"{name} {100 * share:.0f}%" for name, share in self.torque.items())
            lines.append(f"  torques      {shares} of the motors' at most")
        lines += [f"note: {note}" for note in self.notes]
        lines += [f"NOT: {finding}" for finding in self.findings]
        where = None if self.holds else first_beyond(self.segments)
        return "\n".join([*lines, *([] if where is None else [f"first in {where.words()}"])])


def _of(value: float, size: float) -> str:
    return f"{value:.3g} ({100 * value / size:.2g}% of D)"


def _finger(report: FingerReport, size: float) -> str:
    parts = [f"finger {report.finger}: slip {_of(report.slip, size)}"]
    if report.force_error is not None:
        parts.append(f"normal force within {100 * report.force_error:.2g}% of the command")
    if report.in_range is not None:
        parts.append(f"within the statical range {100 * report.in_range:.3g}% of the time")
    parts.append(f"at most {report.greatest_force:.3g} of {report.max_normal_force:.3g}")
    return ", ".join(parts)
