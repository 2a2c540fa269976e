"""Eq. (3) without disturbance: whether it has a solution, and what to command at z = 0.

There Problem (6) leaves f_com free. The centre of the largest cube of commands with equilibrium
is taken: one program has a balance for each of its corners.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.reference import highs
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.statics import Statics

BALANCED = 1e-9
"""Forces that leave no more of the load than this (over M g) are in equilibrium (convention)."""

FLAT = 1e-7
"""Half a side up to this (over the larger of M g and f_max) is no size: the solver's rounding."""


def balance_program(model: Statics, limits: Array, force: BoolArray) -> LinearProgram:
    """Build: minimise what is missing in any row, t; variables t, k.

    Args:
        model: the mechanics.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
        force: (n,), which fingers are force-controlled.
    """
    A, normal = blocks(model)
    rows = np.vstack([A, normal])
    side = np.append(-model.load, limits)
    low = np.append(-model.load, np.where(force, limits, -np.inf))
    ones, none = np.ones((len(rows), 1)), np.full(len(rows), np.inf)
    return LinearProgram(
        cost=np.append(1.0, np.zeros(A.shape[1])),
        matrix=sparse.csc_array(np.vstack([np.hstack([ones, rows]), np.hstack([-ones, rows])])),
        row_lower=np.concatenate([low, -none]),
        row_upper=np.concatenate([none, side]),
        col_lower=np.zeros(1 + A.shape[1]),
        col_upper=np.full(1 + A.shape[1], np.inf),
    )


def in_equilibrium(
    model: Statics, limits: Array, force: BoolArray, allowed: float = BALANCED
) -> bool:
    """Whether Eq. (3) has a solution without disturbance, but for ``allowed`` in any row.

    Args:
        model: the mechanics.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
        force: (n,), which fingers are force-controlled.
        allowed: over M g.

    Raises:
        SolverError: the solver returned no answer.
    """
    return highs.solve(balance_program(model, limits, force)).objective <= allowed


def central_command(model: Statics, force: BoolArray) -> Array | None:
    """Return the commands (n,) to take at z = 0, f_max under position control.

    The centre of the largest cube of commands with equilibrium. Where that has no size, as
    equilibrium ties commands together, it is the cube of the first fingers whose commands are free
    of each other, and the others follow. None where nothing balances the load.

    Raises:
        SolverError: the solver returned no answer.
    """
    flat = FLAT * max(1.0, float(model.f_max.max(initial=0.0)))
    commands, free = model.f_max.copy(), np.zeros(model.fingers, dtype=bool)
    half, centre = largest_cube(model, force)
    if half > flat:
        return np.where(force, centre, commands)
    for i in np.flatnonzero(force):
        free[i] = True
        half, centre = largest_cube(model, free)
        free[i] = half > flat
        commands = np.where(free, centre, commands) if free[i] else commands
    found = highs.solve(balance_program(model, commands, free))
    if not found.objective <= BALANCED:
        return None
    _, normal = blocks(model)
    pressing = np.clip(normal @ np.maximum(found.x[1:], 0.0), 0.0, model.f_max)
    return np.where(force & ~free, pressing, commands)


def largest_cube(model: Statics, force: BoolArray) -> tuple[float, Array]:
    """Return half a side and centre (n,) of the largest cube of commands with equilibrium.

    Args:
        model: the mechanics.
        force: (n,), whose commands these are; the other fingers press as they like.

    Returns:
        -1 and f_max where nothing balances the load.

    Raises:
        SolverError: the solver returned no answer.
    """
    found = highs.solve(_cube_program(model, force))
    if found.status is not LpStatus.OPTIMAL:
        return -1.0, model.f_max
    own = np.flatnonzero(force)
    centre = model.f_max.copy()
    centre[own] = np.clip(found.x[1 : 1 + len(own)], 0.0, model.f_max[own])
    return max(float(found.x[0]), 0.0), centre


def _cube_program(model: Statics, force: BoolArray) -> LinearProgram:
    """Build: maximise r such that every corner c +- r of the cube has a balance k.

    Variables r, c, then k per corner; rows per corner: equilibrium (6), a normal force per finger.
    """
    A, normal = blocks(model)
    own = np.flatnonzero(force)
    n, nf, K = model.fingers, len(own), A.shape[1]
    signs = 1.0 - 2.0 * ((np.arange(1 << nf)[:, None] >> np.arange(nf)) & 1)
    tied = np.zeros((len(signs), 6 + n, 1 + nf))
    for j, i in enumerate(own):
        tied[:, 6 + i, 0], tied[:, 6 + i, 1 + j] = -signs[:, j], -1.0
    block = sparse.kron(sparse.eye_array(len(signs)), sparse.csc_array(np.vstack([A, normal])))
    inside = np.vstack([np.hstack([-np.ones((nf, 1)), np.eye(nf)]),
                        np.hstack([-np.ones((nf, 1)), -np.eye(nf)])])  # fmt: skip
    corners = sparse.hstack([sparse.csc_array(tied.reshape(-1, 1 + nf)), block])
    box = sparse.hstack([sparse.csc_array(inside), sparse.csc_array((2 * nf, len(signs) * K))])
    low = np.append(-model.load, np.where(force, 0.0, -np.inf))
    high = np.append(-model.load, np.where(force, 0.0, model.f_max))
    return LinearProgram(
        cost=np.append(1.0, np.zeros(nf + len(signs) * K)),
        matrix=sparse.csc_array(sparse.vstack([corners, box])),
        row_lower=np.concatenate([np.tile(low, len(signs)), np.zeros(nf), -model.f_max[own]]),
        row_upper=np.append(np.tile(high, len(signs)), np.full(2 * nf, np.inf)),
        col_lower=np.zeros(1 + nf + len(signs) * K),
        col_upper=np.full(1 + nf + len(signs) * K, np.inf),
        maximise=True,
    )


def blocks(model: Statics) -> tuple[Array, Array]:
    """Return A, (6, e + r), and the normal parts of its columns, (n, e + r)."""
    env = model.env_wrenches
    A = np.hstack([env, model.rob_wrenches])
    normal = np.hstack([np.zeros((model.fingers, env.shape[1])), model.normal_parts])
    return A, normal
