"""The kernel for one Instant: columns built, decision made, units put back."""

from __future__ import annotations

import functools
import math

import numpy as np

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError
from gm_ompl.mechanics import columns, modes
from gm_ompl.mechanics.central import settle_commands
from gm_ompl.mechanics.certificate import NO_RECORD, Record, record_of
from gm_ompl.mechanics.program import Program, Touch

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


def instant_program(instant: Instant) -> Program:
    """Return an instant's data; soft fingers have two columns more than s."""
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
    f_max = instant.max_normal_force / scale
    return Program(env, q, np.ascontiguousarray(tips[:, 0]), f_max, DIRECTIONS)


def touching(program: Program) -> Touch:
    """Return all fingers of a program, each at its only placement."""
    env, q, tips, f_max, L = program
    n = len(tips)
    return Touch(env, q, tips[:, None], f_max, L, np.arange(n), np.zeros(n, dtype=np.int64))


def decide_instant(
    instant: Instant, previous: tuple[ControlMode, ...] | None = None
) -> ModeDecision:
    """Decide Sec. 3.4 for one instant, exactly.

    Raises:
        SolverError: the kernel found no proof; the reference may.
    """
    return _decided(instant, instant_program(instant), as_mask(previous), NO_RECORD)


def prove_instant(instant: Instant) -> tuple[ModeDecision, Record]:
    """Decide Sec. 3.4 for one instant, exactly; return what proves it as well.

    Raises:
        SolverError: the kernel found no proof; the reference may.
    """
    program = instant_program(instant)
    n, s, _ = program.tips.shape
    record = record_of(n, len(program.env) + n * s)
    return _decided(instant, program, -1, record), record


def _decided(instant: Instant, program: Program, previous: int, record: Record) -> ModeDecision:
    """Decide, in the instant's units of force; ``previous`` is a mask, -1 for none."""
    f_com = np.zeros(len(program.f_max))
    answer = modes.decide(touching(program), 0.0, previous, -1, record, f_com, np.zeros(6))
    settle_commands(program, answer, f_com)
    decision = as_decision(*answer, f_com.tolist(), instant.force_scale)
    if decision is None:
        raise SolverError("the mechanics kernel found no mode decision that it can prove")
    return decision
