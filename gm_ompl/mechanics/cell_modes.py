"""Bounds on z over products of cells where not all fingers can be position-controlled, compiled.

Two fingers squeeze the object where the line from one to the other lies in both friction cones:
Problem (5) is unbounded with both under position control, whatever else touches. On a face the cone
is the same everywhere and p2 - p1 is affine in both points, so what holds at all corners of two
cells holds throughout. The best modes are then among the largest sets without such a pair; z of
each is bounded as by ``cell_margin``, a finger's commanded force shared by its cell's corners.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import NO_RECORD
from gm_ompl.mechanics.commands import best_commands
from gm_ompl.mechanics.kelley import mode_sets
from gm_ompl.mechanics.modes import preference
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.mechanics.stability import BELOW, REACHED
from gm_ompl.mechanics.tau import new_tableau

INSIDE: Final = 1e-6
"""Sine of the least angle between a line and a cone's sides for it to count as inside."""


@compiled
def aims(edges: Array, d: Array) -> bool:
    """Whether a direction (3,) lies in the cone of edges (s, 3), given in order around it."""
    s, size = len(edges), np.sqrt((d * d).sum())
    inside = size > 0.0
    middle = np.zeros(3)
    for k in range(s):
        for t in range(3):
            middle[t] += edges[k, t]
    for k in range(s):
        e, g, side = edges[k], edges[(k + 1) % s], np.empty(3)
        side[0] = e[1] * g[2] - e[2] * g[1]
        side[1] = e[2] * g[0] - e[0] * g[2]
        side[2] = e[0] * g[1] - e[1] * g[0]
        across, along, norm = 0.0, 0.0, 0.0
        for t in range(3):
            across += side[t] * d[t]
            along += side[t] * middle[t]
            norm += side[t] * side[t]
        sense = 1.0 if along > 0.0 else -1.0
        inside = inside and sense * across > INSIDE * np.sqrt(norm) * size
    return inside


@compiled
def squeezed(edges: Array, corners: Array) -> int:
    """Return pairs of fingers that squeeze the object everywhere in their cells, as a bit mask.

    Args:
        edges: (n, s, 3), of each finger's friction cone.
        corners: (n, 4, 3), of its cell.

    Returns:
        Bit i n + j is set for a pair i < j.
    """
    n, pairs = len(edges), 0
    for i in range(n):
        for j in range(i + 1, n):
            both = True
            for a in range(4):
                for b in range(4):
                    if both:
                        d = corners[j, b] - corners[i, a]
                        both = aims(edges[i], d) and aims(edges[j], -d)
            if both:
                pairs |= 1 << (i * n + j)
    return pairs


@compiled
def largest_sets(n: int, pairs: int) -> IntArray:
    """Return the largest sets of fingers that hold no such pair, as bit masks."""
    found, count = np.empty(1 << n, dtype=np.int64), 0
    for mask in preference(n, -1):
        kept = True
        for i in range(n):
            for j in range(i + 1, n):
                both = (mask >> i) & 1 and (mask >> j) & 1
                if both and (pairs >> (i * n + j)) & 1:
                    kept = False
        for k in range(count):
            kept = kept and (mask & found[k]) != mask
        if kept:
            found[count] = mask
            count += 1
    return found[:count]


@compiled
def mode_margin(
    program: Program, separation: Separation, below: float, masks: IntArray, first: Array
) -> float:
    """Return an upper bound on z for all points of a product of cells under some sets of modes.

    Args:
        program: what acts; ``tips`` (k, c, 6) are each finger's columns at all corners of its cell.
        separation: of the environment's columns.
        below: where z is proven smaller than this, any such bound will do.
        masks: (sets,), position-controlled fingers as bits; none holds all fingers.
        first: (6,), a wrench whose cut may help, or zero.
    """
    n, s = program.tips.shape[0], program.tips.shape[1]
    seed, sets = new_tableau(n, len(program.env), s), mode_sets(masks, n)
    end, bound = best_commands(program, separation, below, sets, first, seed, NO_RECORD)
    return max(bound, 0.0) if end in (BELOW, REACHED) else np.inf
