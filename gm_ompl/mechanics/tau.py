"""The tau program of Problem (6), compiled: its columns, and the tableaus that hold it.

For fixed modes and f_com the blocks of (6) share nothing but z, and z = 1 / max_i tau_i with

    tau_i = min tau  subject to  tau q + A k = l_i,  per finger sum_k = cap tau,  tau, k >= 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.program import Program
from gm_ompl.mechanics.resistance import Resistance, new_resistance
from gm_ompl.mechanics.sides import width

UNUSED = -1
"""Stands for the first basic variable of a tableau that is not filled."""


class Tableau(NamedTuple):
    """A tau program, its tableau, and what a pass over the directions proves.

    Attributes:
        raw: (m, N), columns: tau, the environment's, the fingers', a slack per finger.
        T: (m, W), the tableau.
        d: (W,), reduced costs.
        basis: (m,), the basic variable of each row.
        y: (m,), duals.
        found: what resists each direction.
    """

    raw: Array
    T: Array
    d: Array
    basis: IntArray
    y: Array
    found: Resistance


class Work(NamedTuple):
    """Tableaus of programs that share columns, kept from pass to pass.

    Attributes:
        raw: (m, N), columns of the program at hand.
        T: (K, m, W), tableaus.
        d: (K, W), reduced costs.
        basis: (K, m).
        y: (m,), duals of the last pass.
        found: what resists each direction, likewise.
        tau: (K, m), the raw tau column of the tableau's last pass.
        change: (m,), what the program at hand adds to it.
    """

    raw: Array
    T: Array
    d: Array
    basis: IntArray
    y: Array
    found: Resistance
    tau: Array
    change: Array


@compiled
def new_tableau(n: int, e: int, s: int) -> Tableau:
    """Return an unused tableau for n fingers of s columns, e columns of the environment."""
    m, N = 6 + n, 1 + e + n * s + n
    W = width(m, N)
    basis = np.empty(m, dtype=np.int64)
    basis[0] = UNUSED
    return Tableau(
        np.empty((m, N)), np.empty((m, W)), np.empty(W), basis, np.zeros(m), new_resistance(m)
    )


@compiled
def new_work(K: int, seed: Tableau) -> Work:
    """Return K unused tableaus; what is of the last pass alone, they share with ``seed``."""
    raw, _, d, _, y, found = seed
    m, W = len(raw), len(d)
    basis = np.empty((K, m), dtype=np.int64)
    for k in range(K):
        basis[k, 0] = UNUSED
    return Work(
        raw, np.empty((K, m, W)), np.empty((K, W)), basis, y, found, np.zeros((K, m)), np.empty(m)
    )


@inlined
def taken(work: Work, k: int) -> Tableau:
    """Return tableau k for the program at hand, whose tau column it is then known by."""
    for r in range(len(work.change)):
        work.change[r] = work.raw[r, 0] - work.tau[k, r]
        work.tau[k, r] = work.raw[r, 0]
    return Tableau(work.raw, work.T[k], work.d[k], work.basis[k], work.y, work.found)


@compiled
def fill(program: Program, force: BoolArray, f: Array, raw: Array) -> float:
    """Write the raw columns of the tau program; return the cost of the scaled tau column.

    Columns: tau, environment, s per finger, one slack per finger (zero under force control).
    """
    env, q, tips, f_max, _ = program
    e, n, s = len(env), len(tips), tips.shape[1]
    raw[:, :] = 0.0
    scale = 1.0
    for i in range(n):
        scale = max(scale, f_max[i])
    for t in range(6):
        raw[t, 0] = q[t] / scale
        for j in range(e):
            raw[t, 1 + j] = env[j, t]
    for i in range(n):
        raw[6 + i, 0] = -(f[i] if force[i] else f_max[i]) / scale
        for k in range(s):
            for t in range(6):
                raw[t, 1 + e + i * s + k] = tips[i, k, t]
            raw[6 + i, 1 + e + i * s + k] = 1.0
        if not force[i]:
            raw[6 + i, 1 + e + n * s + i] = 1.0
    return 1.0 / scale
