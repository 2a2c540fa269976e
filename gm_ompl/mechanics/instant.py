"""The kernel for one Instant: columns built, decision made, units put back."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError
from gm_ompl.mechanics import columns, modes

OUTCOMES = {
    modes.STABLE: Outcome.STABLE,
    modes.INTERNAL_FORCE: Outcome.INTERNAL_FORCE,
    modes.NO_EQUILIBRIUM: Outcome.NO_EQUILIBRIUM,
}
DIRECTIONS = columns.directions()


def as_mask(previous: tuple[ControlMode, ...] | None) -> int:
    """Return the bit mask of a combination of modes, -1 for None."""
    if previous is None:
        return -1
    return sum(1 << i for i, mode in enumerate(previous) if mode is ControlMode.POSITION)


def as_decision(end: int, z: float, direction: int, mask: int, f_com: Array) -> ModeDecision:
    """Return the ModeDecision of an exact kernel answer, forces in the units of ``f_com``.

    Raises:
        SolverError: the kernel gave up.
    """
    if end not in OUTCOMES:
        raise SolverError("the mechanics kernel found neither a mode decision nor a proof")
    if end != modes.STABLE:
        return ModeDecision(OUTCOMES[end], -np.inf)
    held = [bool((mask >> i) & 1) for i in range(len(f_com))]
    return ModeDecision(
        Outcome.STABLE,
        float(z),
        tuple(ControlMode.POSITION if p else ControlMode.FORCE for p in held),
        tuple(None if p else float(f) for p, f in zip(held, f_com, strict=True)),
        int(direction),
    )


def instant_columns(instant: Instant) -> tuple[Array, Array, Array, Array]:
    """Return (env (e, 6), q (6,), tips (n, s, 6), f_max (n,)), forces over force_scale."""
    U = columns.wrench_norm(instant.mass, instant.inertia)
    s, n = instant.cone_edges, len(instant.points)
    env = columns.environment_columns(instant.contacts, instant.environment_friction, s, U)
    scale = instant.force_scale
    q = columns.load(instant.contacts.rotation, instant.mass * instant.gravity / scale, U)
    tips = np.empty((n, s, 6))
    for i in range(n):
        at = slice(i, i + 1)
        tips[i] = columns.fingertip_columns(
            instant.points[at], instant.normals[at], float(instant.friction[i]), s, U
        )[0]
    return env, q, tips, instant.max_normal_force / scale


def decide_instant(
    instant: Instant, previous: tuple[ControlMode, ...] | None = None
) -> ModeDecision:
    """Decide Sec. 3.4 for one instant, exactly.

    Raises:
        SolverError: the kernel gave up.
    """
    env, q, tips, f_max = instant_columns(instant)
    f_com = np.zeros(len(f_max))
    end, z, direction, mask = modes.decide(
        env, q, tips, f_max, DIRECTIONS, 0.0, as_mask(previous), f_com, np.zeros(6)
    )
    scale = instant.force_scale
    return as_decision(end, z * scale, direction, mask, f_com * scale)
