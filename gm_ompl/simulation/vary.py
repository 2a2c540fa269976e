"""Executions in worlds that differ from the model by a few per cent."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gm_ompl.simulation.execute import Setup, execute
from gm_ompl.simulation.report import plain
from gm_ompl.simulation.world import KINDS, World, lifted, varied


@dataclass(frozen=True)
class VariedRun:
    """One execution in a world that differs from the model.

    Attributes:
        seed: of the errors.
        holds: whether the plan held.
        findings: why not.
        end_position: error of the centre of mass at the end, scenario's units.
        end_angle: error of the orientation at the end [deg].
    """

    seed: int
    holds: bool
    findings: tuple[str, ...]
    end_position: float
    end_angle: float


@dataclass(frozen=True)
class VariationReport:
    """Executions of one plan in several worlds.

    Attributes:
        share: the greatest error, 0.03 for three per cent.
        kinds: what is off: ``KINDS`` or some of them.
        z: the smallest stability margin that the plan states.
        runs: one per seed.
    """

    share: float
    kinds: tuple[str, ...]
    z: float
    runs: tuple[VariedRun, ...]

    @property
    def success(self) -> float:
        """Share of the executions that held."""
        return sum(run.holds for run in self.runs) / max(len(self.runs), 1)

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON."""
        return {"success": self.success, **plain(asdict(self))}

    def table(self) -> str:
        """Return the report as lines of text."""
        held = sum(run.holds for run in self.runs)
        lines = [
            f"{', '.join(self.kinds)} off by up to {100 * self.share:g}%: {held} of "
            f"{len(self.runs)} executions hold ({100 * self.success:.1f}%); least z {self.z:.4g}"
        ]
        lines += [f"  seed {r.seed}: {r.findings[0]}" for r in self.runs if not r.holds]
        return "\n".join(lines)


def errant_world(setup: Setup, share: float, seed: int, kinds: Collection[str] = KINDS) -> World:
    """Return a world that is off by up to ``share`` in ``kinds``."""
    first = setup.timeline
    inward = np.einsum("ji,nj->ni", first.rotation[0], first.normal[0])
    other = varied(setup.world, share, inward, np.random.default_rng(seed), kinds)
    return lifted(other, setup.world, first.rotation[0])


def vary(
    setup: Setup, share: float, count: int, seed: int, kinds: Sequence[str] = KINDS
) -> VariationReport:
    """Execute a plan in ``count`` worlds that are off by up to ``share``.

    Position and angle may be off by that much more than otherwise.

    Args:
        setup: the plan, made ready.
        share: 0.03 for three per cent.
        count: number of worlds, their seeds ``seed``, ``seed + 1``, ...
        seed: of the first.
        kinds: which of ``KINDS`` are off.
    """
    runs = []
    for number in range(seed, seed + count):
        report = execute(setup, errant_world(setup, share, number, kinds), slack=share)
        runs.append(
            VariedRun(number, report.holds, report.findings, report.end_position, report.end_angle)
        )
    least = setup.plan.least_z
    return VariationReport(share, tuple(kinds), math.inf if least is None else least, tuple(runs))
