"""z_strong beside z along a plan: what is held whatever the contacts do, and what gives way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode
from gm_ompl.errors import InputError
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.reference.modes import margin
from gm_ompl.reference.strong import StrongMargin, strong_margin
from gm_ompl.tolerance.sites import Site, sites
from gm_ompl.writing import plain


@dataclass(frozen=True, eq=False)
class StrongSite:
    """Both margins at an instant of a plan.

    Attributes:
        step: number of the step.
        segment: of the segment in it; None while the object rests.
        z: of Problem (6), for the plan's modes and commands.
        z_strong: at most z.
        gives_way: what every contact does where z_strong is less than z.
        wrench: (6,), the disturbance about the centre of mass under which it does, object frame.
    """

    step: int
    segment: int | None
    z: float
    z_strong: float
    gives_way: tuple[str, ...]
    wrench: Array

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "step": self.step, "segment": self.segment, "z": plain(self.z),
            "z_strong": plain(self.z_strong), "gives_way": list(self.gives_way),
            "wrench": self.wrench.tolist(),
        }  # fmt: skip


@dataclass(frozen=True)
class StrongReport:
    """Both margins all along a plan.

    Attributes:
        name: the scenario's.
        sites: the middle of every segment, and every rest of a regrasp, in the plan's order.
    """

    name: str
    sites: tuple[StrongSite, ...]

    @property
    def least(self) -> StrongSite:
        """Where z_strong is least."""
        return min(self.sites, key=lambda site: site.z_strong)

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values."""
        return {
            "name": self.name, "z": plain(min(site.z for site in self.sites)),
            "z_strong": plain(self.least.z_strong),
            "sites": [site.to_dict() for site in self.sites],
        }  # fmt: skip

    def table(self) -> str:
        """Return the report as text."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        least = self.least
        yield (
            f"{self.name}: z is {min(site.z for site in self.sites):.4g} at least, "
            f"z_strong {least.z_strong:.4g}"
        )
        for step, group in groupby(self.sites, key=lambda site: site.step):
            here = list(group)
            worst = min(here, key=lambda site: site.z_strong)
            ways = f": {', '.join(worst.gives_way)}" if worst.gives_way else ""
            yield (
                f"  step {step}: z {min(site.z for site in here):.4g}, "
                f"z_strong {worst.z_strong:.4g}{ways}"
            )


def strong(plan: Plan, problem: Problem) -> StrongReport:
    """Return both margins along a plan for ``problem``, in its nominal world.

    Raises:
        InputError: the plan has no step.
        SolverError: the solver returned no answer.
        LimitError: a limit in force is reached.
    """
    if not plan.steps:
        raise InputError(f"the plan has no steps (status {plan.status!r}): nothing to hold")
    known: dict[object, tuple[float, StrongMargin]] = {}
    found = []
    for site in sites(plan, problem):
        if site.key not in known:
            known[site.key] = margins_at(site)
        z, held = known[site.key]
        found.append(StrongSite(site.step, site.segment, z, held.z, held.modes, held.wrench))
    return StrongReport(problem.name, tuple(found))


def margins_at(site: Site) -> tuple[float, StrongMargin]:
    """Return z and what is strongly held at an instant of a plan.

    Raises:
        SolverError: the solver returned no answer.
        LimitError: a limit in force is reached.
    """
    commands = [
        float(f) if mode is ControlMode.FORCE else None
        for f, mode in zip(site.f_com, site.modes, strict=True)
    ]
    z = margin(site.instant, site.modes, commands)
    if z <= 0.0:
        return z, StrongMargin(z, (), np.zeros(6))
    return z, strong_margin(site.instant, site.modes, commands, z, site.fingers)
