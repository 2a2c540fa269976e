"""The outcome of judging a motion segment or a rest: feasible, or why not."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from gm_ompl.contact.decision import ModeDecision, Outcome


class Finding(enum.Enum):
    """What the acceptance test of Sec. 4.2 found; the value is a sentence for the user."""

    HOLDS = "the margin z reaches z_min"
    GEOMETRY = "the object or a fingertip penetrates something"
    POCKET = "a fingertip is in a pocket: no way through the air leads there"
    INTERNAL_FORCE = "every choice of modes lets fingers squeeze without bound: internal force (5)"
    NO_EQUILIBRIUM = (
        "no choice of modes free of excessive internal force (5) balances the object (3)"
    )
    UNSTABLE = "the margin z is below z_min"
    UNDECIDED = "no answer could be proven"


_REFUSALS = {
    Outcome.INTERNAL_FORCE: Finding.INTERNAL_FORCE,
    Outcome.NO_EQUILIBRIUM: Finding.NO_EQUILIBRIUM,
    Outcome.UNDECIDED: Finding.UNDECIDED,
}


@dataclass(frozen=True)
class Verdict:
    """A finding and the mode decision behind it.

    Attributes:
        finding: feasible, or why not.
        decision: of Sec. 3.4; None where geometry already fails.
    """

    finding: Finding
    decision: ModeDecision | None = None

    @property
    def holds(self) -> bool:
        """Whether the test of Sec. 4.2 is passed."""
        return self.finding is Finding.HOLDS

    @classmethod
    def of(cls, decision: ModeDecision, z_min: float) -> Verdict:
        """Return the verdict on a mode decision under the threshold ``z_min``."""
        if decision.outcome in _REFUSALS:
            return cls(_REFUSALS[decision.outcome], decision)
        return cls(Finding.HOLDS if decision.z >= z_min else Finding.UNSTABLE, decision)
