"""The largest z of a finger's every placement, over all placements of the others; compiled.

Every decision leaves wrenches in the polar of the environment's cone, each with an inequality
(``certificate``) that holds for all placements and modes at that contact state:

    z <= c + sum_pos T_i(g_i) + sum_force f_com,i / f_max,i F_i(g_i),    T_i = max(0, F_i).

Tables of F refute nearly all partners of a placement by a few additions. Where Problem (5) forbids
to position-control everybody, some finger has one f_com for all inequalities at once: where none
satisfies them all, the set is refuted.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import CLOSE, reach

CUTS: Final = 128
"""Inequalities kept at a time; the one that was of no use for the longest goes."""

BETTER: Final = CLOSE
"""Relatively, by how much z must rise to count: decisions are proven no closer than that."""

NOTHING: Final = 1e-9
"""A bound on z, over force_scale, that is nearer to 0 than this is 0."""

LOST: Final = 1000
"""Sets kept that nobody could prove."""


class Question(NamedTuple):
    """Where the fingers may be, and what acts.

    Attributes:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        table: (n, P, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale.
        L: (76, 6), the directions.
        kind: (n,), equal for fingers that are alike, from 0 as they come.
        firsts: (m,), the first finger of each kind.
        allowed: (n, P), where each fingertip may be.
        centres: (n, P, 3), of the fingertips.
        apart: (n, n), squares of the least distances between them.
        points: (n, P, 3), of contact.
        normals: (n, P, 3), unit, into the object.
        places: (3, P), the points again, coordinate by coordinate.
        faces: (F + 1,), where placements of equal normal begin, and P.
        sides: (n, F, s, 6), forces d and moments e with columns U [d; p x d + e] there.
        U: (6, 6), of norm (7).
        inner: (n,), cosines of half the opening angles of round cones inside the fingers' own.
        blocks: (P,), placements block by block: neighbours on a face, refuted together.
        ends: (B + 1,), where blocks begin in ``blocks``.
    """

    env: Array
    q: Array
    table: Array
    f_max: Array
    L: Array
    kind: IntArray
    firsts: IntArray
    allowed: BoolArray
    centres: Array
    apart: Array
    points: Array
    normals: Array
    places: Array
    faces: IntArray
    sides: Array
    U: Array
    inner: Array
    blocks: IntArray
    ends: IntArray


class PartnerCuts(NamedTuple):
    """The inequalities, their terms for each kind of finger.

    Attributes:
        constants: (K,), c; +inf where there is none.
        held: (m, K, P), T: under position control.
        pressed: (m, K, P), F: under force control, with the largest command.
        held_most: (m, K, B), the largest T of each block's allowed placements.
        pressed_most: (m, K, B), likewise F.
        order: (K,), the cuts: those that refuted something last come first.
    """

    constants: Array
    held: Array
    pressed: Array
    held_most: Array
    pressed_most: Array
    order: IntArray


class Found(NamedTuple):
    """What is known of the placements.

    Attributes:
        z: (n, P), the largest margin of a set with this finger there; -1 for none in equilibrium.
        sets: (n, P, n), a set that has it, -1 for none.
        lost: (LOST, n), sets that nobody could prove.
        counts: (2,), decisions made, and how many are lost.
    """

    z: Array
    sets: IntArray
    lost: IntArray
    counts: IntArray


def no_cuts(ask: Question) -> PartnerCuts:
    """Return room for cuts; there are none yet."""
    kinds = len(ask.firsts)
    single, joint = (kinds, CUTS, ask.allowed.shape[1]), (kinds, CUTS, len(ask.ends) - 1)
    return PartnerCuts(
        np.full(CUTS, np.inf), np.zeros(single), np.zeros(single), np.zeros(joint),
        np.zeros(joint), np.arange(CUTS),
    )  # fmt: skip


def nothing_found(fingers: int, placements: int) -> Found:
    """Return that nothing is known."""
    return Found(
        np.full((fingers, placements), -1.0),
        np.full((fingers, placements, fingers), -1, dtype=np.int64),
        np.zeros((LOST, fingers), dtype=np.int64), np.zeros(2, dtype=np.int64),
    )  # fmt: skip


@compiled
def threshold(best: float) -> float:
    """Return what a margin must reach to be better."""
    return 0.0 if best < 0.0 else max(best * (1.0 + BETTER), NOTHING)


@compiled
def refuting(best: float) -> float:
    """Return below which a bound refutes; one of 0 but for rounding does not."""
    return -NOTHING if best < 0.0 else threshold(best)


@compiled
def to_front(order: IntArray, place: int) -> None:
    """Move the cut at a place to the front."""
    k = order[place]
    for p in range(place, 0, -1):
        order[p] = order[p - 1]
    order[0] = k


@compiled
def _supports(ask: Question, i: int, y: Array, sigma: Array) -> None:
    """Write sigma (P,) of a wrench y (6,), see ``certificate``: on a face affine, edge by edge."""
    x, places = np.zeros(6), ask.places
    for t in range(6):
        for u in range(6):
            x[u] += ask.U[t, u] * y[t]
    sigma[:] = -np.inf
    for phi in range(len(ask.faces) - 1):
        face = slice(ask.faces[phi], ask.faces[phi + 1])
        on, along, across, up = sigma[face], places[0, face], places[1, face], places[2, face]
        for d in ask.sides[i, phi]:
            here = 0.0
            for t in range(6):
                here += d[t] * x[t]
            a = d[1] * x[5] - d[2] * x[4]
            b = d[2] * x[3] - d[0] * x[5]
            c = d[0] * x[4] - d[1] * x[3]
            for g in range(len(on)):  # of slices: a loop that is vectorised
                on[g] = max(on[g], here + a * along[g] + b * across[g] + c * up[g])


@compiled
def keep(ask: Question, y: Array, cuts: PartnerCuts) -> None:
    """Keep the inequality that a wrench y (6,) gives, in the place of the last one."""
    h, constant = reach(ask.L, y), 0.0
    if not h > 0.0:
        return
    for t in range(6):
        constant += ask.q[t] * y[t]
    to_front(cuts.order, len(cuts.order) - 1)
    k = cuts.order[0]
    cuts.constants[k] = constant / h
    for m in range(len(ask.firsts)):
        i, held, pressed = ask.firsts[m], cuts.held[m, k], cuts.pressed[m, k]
        _supports(ask, i, y, pressed)
        for g in range(len(held)):
            pressed[g] *= ask.f_max[i] / h if ask.allowed[i, g] else 0.0
            held[g] = max(pressed[g], 0.0)
        for b in range(len(ask.ends) - 1):
            most = -np.inf
            for j in range(ask.ends[b], ask.ends[b + 1]):
                most = max(most, pressed[ask.blocks[j]])
            cuts.held_most[m, k, b], cuts.pressed_most[m, k, b] = max(most, 0.0), most
