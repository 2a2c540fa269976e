"""Sec. 3.4's cases, compiled: what differs between them, and one pass over one of them.

A case is a world at a corner of what is not known exactly: a choice of the environment's columns
(sliding contacts at their lowest and highest friction), of the load (mass, centre of mass, tilt),
of where each fingertip touches, and of each command's error. Their product is the family of cases;
a case's number counts loads fastest, so that neighbours differ in one column of the tableau.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import support
from gm_ompl.mechanics.program import Program
from gm_ompl.mechanics.sides import refactor
from gm_ompl.mechanics.simplex import Target
from gm_ompl.mechanics.stability import run_pass
from gm_ompl.mechanics.tau import UNUSED, Work, fill, new_tableau, new_work, taken
from gm_ompl.mechanics.trials import FRESH


class Cases(NamedTuple):
    """The family of cases of one decision, forces over force_scale.

    Attributes:
        envs: (V, e, 6), the environment's columns, static contacts at their lowest friction.
        loads: (D, 6).
        tips: (S, n, s, 6), the fingers' columns at their lowest friction.
        press: (E, n), what a command of 1 presses with; E is 2^n, bit i is finger i's error.
        f_max: (n,).
        L: (76, 6), the directions.
        around: (e', 6), the environment's columns of all worlds, with which (5) is asked.
        squeeze: (n, s', 6), the fingers', likewise.
    """

    envs: Array
    loads: Array
    tips: Array
    press: Array
    f_max: Array
    L: Array
    around: Array
    squeeze: Array


class Pad(NamedTuple):
    """Tableaus of the cases that share columns, kept from pass to pass.

    Attributes:
        work: R tableaus: a row for each choice of the environment's columns.
        tips: (R,), which fingertip columns the tableau has.
        passes: (R,), how often it was used.
        last: (rows,), the case in which the last trial failed.
    """

    work: Work
    tips: IntArray
    passes: IntArray
    last: IntArray


@compiled
def new_pad(rows: int, cases: Cases) -> Pad:
    """Return unused tableaus, ``rows`` for each choice of the environment's columns."""
    V, e, _ = cases.envs.shape
    _, n, s, _ = cases.tips.shape
    R = rows * V
    return Pad(
        new_work(R, new_tableau(n, e, s)), np.full(R, -1, dtype=np.int64),
        np.zeros(R, dtype=np.int64), np.zeros(rows, dtype=np.int64),
    )  # fmt: skip


@compiled
def count_of(cases: Cases) -> int:
    """Return the number of cases."""
    return len(cases.envs) * len(cases.loads) * len(cases.tips) * len(cases.press)


@compiled
def parts_of(cases: Cases, c: int) -> tuple[int, int, int, int]:
    """Return a case's environment, load, fingertip columns and errors, by number."""
    load, c = c % len(cases.loads), c // len(cases.loads)
    env, c = c % len(cases.envs), c // len(cases.envs)
    return env, load, c % len(cases.tips), c // len(cases.tips)


@compiled
def matters(cases: Cases, c: int, mask: int) -> bool:
    """Whether a case differs from those before it where ``mask`` is position-controlled."""
    return (c // (len(cases.loads) * len(cases.envs) * len(cases.tips))) & mask == 0


@compiled
def program_of(cases: Cases, c: int) -> Program:
    """Return the data of case ``c``."""
    env, load, tip, _ = parts_of(cases, c)
    return Program(cases.envs[env], cases.loads[load], cases.tips[tip], cases.f_max, cases.L)


@compiled
def try_case(
    cases: Cases, c: int, row: int, force: BoolArray, commands: Array, target: Target, pad: Pad
) -> tuple[int, int, float, float]:
    """Search the directions in case ``c`` for given commands (n,), as ``run_pass`` does.

    Args:
        cases: the family.
        c: the case.
        row: which of the pad's rows to use.
        force: (n,), who is force-controlled.
        commands: (n,), where force-controlled.
        target: where to stop.
        pad: output: the tableau, duals, and what resists each direction.
    """
    env, _, tip, error = parts_of(cases, c)
    k, f_max, work = row * len(cases.envs) + env, cases.f_max, pad.work
    pressed = f_max.copy()
    for i in range(len(f_max)):
        if force[i]:
            pressed[i] = min(commands[i] * cases.press[error, i], f_max[i])
    cost = fill(program_of(cases, c), force, pressed, work.raw)
    tableau = taken(work, k)
    warm = tableau.basis[0] != UNUSED and pad.tips[k] == tip
    if warm and pad.passes[k] % FRESH == 0:
        refactor(work.raw, cost, cases.L, tableau.T, tableau.d, tableau.basis)
        work.change[:] = 0.0
    pad.tips[k] = tip
    pad.passes[k] += 1
    return run_pass(tableau, cost, cases.L, work.change, warm, target)


@compiled
def case_cut(cases: Cases, c: int, force: BoolArray, y: Array, slopes: Array) -> float:
    """Return the constant of the cut h z <= c + slopes . f_com that y gives in case ``c``.

    ``slopes`` gets one entry per force-controlled finger.
    """
    _, load, tip, error = parts_of(cases, c)
    constant, j = 0.0, 0
    for t in range(6):
        constant += cases.loads[load, t] * y[t]
    for i in range(len(force)):
        sigma = support(cases.tips[tip], i, y)
        if force[i]:
            slopes[j] = sigma * cases.press[error, i]
            j += 1
        else:
            constant += cases.f_max[i] * max(0.0, sigma)
    return constant


@compiled
def look_at(
    cases: Cases, like: int, mask: int, force: BoolArray, y: Array, trial: Array, scores: Array
) -> tuple[int, float]:
    """Bound h z at a trial f_com in every case by one wrench y.

    Args:
        cases: the family.
        like: a case whose environment's cone has y in its polar.
        mask: who is position-controlled, as bits.
        force: (n,), the others.
        y: (6,).
        trial: (number of force-controlled fingers,).
        scores: (cases,), lowered to the bounds: a guess only where the cone is another.

    Returns:
        The case with the least bound among those with the same cone, where it is proven, and that.
    """
    env, _, _, _ = parts_of(cases, like)
    worst, least, slopes = like, np.inf, np.empty(len(force))
    for c in range(count_of(cases)):
        if not matters(cases, c, mask):
            continue
        bound = case_cut(cases, c, force, y, slopes)
        for j in range(len(trial)):
            bound += slopes[j] * trial[j]
        scores[c] = min(scores[c], bound)
        if bound < least and parts_of(cases, c)[0] == env:
            worst, least = c, bound
    return worst, least


@compiled
def at_shifts(tables: Array, hand: IntArray, rows: IntArray) -> Array:
    """Return a hand's columns (S, k, s, 6) at its placements, for all choices of shifts.

    ``tables`` (Q, N, P, s, 6) holds all fingers' columns at all placements, per corner of a shift;
    S is Q to the power of k.
    """
    Q, k, s = len(tables), len(hand), tables.shape[3]
    S = Q**k
    tips = np.empty((S, k, s, 6))
    for code in range(S):
        left = code
        for i in range(k):
            tips[code, i] = tables[left % Q, hand[i], rows[i]]
            left //= Q
    return tips


@compiled
def pressures(command: float, n: int) -> Array:
    """Return what a command of 1 presses with for all signs of the error, (E, n)."""
    if command <= 0.0:
        return np.ones((1, n))
    press = np.empty((1 << n, n))
    for code in range(1 << n):
        for i in range(n):
            press[code, i] = 1.0 + command if (code >> i) & 1 else 1.0 - command
    return press
