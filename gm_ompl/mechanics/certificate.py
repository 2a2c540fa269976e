"""What proves a decision, compiled: a few dot products that do not trust the simplex.

z >= v: for one f_com, what resists each direction (``resistance``).

z <= U: wrenches y_k in the polar of the environment's cone, each with the inequality

    z h(y_k) <= q . y_k + sum_pos f_max max(0, sigma_k) + sum_force f_com sigma_k,

sigma_k = max over the finger's columns b (of unit normal force) of b . y_k, h(y) = max_i l_i . y.
Their sum bounds z for every f_com in the box. A wrench that rounding has left a little outside the
polar is moved into it along a wrench that separates all columns, Problem (5)'s own certificate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.internal_force import PASSES, separate
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.mechanics.resistance import Resistance, written_out
from gm_ompl.mechanics.sides import SIDES


class Record(NamedTuple):
    """Where a decision writes down what proves it; rooms of no size keep nothing.

    Attributes:
        sets: (M,), the sets of modes considered, position-controlled fingers as bits, -1 for none.
        wrenches: (M, K, 6), per set wrenches whose ``upper_bound`` bounds its z; zero for none.
        solutions: (M, N, 76), per set what resists each direction at its f_com, by code. Rows: tau
            (over the largest of 1 and f_max), the environment's columns, the fingers', and slacks.
    """

    sets: IntArray
    wrenches: Array
    solutions: Array


def record_of(fingers: int, columns: int) -> Record:
    """Return room for the proof of one decision, of so many fingers and columns in all."""
    most = 1 << fingers
    return Record(
        np.full(most, -1, dtype=np.int64), np.zeros((most, 32, 6)),
        np.zeros((most, 1 + columns + fingers, 2 * SIDES)),
    )  # fmt: skip


NO_RECORD = Record(np.empty(0, np.int64), np.empty((0, 0, 6)), np.empty((0, 0, 0)))
"""Keeps nothing."""


@compiled
def write_down(
    record: Record, j: int, mask: int, Y: Array, found: Resistance, solved: bool
) -> None:
    """Write down set j's wrenches Y, and its solutions where they are ``solved``."""
    if j >= len(record.sets):
        return
    record.sets[j] = mask
    record.wrenches[j] = 0.0
    for k in range(len(Y)):
        for t in range(6):
            record.wrenches[j, k, t] = Y[k, t]
    if solved:
        written_out(found, record.solutions[j])


CLOSE = 4e-7
"""Both bounds on z lie within this of each other, relative to max(z, LITTLE): else no proof."""
LITTLE = 1e-3
"""z below this (over force_scale) need only be known to CLOSE times this."""
ROOT_SIX = np.sqrt(6.0)


@compiled
def reach(L: Array, y: Array) -> float:
    """Return h(y) = max_i l_i . y of the 76 directions: axes and corners, both ways."""
    largest, total = 0.0, 0.0
    for t in range(6):
        size = abs(y[t])
        largest = size if size > largest else largest
        total += size
    return L[0, 0] * max(largest, total / ROOT_SIX)


@compiled
def support(tips: Array, i: int, y: Array) -> float:
    """Return sigma, the largest b_k . y of finger i's unit-normal-force columns."""
    best = -np.inf
    for k in range(tips.shape[1]):
        dot = 0.0
        for t in range(6):
            dot += tips[i, k, t] * y[t]
        best = max(best, dot)
    return best


@compiled
def into_polar(env: Array, separation: Separation, y: Array) -> bool:
    """Move ``y`` into the polar of the environment's cone; False where that cannot be done.

    Args:
        env: (e, 6), columns as rows, of norm 1 at least.
        separation: of these columns.
        y: (6,), changed where some a . y > 0.
    """
    w, margin = separation
    worst = 0.0
    for j in range(len(env)):
        dot = 0.0
        for t in range(6):
            dot += env[j, t] * y[t]
        worst = dot if dot > worst else worst
    if worst > 0.0:
        if not margin > 0.0:
            return False
        for t in range(6):
            y[t] -= worst / margin * w[t]
    return True


@compiled
def separates_environment(env: Array) -> Separation:
    """Return a wrench that separates the environment's columns (e, 6); the margin is 0 for none."""
    P, w = np.empty((len(env), 6)), np.empty(6)
    for j in range(len(env)):
        square = 0.0
        for t in range(6):
            square += env[j, t] * env[j, t]
        for t in range(6):
            P[j, t] = env[j, t] / np.sqrt(square)
    end, margin = separate(P, len(env), w)
    return Separation(w, margin if end == PASSES else 0.0)


@compiled
def upper_bound(program: Program, force: BoolArray, Y: Array) -> float:
    """Return the bound U on z for every f_com, from wrenches Y (K, 6) in the polar; see the top.

    Their weights are their lengths. +inf where they bound nothing.
    """
    _, q, tips, f_max, L = program
    constant, h = 0.0, 0.0
    for k in range(len(Y)):
        h += reach(L, Y[k])
        for t in range(6):
            constant += q[t] * Y[k, t]
    for i in range(len(tips)):
        slope = 0.0
        for k in range(len(Y)):
            sigma = support(tips, i, Y[k])
            slope += sigma if force[i] else max(sigma, 0.0)
        constant += f_max[i] * max(slope, 0.0)
    return constant / h if h > 0.0 else np.inf


@inlined
def unattained(program: Program, force: BoolArray, y: Array) -> float:
    """Return by how much at least any forces miss equilibrium, as y (6,) in the polar proves."""
    square = 0.0
    for t in range(6):
        square += y[t] * y[t]
    if not square > 0.0:
        return 0.0
    bound = upper_bound(program, force, y.reshape(1, 6))
    return -bound * reach(program.L, y) / np.sqrt(square)


@compiled
def proven(v: float, U: float) -> bool:
    """Whether two bounds on z, v from below and U from above, leave no more than CLOSE."""
    return U - v <= CLOSE * max(U, LITTLE)
