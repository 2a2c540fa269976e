"""Sec. 3.4 by z_strong, stated plainly: all modes, all commands that are offered, one by one."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator

import numpy as np

from gm_ompl import limits
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome, command_steps
from gm_ompl.contact.state import Instant
from gm_ompl.reference.modes import Modes, combinations, decide_modes, margin, passes
from gm_ompl.reference.strong import strong_margin

BETTER = 1e-7
"""By how much, relatively, later modes and commands must be better."""


def decide_strongly(instant: Instant, prefer: Modes | None = None) -> ModeDecision:
    """Return the modes that pass Problem (5) and the commands whose z_strong is largest.

    Commands are those of ``command_steps``. Of equals the first counts, most position
    control and large commands first; where no forces balance, or no modes pass (5), it is what
    Sec. 3.4 finds.

    Args:
        instant: the contacts, the fingers, the object.
        prefer: without meaning here.

    Raises:
        SolverError: the solver returned no answer.
        LimitError: a limit in force is reached.
    """
    nominal = decide_modes(instant, prefer)
    if nominal.outcome is not Outcome.STABLE:
        return nominal
    best, enough = ModeDecision(Outcome.NO_EQUILIBRIUM, -np.inf), -np.inf
    for modes in combinations(len(instant.points)):
        if not passes(instant, modes):
            continue
        for f_com in _commands(instant, modes):
            limits.check()
            z = margin(instant, modes, f_com)
            if z <= enough or z == -np.inf:
                continue
            held = strong_margin(instant, modes, f_com, z, enough=enough).z
            if held > enough:
                best = ModeDecision(Outcome.STABLE, held, modes, f_com, -1, z)
                enough = held * (1.0 + BETTER)
    return best


def _commands(instant: Instant, modes: Modes) -> Iterator[tuple[float | None, ...]]:
    steps = np.array(command_steps(modes.count(ControlMode.FORCE)))
    offered = [
        (steps * most).tolist() if mode is ControlMode.FORCE else [None]
        for mode, most in zip(modes, instant.max_normal_force, strict=True)
    ]
    yield from itertools.product(*offered)


def decision_for(strong: bool) -> Callable[..., ModeDecision]:
    """Return what decides instants, by z_strong or by z."""
    return decide_strongly if strong else decide_modes
