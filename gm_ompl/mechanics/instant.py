"""The kernel for one Instant: columns built, decision made, units put back."""

from __future__ import annotations

import functools
import math

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError
from gm_ompl.mechanics import columns, modes
from gm_ompl.mechanics.central import settle_commands
from gm_ompl.mechanics.certificate import NO_RECORD, Record, record_of

OUTCOMES = {
    modes.INTERNAL_FORCE: Outcome.INTERNAL_FORCE,
    modes.NO_EQUILIBRIUM: Outcome.NO_EQUILIBRIUM,
}
DIRECTIONS = columns.directions()


def as_mask(previous: tuple[ControlMode, ...] | None) -> int:
    """Return the bit mask of a combination of modes, -1 for None."""
    if previous is None:
        return -1
    return sum(1 << i for i, mode in enumerate(previous) if mode is ControlMode.POSITION)


def as_decision(
    end: int, z: float, direction: int, mask: int, f_com: list[float], scale: float
) -> ModeDecision | None:
    """Return the ModeDecision of a kernel answer whose forces are in units of ``scale``.

    None where the kernel found no proof.
    """
    if end == modes.STABLE:
        held = _held(mask, len(f_com))
        forces = [
            None if mode is ControlMode.POSITION else f * scale
            for mode, f in zip(held, f_com, strict=True)
        ]
        return ModeDecision(Outcome.STABLE, z * scale, held, tuple(forces), direction)
    if end == modes.UNDER:
        return ModeDecision(Outcome.BELOW, z * scale)
    outcome = OUTCOMES.get(end)
    return None if outcome is None else ModeDecision(outcome, -math.inf)


@functools.cache
def _held(mask: int, fingers: int) -> tuple[ControlMode, ...]:
    """Return a bit mask's modes."""
    return tuple(
        ControlMode.POSITION if (mask >> i) & 1 else ControlMode.FORCE for i in range(fingers)
    )


def instant_columns(instant: Instant) -> tuple[Array, Array, Array, Array]:
    """Return (env (e, 6), q (6,), tips (n, s, 6), f_max (n,)), forces over force_scale.

    Soft fingers have two columns more than s.
    """
    U, s = columns.wrench_norm(instant.mass, instant.inertia), instant.cone_edges
    given = instant.contact_friction
    friction = given if len(given) else float(instant.environment_friction)
    env = columns.environment_columns(instant.contacts, friction, s, U)
    scale = instant.force_scale
    q = columns.load(instant.contacts.rotation, instant.mass * instant.gravity / scale, U)
    if instant.excess.any():
        q += U @ (instant.excess / scale)
    tips = columns.hand_columns(
        instant.points[:, None], instant.normals[:, None], instant.friction, instant.soft, s, U
    )
    return env, q, np.ascontiguousarray(tips[:, 0]), instant.max_normal_force / scale


def decide_columns(
    env: Array, q: Array, tips: Array, f_max: Array, below: float, f_com: Array, y: Array,
    previous: int = -1, only: int = -1,
) -> tuple[int, float, int, int]:  # fmt: skip
    """Decide Sec. 3.4 for a hand given by its columns (n, s, 6); the rest as ``modes.decide``."""
    everyone, there = np.arange(len(tips)), np.zeros(len(tips), dtype=np.int64)
    return modes.decide(
        env, q, tips[:, None], everyone, there, f_max, DIRECTIONS, below, previous, only,
        NO_RECORD, f_com, y,
    )  # fmt: skip


def decide_instant(
    instant: Instant, previous: tuple[ControlMode, ...] | None = None
) -> ModeDecision:
    """Decide Sec. 3.4 for one instant, exactly.

    Raises:
        SolverError: the kernel found no proof; the reference may.
    """
    env, q, tips, f_max = instant_columns(instant)
    f_com = np.zeros(len(f_max))
    answer = decide_columns(
        env, q, tips, f_max, 0.0, f_com, np.zeros(6), previous=as_mask(previous)
    )
    settle_commands(env, q, tips, f_max, answer, DIRECTIONS, f_com)
    return _in_units(instant, answer, f_com)


def prove_instant(instant: Instant) -> tuple[ModeDecision, Record]:
    """Decide Sec. 3.4 for one instant, exactly; return what proves it as well.

    Raises:
        SolverError: the kernel found no proof; the reference may.
    """
    env, q, tips, f_max = instant_columns(instant)
    n = len(f_max)
    record, f_com = record_of(n, len(env) + n * tips.shape[1]), np.zeros(n)
    everyone, there = np.arange(n), np.zeros(n, dtype=np.int64)
    answer = modes.decide(
        env, q, tips[:, None], everyone, there, f_max, DIRECTIONS, 0.0, -1, -1, record, f_com,
        np.zeros(6),
    )  # fmt: skip
    settle_commands(env, q, tips, f_max, answer, DIRECTIONS, f_com)
    return _in_units(instant, answer, f_com), record


def _in_units(instant: Instant, answer: tuple[int, float, int, int], f_com: Array) -> ModeDecision:
    """Return a kernel answer in the instant's units of force."""
    end, z, direction, mask = answer
    decision = as_decision(end, z, direction, mask, f_com.tolist(), instant.force_scale)
    if decision is None:
        raise SolverError("the mechanics kernel found no mode decision that it can prove")
    return decision
