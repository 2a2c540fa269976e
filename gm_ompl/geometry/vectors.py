"""Sums and products of vectors (3,), compiled."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.compilation import compiled, lean


@lean
def dot(a: Array | tuple[float, ...], b: Array | tuple[float, ...]) -> float:
    """Return a . b for (3,)."""
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


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
