"""Problem (5), compiled: can internal force grow without bound?

It can where some k >= 0, sum k = 1, has W C k = 0: where the hull of the unit columns holds the
origin. Wolfe's algorithm (Finding the nearest point in a polytope, Mathematical Programming 11,
1976, doi:10.1007/BF01580381) walks towards the hull's point of least norm. Each step offers both
kinds of proof: a wrench that may separate all columns strictly, and coefficients that may cancel.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled

RESIDUAL = 1e-9
"""A residual |W C k| below this at sum k = 1 counts as internal force (convention)."""
OPTIMAL = 1e-13
"""No column lies further than this below the plane through the hull's point of least norm."""
CLEAR = 0.1
"""A wrench that separates by this share of the hull's distance, or more, will do."""
MAX_STEPS = 500

PASSES, FAILS, MARGINAL = 0, 1, 2
"""Verdicts: a wrench separates by more than RESIDUAL; coefficients cancel to less than that;
neither is proven."""


@compiled
def _next_row(Q: Array, R: Array, i: int, x: Array) -> float:
    """Make row i of Q orthonormal to those before, x (6,) to it; return what x had along it.

    Column i of R gets what the row had along those before, and its length then.
    """
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
        dot += Q[i, t] * x[t]
    for t in range(6):
        x[t] -= dot * Q[i, t]
    return dot


@compiled
def _straighten(Q: Array, k: int, x: Array) -> None:
    """Make x (6,) a unit vector orthogonal to Q's first k rows, which are orthonormal."""
    for _ in range(2):
        norm = 0.0
        for t in range(6):
            norm += x[t] * x[t]
        norm = max(np.sqrt(norm), 1e-300)
        for t in range(6):
            x[t] /= norm
        for j in range(k):
            dot = 0.0
            for t in range(6):
                dot += Q[j, t] * x[t]
            for t in range(6):
                x[t] -= dot * Q[j, t]


@compiled
def _affine_minimum(
    P: Array, chosen: IntArray, count: int, weights: Array, x: Array, Q: Array, R: Array
) -> float:
    """Write the weights (sum 1) of the least-norm point of the affine hull of chosen points.

    ``x`` (6,) gets the unit normal from the origin to the hull; its distance is returned. The
    normal is made orthogonal anew after it is scaled: it is right to rounding even where the
    distance is tiny. ``Q`` and ``R`` (6, 6) are room.
    """
    k = count - 1
    for t in range(6):
        x[t] = P[chosen[0], t]
    for i in range(k):
        for t in range(6):
            Q[i, t] = P[chosen[i + 1], t] - P[chosen[0], t]
        for j in range(i):
            R[j, i] = 0.0
        weights[i + 1] = -_next_row(Q, R, i, x)
    total = 0.0
    for i in range(k - 1, -1, -1):
        value = weights[i + 1]
        for j in range(i + 1, k):
            value -= R[i, j] * weights[j + 1]
        weights[i + 1] = value / R[i, i]
        total += weights[i + 1]
    weights[0] = 1.0 - total
    _straighten(Q, k, x)
    distance = 0.0
    for t in range(6):
        distance += x[t] * P[chosen[0], t]
    return distance


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
def _lowest(P: Array, K: int, x: Array) -> tuple[float, int]:
    """Return the least x . P_j of P's first K rows, and whose it is."""
    low, which = np.inf, -1
    for i in range(K):
        dot = 0.0
        for t in range(6):
            dot += x[t] * P[i, t]
        if dot < low:
            low, which = dot, i
    return low, which


@compiled
def _cancels(P: Array, chosen: IntArray, count: int, lam: Array) -> bool:
    """Whether the coefficients (sum 1) leave less than RESIDUAL of the columns."""
    square = 0.0
    for t in range(6):
        rest = 0.0
        for i in range(count):
            rest += lam[i] * P[chosen[i], t]
        square += rest * rest
    return square < RESIDUAL * RESIDUAL


@compiled
def separate(P: Array, K: int, x: Array) -> tuple[int, float]:
    """Judge whether the cone spanned by P's first K rows (unit, 6 wide) holds internal force.

    Args:
        P: (at least K, 6), unit columns as rows.
        K: their number.
        x: output (6,), where the cone passes: a wrench of norm at most 1 with
            x . P_j >= margin > RESIDUAL for all j.

    Returns:
        PASSES, FAILS (coefficients were found that cancel), or MARGINAL; and the margin.
    """
    for t in range(6):
        x[t] = 0.0
    if K == 0:
        return PASSES, 1.0
    for i in range(K):
        for t in range(6):
            x[t] += P[i, t]
    square = 0.0
    for t in range(6):
        square += x[t] * x[t]
    size = max(np.sqrt(square), 1e-300)
    for t in range(6):
        x[t] /= size
    low, j = _lowest(P, K, x)
    if low > 0.05:  # the mean separates; most contact states are this clear
        return PASSES, low
    return _walk(P, K, j, x)


@compiled
def _walk(P: Array, K: int, first: int, x: Array) -> tuple[int, float]:
    """Wolfe's algorithm from column ``first``; arguments and answers as for ``separate``."""
    chosen, lam, weights = np.empty(8, dtype=np.int64), np.empty(8), np.empty(8)
    Q, R = np.empty((6, 6)), np.empty((6, 6))
    chosen[0], lam[0], count = first, 1.0, 1
    distance = _affine_minimum(P, chosen, 1, weights, x, Q, R)
    for _ in range(MAX_STEPS):
        low, j = _lowest(P, K, x)
        nearest = low >= distance - OPTIMAL or count == 7
        if low > RESIDUAL and (nearest or low > CLEAR * distance):
            return PASSES, low
        if nearest:
            break
        chosen[count], lam[count] = j, 0.0
        count += 1
        while True:
            distance = _affine_minimum(P, chosen, count, weights, x, Q, R)
            least = np.inf
            for i in range(count):
                least = min(least, weights[i])
            if least > 1e-14 or count == 1:
                break
            count = _shrink(chosen, count, lam, weights)
        for i in range(count):
            lam[i] = weights[i]
        if _cancels(P, chosen, count, lam):
            return FAILS, 0.0
    return MARGINAL, 0.0
