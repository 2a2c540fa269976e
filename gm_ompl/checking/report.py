"""What a check found: collected step by step, and told with every violation's reason."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.writing import plain

Numbers: TypeAlias = float | Sequence[float] | Array


@dataclass(frozen=True)
class Violation:
    """One claim of the plan that does not hold.

    Attributes:
        step: number of the step, from 0 as in the file's list; None for the plan as a whole.
        segment: number of the segment within the step, from 0, or None.
        topic: what kind of claim, one word or two ("pose", "placement", "z", ...).
        message: what is claimed, what holds, and by how much they differ.
    """

    step: int | None
    segment: int | None
    topic: str
    message: str

    def __str__(self) -> str:
        place = "plan" if self.step is None else f"step {self.step}"
        if self.segment is not None:
            place += f", segment {self.segment}"
        return f"{place}: {self.topic}: {self.message}"


@dataclass(frozen=True)
class StepReport:
    """What holds in one step.

    Attributes:
        step: the step's number, from 0.
        kind: "displacement" or "regrasp".
        where: what the step does, in coordinates and fingers.
        z: the least stability margin recomputed in the step; None where none could be.
        cost: the step's cost recomputed; None where it could not be.
        checked: the topics that were judged, in order.
        failed: those of them with a violation.
    """

    step: int
    kind: str
    where: str
    z: float | None
    cost: float | None
    checked: tuple[str, ...]
    failed: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether nothing in the step is violated."""
        return not self.failed


@dataclass(frozen=True)
class CheckReport:
    """The judgement on a plan.

    Attributes:
        status: the status that the plan claims.
        steps: per step what holds.
        violations: everything that does not hold, in order of the steps.
        notes: what a reader should know of the judgement.
    """

    status: str
    steps: tuple[StepReport, ...]
    violations: tuple[Violation, ...]
    notes: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the whole plan holds."""
        return not self.violations

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON."""
        steps = [{**plain(step), "holds": step.holds} for step in self.steps]
        return {"holds": self.holds, **plain(self), "steps": steps}

    def table(self) -> str:
        """Return the report as text: a row per step, then violations and notes."""
        rows = [("step", "kind", "where", "least z", "cost", "holds")]
        rows += [
            (
                str(step.step),
                step.kind,
                step.where,
                "-" if step.z is None else f"{step.z:.6g}",
                "-" if step.cost is None else f"{step.cost:.6g}",
                ", ".join(step.checked) if step.holds else f"NOT: {', '.join(step.failed)}",
            )
            for step in self.steps
        ]
        lines = _aligned(rows) if self.steps else []
        lines += [str(violation) for violation in self.violations]
        lines += [f"note: {note}" for note in self.notes]
        count = len(self.violations)
        plural = "s" if count > 1 else ""
        verdict = f"the plan does NOT hold: {count} violation{plural}"
        if self.holds:
            planned = bool(self.steps) or self.status == "solved"
            verdict = "the plan holds" if planned else f"consistent ({self.status}, no plan)"
        return "\n".join([*lines, verdict])


def _aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


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

    def claim(
        self,
        topic: str,
        what: str,
        values: tuple[Numbers, Numbers],
        allowed: float,
        *,
        where: str,
        segment: int | None = None,
    ) -> bool:
        """Judge numbers that the plan claims by those that hold.

        Args:
            topic: what kind of claim.
            what: the name of the value.
            values: what is claimed, and what holds.
            allowed: by how much they may differ.
            where: what makes the second hold, before "it is".
            segment: number of the segment, if any.
        """
        off = float(np.abs(np.subtract(*values)).max())
        have, want = map(listed, values)
        message = f"{what} {have} is claimed; {where} it is {want} (off by {off:.3g}, allowed "
        return self.check(topic, off <= allowed, f"{message}{allowed:.3g})", segment)

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


def listed(values: Numbers) -> str:
    """Return a number, or numbers as a plan file's list."""
    if isinstance(values, (int, float)):
        return f"{values:.9g}"
    return "[" + ", ".join(f"{float(value):.9g}" for value in values) + "]"
