"""Why one instant fails: geometry by name, Problem (5) and z per combination of modes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import final

from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.environment import contacts_at
from gm_ompl.explain.blame import Blame
from gm_ompl.explain.values import InstantLine, ModeLine
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.mechanics.alternatives import Alternatives
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements, Problem

_AXES = ("x", "y", "z")


@final
class Explainer:
    """Explains instants of one problem.

    Args:
        problem: the problem.
        judge: its judge.
        stop: asked between instants where there are many; True ends the work early.
    """

    def __init__(
        self, problem: Problem, judge: Judge, stop: Callable[[], bool] = lambda: False
    ) -> None:
        self.problem, self.judge, self.stop = problem, judge, stop
        self._blame = Blame(problem)

    def verdict(
        self, q: Coordinates, direction: Coordinates | None, placements: Placements
    ) -> Verdict:
        """Return the judge's verdict, z exact."""
        return self.judge.segment(self.problem.motion.moment(q, direction), placements)

    def line(
        self,
        q: Coordinates,
        direction: Coordinates | None,
        placements: Placements,
        verdict: Verdict,
    ) -> InstantLine:
        """Return what blocks an instant, without the combinations of modes."""
        blocked: tuple[str, ...] = ()
        if verdict.finding is Finding.GEOMETRY:
            blocked = self._blame.configuration(q, placements)
        decision = verdict.decision
        z = decision.z if decision is not None and math.isfinite(decision.z) else None
        return InstantLine(
            q=q,
            direction=direction,
            finding=verdict.finding,
            blocked_by=blocked,
            z=z,
            ratio=self.ratio(verdict),
            limit=None if decision is None else disturbance(decision.direction),
        )

    def ratio(self, verdict: Verdict) -> float | None:
        """Return z / z_min; 0 without equilibrium, None where geometry or (5) fails first."""
        z_min = self.problem.mechanics.z_min
        if verdict.finding is Finding.NO_EQUILIBRIUM:
            return 0.0
        if verdict.decision is None or not math.isfinite(verdict.decision.z) or z_min <= 0:
            return None
        return verdict.decision.z / z_min

    def detailed(
        self, q: Coordinates, direction: Coordinates | None, placements: Placements
    ) -> InstantLine:
        """Return what blocks an instant, with every combination of modes."""
        verdict = self.verdict(q, direction, placements)
        line = self.line(q, direction, placements, verdict)
        if verdict.finding is Finding.GEOMETRY:
            return line
        return replace(line, modes=self._modes(q, direction, placements))

    def _modes(
        self, q: Coordinates, direction: Coordinates | None, placements: Placements
    ) -> tuple[ModeLine, ...]:
        problem, moment = self.problem, self.problem.motion.moment(q, direction)
        contacts = contacts_at(moment, problem.body, problem.environment)
        everyone = tuple(range(len(placements)))
        instant = problem.instant(contacts, everyone, placements)
        found = {d.modes: d for d in Alternatives.of(instant).modes(0.0)}
        every = itertools.product(ControlMode, repeat=len(placements))
        return tuple(_mode_line(modes, found.get(modes)) for modes in every)


def _mode_line(modes: tuple[ControlMode, ...], found: ModeDecision | None) -> ModeLine:
    names = tuple(mode.value for mode in modes)
    if found is None:
        return ModeLine(names, True, None, ())
    return ModeLine(names, False, found.z, found.f_com)


def disturbance(direction: int) -> str | None:
    """Return in words the direction l_i that limits z; None where none does.

    The wrench that cannot be balanced is a disturbance along l_i with the sign turned.
    """
    if direction < 0:
        return None
    if direction >= 12:
        return "a force and a moment together"
    # In Problem (6) z l_i = R^(1/2)(Q_known + contacts): the disturbance resisted is -z l_i.
    sign = "-" if direction % 2 == 0 else "+"
    axis = _AXES[(direction // 2) % 3]
    kind = "a force along" if direction < 6 else "a moment about"
    return f"{kind} the object's {sign}{axis}"
