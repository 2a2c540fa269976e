"""Sums and products of vectors (3,), compiled."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.compilation import compiled, lean

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


@compiled
def product(a: Array, b: Array) -> Array:
    """Return a x b for (3,)."""
    c = np.empty(3)
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]
    return c


@compiled
def minus(a: Array, b: Array) -> Array:
    """Return a - b for (3,)."""
    c = np.empty(3)
    for k in range(3):
        c[k] = a[k] - b[k]
    return c


@compiled
def plus(a: Array, b: Array) -> Array:
    """Return a + b for (3,)."""
    c = np.empty(3)
    for k in range(3):
        c[k] = a[k] + b[k]
    return c
