"""What to command where Problem (6) leaves f_com free: at z = 0, where only equilibrium counts.

The commands with equilibrium form a convex set. Taken is the centre of the largest cube in it: no
command can be wrong by so little that equilibrium is lost. The cube comes from cutting planes: a
corner without equilibrium has a wrench that proves it, and with it c + slopes . f_com >= 0 for all
commands that have one. Where equilibrium ties commands together (f_1 = f_2) no cube has a size: the
cube is then of the first fingers whose commands are free of each other, and the others follow.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import separates_environment
from gm_ompl.mechanics.equilibrium import balance
from gm_ompl.mechanics.kelley import force_control
from gm_ompl.mechanics.master import best_command
from gm_ompl.mechanics.modes import STABLE
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.mechanics.stability import FAILED, REACHED, cut

FLAT = 1e-7
"""Half a side up to this (over the larger of force_scale and f_max) is no size."""
MAX_CUTS = 200
"""Cuts on one set of commands before giving up."""

Answer: TypeAlias = tuple[int, float, int, int]
"""What ``modes.decide`` returns."""


@compiled
def largest_cube(
    program: Program, separation: Separation, force: BoolArray, centre: Array
) -> float:
    """Return half a side of the largest cube of commands with equilibrium, -1 where none is found.

    Args:
        program: what is in equilibrium.
        separation: of the environment's columns.
        force: (n,), whose commands these are; the other fingers press as they like.
        centre: output (n,): the cube's centre, f_max where ``force`` is not set.
    """
    hand, nf, f_max = np.flatnonzero(force), int(force.sum()), program.f_max
    h, c, slopes = np.ones(MAX_CUTS), np.empty(MAX_CUTS), np.zeros((MAX_CUTS, nf))
    caps, trial, y, f = f_max[hand], np.zeros(nf), np.zeros(6), np.empty(len(f_max))
    which, weights = np.empty(1 + nf, dtype=np.int64), np.empty(1 + nf)
    for j in range(nf):  # the cube stays between 0 and f_max
        c[2 * j], slopes[2 * j, j] = 0.0, 1.0
        c[2 * j + 1], slopes[2 * j + 1, j] = caps[j], -1.0
    K = 2 * nf
    while True:
        half = max(best_command(h[:K], c[:K], slopes[:K], caps, trial, which, weights), 0.0)
        before = K
        for corner in range(1 << nf if half > 0.0 else 1):
            centre[:] = f_max
            for j in range(nf):
                sign = 1.0 if (corner >> j) & 1 else -1.0
                centre[hand[j]] = min(max(trial[j] + sign * half, 0.0), caps[j])
            end = balance(program, separation, force, centre, y, f)
            if end == REACHED:
                continue
            if end == FAILED or K == MAX_CUTS:
                return -1.0
            c[K] = cut(program, force, y, slopes[K])
            size = np.abs(slopes[K]).sum()
            if not size > 0.0:
                return -1.0
            c[K] /= size
            slopes[K] /= size
            K += 1
        if before == K:
            break
    centre[hand] = trial
    return half


@compiled
def central_command(program: Program, mask: int, f: Array) -> None:
    """Write the central commands over any others with equilibrium, f (n,); see the top.

    ``mask`` holds the position-controlled fingers as bits. Where no cube is found f stays.
    """
    n, flat = len(f), FLAT * max(1.0, float(program.f_max.max()))
    force, chosen = np.empty(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
    y, centre, best = np.zeros(6), np.empty(n), program.f_max.copy()
    force_control(mask, force)
    separation = separates_environment(program.env)
    if largest_cube(program, separation, force, centre) > flat:
        best[:], chosen[:] = centre, force
    elif force.sum() > 1:
        for i in range(n):
            if force[i]:
                chosen[i] = True
                free = largest_cube(program, separation, chosen, centre) > flat
                chosen[i] = free
                if free:
                    best[:] = centre
    if not chosen.any():
        return
    if balance(program, separation, chosen, best, y, centre) != REACHED:
        return
    for i in range(n):
        best[i] = best[i] if chosen[i] else centre[i]
    if balance(program, separation, force, best, y, centre) == REACHED:
        f[:] = best


def settle_commands(program: Program, answer: Answer, f: Array) -> None:
    """Write f_com (n,) anew where an answer of ``modes.decide`` leaves it free.

    That is with some force control at z = 0.
    """
    end, z, _, mask = answer
    if end == STABLE and z == 0.0 and mask != (1 << len(f)) - 1:
        central_command(program, mask, f)
