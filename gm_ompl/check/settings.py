"""Tolerances of the check, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerances:
    """How far a claim may be from what holds.

    Attributes:
        coordinate: of object coordinates, relative to the coordinate's range; far above the
            rounding of s = k / n, far below any lattice step.
        length: of positions and contact points, relative to D.
        direction: of unit vectors and quaternions, absolute.
        count: of lattice steps spanned, before rounding up; a planner may allow less.
        rounding: of the same; no planner counts a step for so little.
        z: of margins, relative to max(z, z_floor M g): what two LP solvers agree to.
        z_floor: see ``z``.
        z_min: by how much z may miss z_min, relative.
        force: of 0 <= f_com <= f_max, relative to f_max.
        cost: of costs, relative; sums of products of square roots agree to far less.
        optimal: of a proven optimum, relative.
    """

    coordinate: float = 1e-9
    length: float = 1e-9
    direction: float = 1e-9
    count: float = 1e-6
    rounding: float = 1e-8
    z: float = 1e-6
    z_floor: float = 1e-3
    z_min: float = 1e-6
    force: float = 1e-9
    cost: float = 1e-7
    optimal: float = 1e-6
