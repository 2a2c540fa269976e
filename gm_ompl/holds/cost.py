"""Costs of arcs: Eqs. (9) and (10)."""

from __future__ import annotations

import math
from collections.abc import Sequence


def stability_factor(z: float, X_stab: float, z_floor: float) -> float:
    """Return 1 + X_stab / max(z, z_floor) of Eq. (9); +inf without equilibrium, where z < 0."""
    return 1.0 + X_stab / max(z, z_floor) if z >= 0.0 else math.inf


def displacement_cost(
    lengths: Sequence[Sequence[float]], z: Sequence[float], X_stab: float, z_floor: float
) -> float:
    """Return Eq. (9), the largest of the fingers' travels, each weighted by stability.

    Args:
        lengths: per finger, per segment j, |dq_finger i,j|.
        z: per segment, the stability margin.
        X_stab: the weight of stability.
        z_floor: what a smaller margin counts as; positive.
    """
    factors = [stability_factor(value, X_stab, z_floor) for value in z]
    if math.inf in factors:
        return math.inf
    return max(
        (
            sum(factor * length for factor, length in zip(factors, travel, strict=True))
            for travel in lengths
        ),
        default=0.0,
    )
