"""Problem (6): the stability margin z for given control modes, stated whole and in pieces.

Forces, z and f_com in this file are in units of ``Statics.scale``.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.equilibrium import BALANCED, blocks, in_equilibrium
from gm_ompl.reference.exact import Effort, balanced, exact_margin
from gm_ompl.reference.exact_command import exact_best
from gm_ompl.reference.program import LinearProgram, LpSolution, LpStatus
from gm_ompl.reference.statics import Statics

K = 2.0 * np.sqrt(3.0 - np.sqrt(6.0))
"""Length of every direction l_i: their convex hull then circumscribes the unit ball."""

DIRECTIONS = K * np.array(
    [sign * axis for axis in np.eye(6) for sign in (1.0, -1.0)]
    + [np.array(signs) / np.sqrt(6.0) for signs in itertools.product((1.0, -1.0), repeat=6)]
)
"""l_1..l_76, (76, 6): +k e_1, -k e_1, +k e_2, ..., then the corners, (+,...,+) first and the
last coordinate's sign changing fastest."""

NEGLIGIBLE = 1e-9
"""A margin this small against the object's weight is the solver's rounding: z = 0."""


@dataclass(frozen=True, eq=False)
class Stability:
    """The optimum of Problem (6) for given modes.

    Attributes:
        z: the margin; 0 if some direction cannot be resisted at all, -inf without equilibrium,
            +inf where every disturbance can be resisted.
        f_com: (n,), commanded normal forces, 0 under position control; empty if z is -inf.
        direction: number of the direction that limits z, or -1.
        residual: largest violation of a constraint by the solution behind ``z``.
    """

    z: float
    f_com: Array
    direction: int
    residual: float


def stability(model: Statics, modes: Sequence[ControlMode]) -> Stability:
    """Solve Problem (6) for the given modes, f_com chosen best.

    Exact arithmetic solves what HiGHS does not.

    Raises:
        SolverError: neither returned an answer.
    """
    if ControlMode.FORCE not in modes:
        return stability_at(model, modes, np.zeros(model.fingers))
    try:
        return stability_of(highs.solve(stability_program(model, modes)), model.fingers)
    except SolverError:
        effort, nobody = Effort(), np.zeros(model.fingers, dtype=bool)
        best = exact_best(model, _force(modes), effort)
        if best.least > 0.0 or balanced(model, model.f_max, nobody, effort):
            return Stability(best.least, best.f_com, best.direction, 0.0)
        return Stability(-np.inf, np.zeros(0), -1, 0.0)


def stability_program(model: Statics, modes: Sequence[ControlMode]) -> LinearProgram:
    """Build Problem (6) whole: variables z, f_com (n), then k_env and k_rob per direction.

    Rows per direction i: ``-z l_i + A k_i = -R^(1/2) Q_known`` (six), then one per finger,
    ``n^T f <= f_max`` under position and ``n^T f - f_com = 0`` under force control.
    As the directions are symmetric, no z < 0 is needed: if z can be negative it can be 0.
    """
    n, N = model.fingers, len(DIRECTIONS)
    force = _force(modes)
    A, normal = blocks(model)
    k = A.shape[1]
    toward_f_com = np.vstack([np.zeros((6, n)), -np.diag(force.astype(float))])
    coupling = np.vstack([
        np.column_stack([np.append(-direction, np.zeros(n)), toward_f_com])
        for direction in DIRECTIONS
    ])  # fmt: skip
    repeated = sparse.kron(sparse.eye_array(N), sparse.csc_array(np.vstack([A, normal])))
    return LinearProgram(
        cost=np.append(1.0, np.zeros(n + N * k)),
        matrix=sparse.csc_array(sparse.hstack([sparse.csc_array(coupling), repeated])),
        row_lower=np.tile(np.append(-model.load, np.where(force, 0.0, -np.inf)), N),
        row_upper=np.tile(np.append(-model.load, np.where(force, 0.0, model.f_max)), N),
        col_lower=np.zeros(1 + n + N * k),
        col_upper=np.concatenate(
            [[np.inf], np.where(force, model.f_max, 0.0), np.full(N * k, np.inf)]
        ),
        maximise=True,
    )


def stability_of(solution: LpSolution, fingers: int) -> Stability:
    """Read z, f_com and the limiting direction off a solution of ``stability_program``."""
    if solution.status is LpStatus.INFEASIBLE:
        return Stability(-np.inf, np.zeros(0), -1, 0.0)
    if solution.status is LpStatus.UNBOUNDED:
        return Stability(np.inf, np.zeros(fingers), -1, 0.0)
    z, f_com = float(solution.x[0]), np.maximum(solution.x[1 : 1 + fingers], 0.0)
    # Raising z costs sum_i y_i . l_i = 1: the largest share is the direction that limits.
    y = solution.dual.reshape(len(DIRECTIONS), 6 + fingers)[:, :6]
    shares = np.abs(np.einsum("ij,ij->i", y, DIRECTIONS))
    z = z if z > NEGLIGIBLE else 0.0
    return Stability(z, f_com, int(shares.argmax()), solution.primal_residual())


def stability_at(
    model: Statics, modes: Sequence[ControlMode], f_com: Array, allowed: float = BALANCED
) -> Stability:
    """Solve Problem (6) for fixed f_com, (n,), one small program per direction.

    With f_com fixed the directions share nothing but z, so z is the least of the z_i. Exact
    arithmetic solves what HiGHS does not. Where some direction cannot be resisted, forces that
    balance the load but for ``allowed`` are in equilibrium: z is 0 then.

    Raises:
        SolverError: neither returned an answer.
    """
    force = _force(modes)
    limits = np.where(force, f_com, model.f_max)
    try:
        return _stability_by_highs(model, limits, force, f_com, allowed)
    except SolverError:
        effort = Effort()
        found = exact_margin(model, limits.tolist(), force, effort)
        if found.z > 0.0 or balanced(model, limits, force, effort, allowed):
            return Stability(found.z, f_com, found.direction, 0.0)
        return Stability(-np.inf, np.zeros(0), found.direction, 0.0)


def _stability_by_highs(
    model: Statics, limits: Array, force: BoolArray, f_com: Array, allowed: float
) -> Stability:
    program = direction_program(model, limits, force)
    solver = highs.Solver(program)
    least, direction, residual = np.inf, -1, 0.0
    for i in _GRAY:
        rows = np.append(DIRECTIONS[i], np.zeros(model.fingers))
        solution = solver.solve_for(np.where(np.isinf(program.row_lower), -np.inf, rows), rows)
        if solution.status is LpStatus.INFEASIBLE:
            z = 0.0 if in_equilibrium(model, limits, force, allowed) else -np.inf
            return Stability(z, f_com if z == 0.0 else np.zeros(0), int(i), residual)
        tau = solution.objective
        z = 1.0 / tau if tau > NEGLIGIBLE else np.inf
        if np.isfinite(z):
            residual = max(residual, z * solution.primal_residual())
        if z < least:
            least, direction = z, int(i)
    return Stability(least if least > NEGLIGIBLE else 0.0, f_com, direction, residual)


def _force(modes: Sequence[ControlMode]) -> BoolArray:
    """Return which fingers are force-controlled, (n,)."""
    return np.array([mode is ControlMode.FORCE for mode in modes], dtype=bool)


def resistances(model: Statics, limits: Array, force: BoolArray) -> Array:
    """Return z_i, (76,): the largest multiple of each l_i that can be resisted.

    Args:
        model: the mechanics.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
        force: (n,) bool, which fingers are force-controlled.

    Returns:
        0 where a direction cannot be resisted at all, is not shown to be, or without equilibrium.
    """
    program = direction_program(model, limits, force)
    solver, found = highs.Solver(program), np.zeros(len(DIRECTIONS))
    for i in _GRAY:
        rows = np.append(DIRECTIONS[i], np.zeros(model.fingers))
        try:
            solution = solver.solve_for(np.where(np.isinf(program.row_lower), -np.inf, rows), rows)
        except SolverError:
            continue
        if solution.status is LpStatus.OPTIMAL:
            found[i] = 1.0 / solution.objective if solution.objective > NEGLIGIBLE else np.inf
    return found


def direction_program(model: Statics, limits: Array, force: BoolArray) -> LinearProgram:
    """Build: minimise tau = 1/z_i subject to ``tau q + A k = l_i``, k >= 0, tau >= 0.

    It is Problem (6) for one direction, divided by z: per finger the normal force is at most
    (position) or exactly (force) ``limits`` times tau. The rows' bounds hold l_i, here 0.
    """
    A, normal = blocks(model)
    tau = np.append(model.load, -limits)
    zero = np.zeros(6 + model.fingers)
    return LinearProgram(
        cost=np.append(1.0, np.zeros(A.shape[1])),
        matrix=sparse.csc_array(np.hstack([tau[:, None], np.vstack([A, normal])])),
        row_lower=np.append(zero[:6], np.where(force, 0.0, -np.inf)),
        row_upper=zero,
        col_lower=np.zeros(1 + A.shape[1]),
        col_upper=np.full(1 + A.shape[1], np.inf),
    )


def _gray_order() -> list[int]:
    """Return the directions so that neighbouring corners differ in one sign."""
    corners = [12 + (i ^ (i >> 1)) for i in range(64)]
    return [*range(12), *corners]


_GRAY = _gray_order()
