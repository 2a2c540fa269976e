"""What Sec. 3.4 could have chosen where it decides for several cases at once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError
from gm_ompl.mechanics import modes
from gm_ompl.mechanics.alternatives import Alternatives, Commanded, downward
from gm_ompl.mechanics.cases import count_of, matters, parts_of, program_of
from gm_ompl.mechanics.columns import wrench_norm
from gm_ompl.mechanics.family import hand_tips, surroundings
from gm_ompl.mechanics.instant import as_decision, as_mask
from gm_ompl.mechanics.kelley import force_control
from gm_ompl.mechanics.robust import Surroundings, Tips, cases_at, decide_cases
from gm_ompl.mechanics.stability import FAILED, REACHED


@final
class CaseAlternatives:
    """The choices at one instant, each judged by its worst case; forces in the scenario's units.

    Args:
        scale: the kernel's unit of force, force_scale.
        around: the contact state's columns.
        tips: the hand's at every placement.
        hand: (n,), who touches.
        rows: (n,), where.
    """

    def __init__(
        self, scale: float, around: Surroundings, tips: Tips, hand: IntArray, rows: IntArray
    ) -> None:
        self._scale, self._cases = scale, cases_at(around, tips, hand, rows)
        self._fingers = len(hand)

    @classmethod
    def of(cls, instant: Instant) -> CaseAlternatives:
        """Return the choices at an instant."""
        U, ranges = wrench_norm(instant.mass, instant.inertia), instant.uncertainty
        n, scale = len(instant.points), instant.force_scale
        tips = hand_tips(
            instant.points[:, None], instant.normals[:, None], instant.friction, instant.soft,
            instant.cone_edges, U, ranges, f_max=instant.max_normal_force / scale,
        )  # fmt: skip
        there = np.zeros(n, dtype=np.int64)
        around = surroundings(instant, ranges, U)
        return cls(scale, around, tips, np.arange(n), there)

    def decide(self, previous: int = -1) -> ModeDecision:
        """Return the best of them; ``previous`` is the mask of modes preferred among equals.

        Raises:
            SolverError: the kernel found no proof.
        """
        f = np.zeros(self._fingers)
        end, z, direction, mask, _ = decide_cases(self._cases, 0.0, previous, -1, f, np.zeros(6))
        decision = as_decision(end, z, direction, mask, f.tolist(), self._scale)
        if decision is None:
            raise SolverError("the mechanics kernel found no mode decision that it can prove")
        return decision

    def modes(self, least: float) -> tuple[ModeDecision, ...]:
        """Return every combination of modes that passes (5) with z >= ``least`` at its best f_com.

        As ``Alternatives.modes``, z the least of the cases.
        """
        passed = np.empty(1 << self._fingers, dtype=np.int64)
        passes, _ = modes.passing_sets(self._cases.around, self._cases.squeeze, -1, False, passed)
        largest = [int(mask) for mask in passed[: max(passes, 0)]]
        return downward(largest, self._fingers, lambda mask: self._best_command(mask, least))

    def _best_command(self, mask: int, least: float) -> ModeDecision | None:
        f, below = np.zeros(self._fingers), max(least / self._scale, 0.0)
        end, z, direction, _, _ = decide_cases(self._cases, below, -1, mask, f, np.zeros(6))
        if end != modes.STABLE or max(z, 0.0) * self._scale < least:
            return None
        return as_decision(end, max(z, 0.0), direction, mask, f.tolist(), self._scale)

    def at(
        self, chosen: tuple[ControlMode, ...], f_com: Array
    ) -> tuple[float, float, Array] | None:
        """Return (z, c, slopes) of the worst case, as ``Alternatives.at``."""
        worst = None
        for commanded, force, f, press in self._each(chosen, f_com):
            slopes = np.zeros(len(f_com))
            end, z, c = commanded.margin(force, f, slopes)
            if end != REACHED:
                return None
            if worst is None or z * self._scale < worst[0]:
                worst = z * self._scale, c * self._scale, slopes * press
        return worst

    def balanced(
        self, chosen: tuple[ControlMode, ...], f_com: Array
    ) -> tuple[bool, float, Array] | None:
        """Return (whether the load is balanced in every case, c, slopes), as ``Alternatives``."""
        for commanded, force, f, press in self._each(chosen, f_com):
            slopes = np.zeros(len(f_com))
            end, c = commanded.equilibrium(force, f, slopes)
            if end != REACHED:
                return None if end == FAILED else (False, c * self._scale, slopes * press)
        return True, np.inf, np.zeros(len(f_com))

    def _each(
        self, chosen: tuple[ControlMode, ...], f_com: Array
    ) -> Iterator[tuple[Commanded, BoolArray, Array, Array]]:
        """Yield each case that matters: who is force-controlled, f_com (n,), the errors in it."""
        mask, n = as_mask(chosen), self._fingers
        force, f = np.zeros(n, dtype=np.bool_), np.zeros(n)
        force_control(mask, force)
        for case in range(count_of(self._cases)):
            if matters(self._cases, case, mask):
                press = self._cases.press[parts_of(self._cases, case)[-1]][force]
                f[force] = np.minimum(f_com / self._scale * press, self._cases.f_max[force])
                yield Commanded(program_of(self._cases, case)), force, f, press


Choices: TypeAlias = Alternatives | CaseAlternatives
"""What could be decided at an instant, in one case or in several."""


def choices_at(instant: Instant) -> Choices:
    """Return the choices at an instant, for all its cases."""
    return (CaseAlternatives if instant.uncertainty else Alternatives).of(instant)


def decide_in_cases(
    instant: Instant, previous: tuple[ControlMode, ...] | None = None
) -> ModeDecision:
    """Decide Sec. 3.4 for all cases of an instant, exactly.

    Raises:
        SolverError: the kernel found no proof; the reference may.
    """
    return CaseAlternatives.of(instant).decide(as_mask(previous))
