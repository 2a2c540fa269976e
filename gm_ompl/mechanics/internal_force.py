"""Problem (5), compiled: can internal force grow without bound?

It can where some k >= 0, sum k = 1, has W C k = 0: where the hull of the unit columns holds the
origin. Wolfe's algorithm finds the hull's point of least norm: either its norm is below the
convention's 1e-9 (the coefficients are the ray), or the point itself separates strictly.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled

RESIDUAL = 1e-9
"""A residual |W C k| below this at sum k = 1 counts as internal force (convention)."""
_GAP = 1e-12


@compiled
def _affine_minimum(P: Array, chosen: IntArray, count: int, weights: Array) -> None:
    """Write the weights (sum 1) of the least-norm point of the affine hull of chosen points."""
    k = count - 1
    Q = np.empty((k, 6))
    R = np.zeros((k, k))
    rhs = np.empty(k)
    residual = P[chosen[0]].copy()
    for i in range(k):
        for t in range(6):
            Q[i, t] = P[chosen[i + 1], t] - P[chosen[0], t]
        # Twice is enough: orthogonal to working precision even for nearly dependent points.
        for _ in range(2):
            for j in range(i):
                dot = 0.0
                for t in range(6):
                    dot += Q[j, t] * Q[i, t]
                R[j, i] += dot
                for t in range(6):
                    Q[i, t] -= dot * Q[j, t]
        norm = 0.0
        for t in range(6):
            norm += Q[i, t] * Q[i, t]
        norm = max(np.sqrt(norm), 1e-15)
        R[i, i] = norm
        dot = 0.0
        for t in range(6):
            Q[i, t] /= norm
            dot += Q[i, t] * residual[t]
        rhs[i] = -dot
        for t in range(6):
            residual[t] -= dot * Q[i, t]
    total = 0.0
    for i in range(k - 1, -1, -1):
        value = rhs[i]
        for j in range(i + 1, k):
            value -= R[i, j] * weights[j + 1]
        weights[i + 1] = value / R[i, i]
        total += weights[i + 1]
    weights[0] = 1.0 - total


@compiled
def _shrink(chosen: IntArray, count: int, lam: Array, weights: Array) -> int:
    """Move lam towards weights until one coefficient vanishes; drop it; return the new count."""
    theta = 1.0
    for i in range(count):
        if weights[i] <= 1e-14 and lam[i] - weights[i] > 0.0:
            theta = min(theta, lam[i] / (lam[i] - weights[i]))
    drop, least = 0, np.inf
    for i in range(count):
        lam[i] += theta * (weights[i] - lam[i])
        if weights[i] <= 1e-14 and lam[i] < least:
            drop, least = i, lam[i]
    kept = 0
    for i in range(count):
        if i != drop:
            chosen[kept], lam[kept] = chosen[i], lam[i]
            kept += 1
    return kept


@compiled
def least_norm_point(P: Array, K: int, x: Array) -> float:
    """Return the distance of the origin from the hull of P's first K rows (6 wide).

    ``x`` (6,) gets the point of least norm. The distance is an upper bound up to rounding; where
    it is not below RESIDUAL, min_j x . P_j > 0 holds for the caller to verify.
    """
    chosen = np.empty(8, dtype=np.int64)
    lam = np.empty(8)
    weights = np.empty(8)
    chosen[0], lam[0], count = 0, 1.0, 1
    for t in range(6):
        x[t] = P[0, t]
    for _ in range(500):
        square, low, j = 0.0, np.inf, -1
        for t in range(6):
            square += x[t] * x[t]
        norm = np.sqrt(square)
        for i in range(K):
            dot = 0.0
            for t in range(6):
                dot += x[t] * P[i, t]
            if dot < low:
                low, j = dot, i
        if norm < 0.01 * RESIDUAL or low >= square - _GAP * norm or count == 7:
            return norm
        chosen[count], lam[count] = j, 0.0
        count += 1
        while True:
            _affine_minimum(P, chosen, count, weights)
            least = np.inf
            for i in range(count):
                least = min(least, weights[i])
            if least > 1e-14 or count == 1:
                break
            count = _shrink(chosen, count, lam, weights)
        for t in range(6):
            x[t] = 0.0
        for i in range(count):
            lam[i] = weights[i]
            for t in range(6):
                x[t] += lam[i] * P[chosen[i], t]
    return norm


@compiled
def excessive(P: Array, K: int) -> bool:
    """Whether the cone spanned by P's first K rows (unit, 6 wide) holds internal force.

    Marginal cases (no strict separation found either) count as internal force.
    """
    if K == 0:
        return False
    x = np.zeros(6)
    for i in range(K):
        for t in range(6):
            x[t] += P[i, t]
    size = 0.0
    for t in range(6):
        size += x[t] * x[t]
    size = np.sqrt(size)
    for attempt in range(2):
        low = np.inf
        for i in range(K):
            dot = 0.0
            for t in range(6):
                dot += x[t] * P[i, t]
            low = min(low, dot)
        if low > 0.05 * size or (attempt == 1 and low > RESIDUAL * size):
            return False  # x separates: x . column > 0 for all
        if attempt == 1:
            return True
        size = least_norm_point(P, K, x)
        if size < RESIDUAL:
            return True
    return True
