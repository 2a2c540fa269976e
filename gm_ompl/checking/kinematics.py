"""What a check asks of the object's motion alone: its poses, its arcs, start and goal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TypeAlias

from gm_ompl.checking.report import Findings
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc
from gm_ompl.planfile.model import DisplacementStep, RegraspStep

AnyStep: TypeAlias = DisplacementStep | RegraspStep


class Kinematics(ABC):
    """Judges how the object moves; asked about a plan's steps in their order."""

    @abstractmethod
    def continuity(self, last: AnyStep | None, step: AnyStep, found: Findings) -> None:
        """Judge whether the object is at ``step`` where ``last`` left it, or at the start."""

    @abstractmethod
    def displacement(self, step: DisplacementStep, found: Findings) -> Arc | None:
        """Judge ends, poses, arc and number of segments.

        Returns:
            The arc along which the segments can be judged; None where there is none.
        """

    @abstractmethod
    def rest(self, step: RegraspStep, found: Findings) -> Pose | None:
        """Judge where a regrasp says the object is, and return that pose; None where nowhere."""

    @abstractmethod
    def goal(self, last: AnyStep, found: Findings) -> None:
        """Judge whether the object ends in the goal."""

    @abstractmethod
    def at_once(self, found: Findings) -> None:
        """Judge whether the start lies in the goal already."""

    @abstractmethod
    def place(self, step: AnyStep) -> str:
        """Return in words where a step is and what the object does."""


def regrasp_in_words(step: RegraspStep) -> str:
    """Return "finger 1 to +x:[0, 2]"."""
    return f"finger {step.finger} to {step.to.words.replace(' ', ':', 1)}"
