"""What an execution showed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gm_ompl.writing import plain


@dataclass(frozen=True)
class Allowed:
    """What still counts as holding; lengths in diagonals D of the object.

    Attributes:
        end_position: error of the centre of mass at the end; 2 mm for the cork box.
        end_angle: error of the orientation at the end [deg].
        position: error of the centre of mass on the way.
        angle: error of the orientation on the way [deg].
        slip: way of a fingertip over the object, between touch-down and lifting.
        static_slip: way of a static contact over floor or obstacle.
        force: relative error of a commanded normal force, averaged over ``window``.
        window: over which forces are averaged [s].
    """

    end_position: float = 2.0 / 131.15
    end_angle: float = 1.0
    position: float = 0.03
    angle: float = 3.0
    slip: float = 0.005
    static_slip: float = 0.01
    force: float = 0.1
    window: float = 0.05


@dataclass(frozen=True)
class FingerReport:
    """What one finger did; forces and lengths in the scenario's units.

    Attributes:
        finger: its number.
        slip: largest way over the object between touch-down and lifting.
        force_controlled: share of the motion under force control.
        force_error: largest relative error of the commanded normal force, averaged over 50 ms;
            None if it was never force-controlled.
        mean_force_error: mean of that error.
        in_range: share of the motion under position control, averaged over 50 ms, in which the
            normal force lies between the least and the greatest that statics allows, up to 5% of
            the object's weight; None if it was never position-controlled.
        greatest_force: greatest normal force, averaged over 50 ms.
        max_normal_force: f_max.
        off_contact: time during which it should have touched and did not [s].
    """

    finger: int
    slip: float
    force_controlled: float
    force_error: float | None
    mean_force_error: float | None
    in_range: float | None
    greatest_force: float
    max_normal_force: float
    off_contact: float


@dataclass(frozen=True)
class ExecutionReport:
    """One execution of a plan; lengths and forces in the scenario's units, angles in degrees.

    Attributes:
        name: the scenario's.
        findings: why it did not hold; empty if it held.
        notes: what a reader should know.
        duration: of the execution [s].
        speed: of the object's fastest vertex [D/s].
        scale: metres per unit of length, kilograms per unit of mass, newtons per unit of force.
        size: D.
        end_position: error of the centre of mass at the end.
        end_angle: error of the orientation at the end.
        position: largest error of the centre of mass while the object moves.
        angle: largest error of the orientation while it moves.
        static_slip: largest way of a static contact over floor or obstacle.
        fingers: one report per finger.
        z: the smallest stability margin that the plan states; None if no segment has a finite one.
        inertia: largest inertia force in the norm (7).
        inertia_share: largest ratio of that to the plan's z at the same instant.
    """

    name: str
    findings: tuple[str, ...]
    notes: tuple[str, ...]
    duration: float
    speed: float
    scale: tuple[float, float, float]
    size: float
    end_position: float
    end_angle: float
    position: float
    angle: float
    static_slip: float
    fingers: tuple[FingerReport, ...]
    z: float
    inertia: float
    inertia_share: float

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
        lines += [f"note: {note}" for note in self.notes]
        lines += [f"NOT: {finding}" for finding in self.findings]
        return "\n".join(lines)


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
