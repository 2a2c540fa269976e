"""Collects violations while a plan is judged."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from gm_ompl.check.report import StepReport, Violation


@dataclass
class Findings:
    """What was judged, and what did not hold, in one step (or in the plan as a whole).

    Attributes:
        step: the step's number, or None for the plan as a whole.
        violations: found so far.
        checked: topics judged so far, in order.
        z: the least margin recomputed so far.
        cost: the step's recomputed cost.
    """

    step: int | None
    violations: list[Violation] = field(default_factory=list)
    checked: list[str] = field(default_factory=list)
    z: float | None = None
    cost: float | None = None

    def check(self, topic: str, holds: bool, message: str = "", segment: int | None = None) -> bool:
        """Note that ``topic`` was judged, and the violation if it does not hold."""
        if topic not in self.checked:
            self.checked.append(topic)
        if not holds:
            self.violations.append(Violation(self.step, segment, topic, message))
        return holds

    def margin(self, z: float) -> None:
        """Note a recomputed margin."""
        self.z = z if self.z is None else min(self.z, z)

    def report(self, kind: str, where: str) -> StepReport:
        """Return the step's report."""
        failed = {violation.topic for violation in self.violations}
        return StepReport(
            step=-1 if self.step is None else self.step,
            kind=kind,
            where=where,
            z=self.z,
            cost=self.cost,
            checked=tuple(self.checked),
            failed=tuple(topic for topic in self.checked if topic in failed),
        )


def listed(values: Iterable[float]) -> str:
    """Return numbers as a plan file's list."""
    return "[" + ", ".join(f"{float(value):.9g}" for value in values) + "]"
