"""Sums and products of vectors (3,), compiled."""

from __future__ import annotations

from typing import TypeAlias

from gm_ompl.arrays import Array
from gm_ompl.compilation import lean

Triple: TypeAlias = tuple[float, float, float]
"""A vector as three numbers: no array is made for it."""


@lean
def dot(a: Array | Triple, b: Array | Triple) -> float:
    """Return a . b for (3,)."""
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


@lean
def between(a: Array | Triple, b: Array | Triple) -> Triple:
    """Return b - a for (3,)."""
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


@lean
def across(a: Array | Triple, b: Array | Triple) -> Triple:
    """Return a x b for (3,)."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
