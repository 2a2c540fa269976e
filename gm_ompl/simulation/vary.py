"""Executions in worlds that differ from the model by a few per cent."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gm_ompl.simulation.execute import Setup, execute
from gm_ompl.simulation.report import ExecutionReport
from gm_ompl.simulation.world import KINDS, World, lifted, varied
from gm_ompl.writing import plain


@dataclass(frozen=True)
class VariationReport:
    """Executions of one plan in several worlds.

    Attributes:
        error_limit: the greatest error, 0.03 for three per cent.
        kinds: what is off: ``KINDS`` or some of them.
        z: the smallest stability margin that the plan states.
        runs: by the seed of the errors.
    """

    error_limit: float
    kinds: tuple[str, ...]
    z: float
    runs: dict[int, ExecutionReport]

    @property
    def share(self) -> float:
        """Share of the executions that held."""
        return sum(run.holds for run in self.runs.values()) / max(len(self.runs), 1)

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON."""
        kept = ("holds", "findings", "end_position", "end_angle")
        runs = [
            {"seed": seed, **{name: plain(getattr(run, name)) for name in kept}}
            for seed, run in self.runs.items()
        ]
        told = {"success": self.share, "share": self.error_limit, "kinds": self.kinds, "z": self.z}
        return {**plain(told), "runs": runs}

    def table(self) -> str:
        """Return the report as lines of text."""
        failed = {seed: run for seed, run in self.runs.items() if not run.holds}
        lines = [
            f"{', '.join(self.kinds)} off by up to {100 * self.error_limit:g}%: "
            f"{len(self.runs) - len(failed)} of {len(self.runs)} executions hold "
            f"({100 * self.share:.1f}%); least z {self.z:.4g}"
        ]
        return "\n".join([*lines, *(f"  seed {k}: {r.findings[0]}" for k, r in failed.items())])


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
    runs = {
        number: execute(setup, errant_world(setup, share, number, kinds), slack=share)
        for number in range(seed, seed + count)
    }
    least = setup.plan.least_z
    return VariationReport(share, tuple(kinds), math.inf if least is None else least, runs)
