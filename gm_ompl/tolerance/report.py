"""What a plan tolerates, as values, as text and as JSON."""

from __future__ import annotations

import enum
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from gm_ompl.tolerance.quantities import Quantity, shown
from gm_ompl.uncertainty.worlds import World
from gm_ompl.writing import plain


class IntervalEnd(enum.Enum):
    """Why an interval, or a factor, goes no further; the value is a sentence."""

    FAILS = "just beyond, z falls below z_min or Problem (5) fails"
    LIMIT = "nothing further was looked at"
    PROOF = "beyond, nothing is proven"


@dataclass(frozen=True)
class End:
    """One end of an interval.

    Attributes:
        x: it is proven to hold up to here.
        ending: why it goes no further.
        step: number of the step that ends it; None where none does.
    """

    x: float
    ending: IntervalEnd = IntervalEnd.LIMIT
    step: int | None = None


@dataclass(frozen=True)
class Interval:
    """How far one quantity may be off, all others nominal.

    Attributes:
        quantity: which.
        low: the lower end, at most 0.
        high: the upper end, at least 0.
    """

    quantity: Quantity
    low: End
    high: End

    def to_dict(self) -> dict[str, Any]:
        """Return the interval as plain values."""
        return {
            "quantity": self.quantity.name, "part": self.quantity.part or None,
            "nominal": self.quantity.nominal,
            **{
                side: {"off_by": end.x, "ending": plain(end.ending), "step": end.step}
                for side, end in (("low", self.low), ("high", self.high))
            },
        }  # fmt: skip


@dataclass(frozen=True)
class Factor:
    """How far all ranges may be widened together.

    Attributes:
        x: modes and commands are proven to hold in all worlds of the ranges times this.
        ending: why it is no larger.
        step: number of the step that ends it; None where none does.
        world: just beyond, one in which they do not hold; None where none is known.
    """

    x: float
    ending: IntervalEnd = IntervalEnd.LIMIT
    step: int | None = None
    world: World | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the factor as plain values."""
        return {
            "factor": self.x, "ending": plain(self.ending), "step": self.step,
            "world": plain(self.world),
        }  # fmt: skip


@dataclass(frozen=True)
class StepTolerance:
    """What one step tolerates.

    Attributes:
        step: its number.
        holds: whether it holds in the world as modelled.
        intervals: one per quantity.
        together: all ranges at once; None where there are none.
    """

    step: int
    holds: bool
    intervals: tuple[Interval, ...]
    together: Factor | None

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "step": self.step, "holds": self.holds,
            "intervals": [interval.to_dict() for interval in self.intervals],
            "together": None if self.together is None else self.together.to_dict(),
        }  # fmt: skip


@dataclass(frozen=True)
class Tolerance:
    """What a plan tolerates.

    Attributes:
        name: the scenario's.
        z_min: what z must be at least in every world.
        ranges: in words, what ``together`` widens.
        stated: whether they are the scenario's own.
        steps: step by step.
        intervals: of the whole plan, one per quantity.
        together: all ranges at once, of the whole plan; None where there are none.
    """

    name: str
    z_min: float
    ranges: tuple[str, ...]
    stated: bool
    steps: tuple[StepTolerance, ...]
    intervals: tuple[Interval, ...]
    together: Factor | None

    @property
    def holds(self) -> bool:
        """Whether the plan holds in the world as modelled."""
        return all(step.holds for step in self.steps)

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON."""
        return {
            "holds": self.holds, "name": self.name, "z_min": self.z_min,
            "ranges": list(self.ranges), "stated": self.stated,
            "intervals": [interval.to_dict() for interval in self.intervals],
            "together": None if self.together is None else self.together.to_dict(),
            "steps": [step.to_dict() for step in self.steps],
        }  # fmt: skip

    def table(self) -> str:
        """Return the report as text."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        if not self.holds:
            failing = ", ".join(str(step.step) for step in self.steps if not step.holds)
            yield f"{self.name}: does NOT hold even as modelled (steps {failing})"
            return
        yield f"{self.name}: modes and commanded forces hold with z of at least {self.z_min:g}"
        yield "while one of these is off by no more (intervals of several do not combine):"
        rows = [
            (
                interval.quantity.label, shown(interval.quantity, interval.low.x), "to",
                shown(interval.quantity, interval.high.x), _ends(interval),
            )
            for interval in self.intervals
        ]  # fmt: skip
        widths = [max(len(row[k]) for row in rows) for k in range(4)]
        for label, low, to, high, ends in rows:
            yield (
                f"  {label.ljust(widths[0])}  {low.rjust(widths[1])} {to} "
                f"{high.rjust(widths[3])}  {ends}"
            ).rstrip()
        if self.together is not None:
            origin = "the scenario's ranges" if self.stated else "the default ranges"
            yield f"and in all worlds of {origin} ({', '.join(self.ranges)})"
            yield f"times {self.together.x:.3g} ({_factor_end(self.together)})"
            factors = [
                f"{step.step}: {step.together.x:.3g}" for step in self.steps if step.together
            ]
            yield f"by step: {', '.join(factors)}"


def _ends(interval: Interval) -> str:
    """Return why both ends are where they are."""
    parts = []
    for end, limit in zip((interval.low, interval.high), interval.quantity.limits, strict=True):
        if end.ending is IntervalEnd.LIMIT:
            parts.append(limit)
        else:
            parts.append(f"step {end.step}{'' if end.ending is IntervalEnd.FAILS else ' (proof)'}")
    return " | ".join(parts)


def _factor_end(factor: Factor) -> str:
    """Return why a factor is no larger."""
    place = "" if factor.step is None else f"step {factor.step}: "
    return f"{place}{factor.ending.value}"
