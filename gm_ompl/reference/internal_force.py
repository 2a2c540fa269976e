"""Problem (5): could position-controlled fingers build up internal force without limit?"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from scipy import sparse
from scipy.optimize import nnls

from gm_ompl.arrays import Array
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.exact_separation import nearest
from gm_ompl.reference.program import LinearProgram
from gm_ompl.reference.statics import Statics

RESIDUAL = 1e-9
"""A wrench this small in norm (7), of unit-norm edge wrenches weighted by k with sum 1, counts
as none: forces that cancel up to it are internal."""


@dataclass(frozen=True, eq=False)
class InternalForce:
    """The verdict of Problem (5) with its certificate.

    Attributes:
        excessive: whether internal force could grow without limit.
        wrenches: (6, e), the unit-norm wrenches of all edges that may press, R^(1/2) applied.
        ray: (e,), where excessive: k >= 0 with sum 1 whose wrenches cancel; empty where exact
            arithmetic told.
        residual: norm (7) of what is left of them; +inf without a ray.
        wrench: (6,), where not excessive: unit vector y with y . a >= margin for every column
            a of ``wrenches``; no k >= 0 but 0 can then cancel.
        margin: that least product: the origin is at least as far from the columns' convex
            hull; +inf where there are no columns, -inf without a separating wrench.
        marginal: neither certificate holds; ``excessive`` then, to be on the safe side.
    """

    excessive: bool
    wrenches: Array
    ray: Array
    residual: float
    wrench: Array
    margin: float
    marginal: bool


def excessive_internal_force(model: Statics, position: Collection[int]) -> InternalForce:
    """Judge Problem (5) with the given fingers under position control.

    Exact arithmetic judges where HiGHS gives no certificate.
    """
    return judged(unit_wrenches(model, position))


def judged(A: Array) -> InternalForce:
    """Judge Problem (5) for wrenches (6, e) of unit norm, those of several cases together."""
    if A.shape[1] == 0:
        none = np.zeros(0)
        return InternalForce(False, A, none, np.inf, np.zeros(6), np.inf, False)
    try:
        solution = highs.solve(internal_force_program(A))
        verdict = certify(A, solution.x, solution.dual[:6])
        if verdict.marginal:
            # The optimum's own multipliers need not separate well: ask for the best certificates.
            best = highs.solve(separation_program(A))
            verdict = certify(A, cancelling(A, np.abs(best.dual)), best.x[:6])
    except SolverError:
        return exactly(A)
    return exactly(A) if verdict.marginal else verdict


def exactly(A: Array) -> InternalForce:
    """Judge wrenches (6, e), e at least 1, of unit norm in exact arithmetic."""
    x = nearest([[Fraction(value) for value in column] for column in A.T.tolist()])
    distance = math.sqrt(sum(value * value for value in x))
    longest = max(abs(value) for value in x) or Fraction(1)
    y = np.array([float(value / longest) for value in x])
    y /= float(np.linalg.norm(y)) or 1.0
    fails = sum(value * value for value in x) < Fraction(RESIDUAL) ** 2
    margin = -np.inf if fails else float((y @ A).min())
    none = np.zeros(0)
    return InternalForce(fails, A, none, distance, none if fails else y, margin, False)


def unit_wrenches(model: Statics, position: Collection[int]) -> Array:
    """Return R^(1/2) W C, (6, e), columns scaled to unit norm (7), force control left out."""
    rob = model.rob_wrenches
    columns = [model.env_wrenches, *(rob[:, model.columns[i]] for i in sorted(position))]
    A = np.hstack(columns)
    units: Array = A / np.linalg.norm(A, axis=0)
    return units


def internal_force_program(A: Array) -> LinearProgram:
    """Build Problem (5) with the sum of k limited to 1: its optimum is 1 (unbounded) or 0.

    Args:
        A: (6, e), the wrenches that may act.
    """
    e = A.shape[1]
    return LinearProgram(
        cost=np.ones(e),
        matrix=sparse.csc_array(np.vstack([A, np.ones(e)])),
        row_lower=np.append(np.zeros(6), -np.inf),
        row_upper=np.append(np.zeros(6), 1.0),
        col_lower=np.zeros(e),
        col_upper=np.full(e, np.inf),
        maximise=True,
    )


def separation_program(A: Array) -> LinearProgram:
    """Build: maximise t subject to y . a >= t for every column a, |y_i| <= 1.

    Its optimum is the least sum of |A k| over k >= 0 with sum 1; k are the rows' multipliers.
    """
    e = A.shape[1]
    return LinearProgram(
        cost=np.append(np.zeros(6), 1.0),
        matrix=sparse.csc_array(np.hstack([A.T, -np.ones((e, 1))])),
        row_lower=np.zeros(e),
        row_upper=np.full(e, np.inf),
        col_lower=np.append(-np.ones(6), -np.inf),
        col_upper=np.append(np.ones(6), np.inf),
        maximise=True,
    )


def certify(A: Array, k: Array, y: Array) -> InternalForce:
    """Judge by what ``k`` (a candidate ray) and ``y`` (a candidate wrench) really prove."""
    k = np.maximum(k, 0.0)
    total = float(k.sum())
    ray = k / total if total > 0.5 else np.zeros(0)
    residual = float(np.linalg.norm(A @ ray)) if len(ray) else np.inf
    if residual <= RESIDUAL:
        return InternalForce(True, A, ray, residual, np.zeros(0), -np.inf, False)
    size = float(np.linalg.norm(y))
    wrench = y / size if size > 0 else np.zeros(6)
    margin = float((wrench @ A).min()) if size > 0 else -np.inf
    separated = margin > RESIDUAL
    return InternalForce(not separated, A, ray, residual, wrench, margin, not separated)


def cancelling(A: Array, k: Array) -> Array:
    """Return the k >= 0 on the same columns whose wrenches cancel best, with sum near 1.

    Least squares on the few columns in use removes the solver's rounding.
    """
    used = np.flatnonzero(k > RESIDUAL)
    better = np.zeros_like(k)
    better[used], _ = nnls(np.vstack([A[:, used], np.ones(len(used))]), np.append(np.zeros(6), 1.0))
    return better
