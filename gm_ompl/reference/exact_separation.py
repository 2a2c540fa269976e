"""Problem (5) in exact arithmetic: how far the hull of the columns is from the origin.

The last word where floating point finds neither a wrench that separates nor forces that cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

Vector = Sequence[Fraction]


def nearest(points: Sequence[Vector]) -> Vector:
    """Return the point of the hull of ``points`` (at least one) that is nearest to the origin.

    Wolfe's algorithm (Mathematical Programming 11, 1976, doi:10.1007/BF01580381).
    """
    chosen = [min(range(len(points)), key=lambda j: _dot(points[j], points[j]))]
    weights = [Fraction(1)]
    while True:
        x = _combined(points, chosen, weights)
        j = min(range(len(points)), key=lambda j: _dot(x, points[j]))
        if _dot(x, points[j]) >= _dot(x, x):
            return x
        chosen.append(j)
        weights.append(Fraction(0))
        while True:
            best = _affine([points[i] for i in chosen])
            if min(best) >= 0:
                weights = best
                break
            theta = min(w / (w - b) for w, b in zip(weights, best, strict=True) if b < 0)
            weights = [w + theta * (b - w) for w, b in zip(weights, best, strict=True)]
            kept = [i for i, w in enumerate(weights) if w > 0]
            chosen, weights = [chosen[i] for i in kept], [weights[i] for i in kept]


def _affine(points: Sequence[Vector]) -> list[Fraction]:
    """Return the weights (sum 1) of the least-norm point of the points' affine hull."""
    k = len(points)
    rows = [[_dot(a, b) for b in points] + [Fraction(1), Fraction(0)] for a in points]
    rows.append([Fraction(1)] * k + [Fraction(0), Fraction(1)])
    for c in range(k + 1):
        r = next(r for r in range(c, k + 1) if rows[r][c])
        rows[c], rows[r] = rows[r], rows[c]
        rows[c] = [value / rows[c][c] for value in rows[c]]
        for i in range(k + 1):
            if i != c and rows[i][c]:
                factor = rows[i][c]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[c], strict=True)]
    return [row[-1] for row in rows[:k]]


def _combined(points: Sequence[Vector], chosen: Sequence[int], weights: Vector) -> Vector:
    return [
        sum((w * points[j][t] for j, w in zip(chosen, weights, strict=True)), Fraction(0))
        for t in range(6)
    ]


def _dot(a: Vector, b: Vector) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))
