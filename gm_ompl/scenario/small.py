"""Numbers drawn alike everywhere, and the family ``random/small`` for the plain search."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import Any, TypeAlias, TypeVar

from numpy.random import PCG64, SeedSequence

T = TypeVar("T")


def rounded(value: float, digits: int = 3) -> float:
    """Return ``value`` rounded to ``digits`` significant decimal digits."""
    return float(f"{value:.{digits}g}")


class Draw:
    """Draws from PCG64's raw bits.

    numpy promises the same raw bits for ever, but not the same numbers from ``Generator``; and
    rounding to a few decimal digits takes away what libraries of different platforms make of
    the last bit.
    """

    def __init__(self, family: str, seed: int) -> None:
        self._bits = PCG64(SeedSequence([zlib.crc32(family.encode()), seed]))

    def fraction(self) -> float:
        """Return a number in [0, 1)."""
        return (int(self._bits.random_raw()) >> 11) * 2.0**-53

    def between(self, low: float, high: float, digits: int = 3) -> float:
        """Return a number from low to high, rounded to significant digits."""
        return rounded(low + (high - low) * self.fraction(), digits)

    def whole(self, low: int, high: int) -> int:
        """Return a whole number from low to high, both included."""
        return low + int(self.fraction() * (high - low + 1))

    def pick(self, items: Sequence[T]) -> T:
        """Return one of ``items``."""
        return items[self.whole(0, len(items) - 1)]

    def some(self, items: Sequence[T], count: int) -> list[T]:
        """Return ``count`` different ones of ``items``, in their order."""
        left = list(range(len(items)))
        chosen = sorted(left.pop(self.whole(0, len(left) - 1)) for _ in range(count))
        return [items[i] for i in chosen]

    def chance(self, probability: float) -> bool:
        """Return True with the given probability."""
        return self.fraction() < probability


Tree: TypeAlias = dict[str, Any]

GRAVITY = 9.8

FACES: dict[int, tuple[tuple[list[int], int], ...]] = {
    1: (([2, 2], 3), ([3, 3], 1), ([2, 2], 2), ([3, 1], 3)),
    2: (([2, 2], 1), ([1, 2], 3), ([1, 2], 2), ([1, 1], 5), ([2, 2], 2)),
    3: (([2, 2], 1), ([1, 2], 2), ([1, 1], 4)),
}
"""Per number of fingers: grid and number of faces, so that there are at most 28 hands."""


def small(draw: Draw) -> Tree:
    """Return a slide, a tumble or both, with few placements and few segments.

    One to three fingers, equal or not; walls; sometimes given placements at the start or goal;
    sometimes too weak or too slippery to move at all.
    """
    size = [draw.between(2, 10, 2) for _ in range(3)]
    mass = rounded(10 ** draw.between(-1, 1), 2)
    pieces = draw.pick((["slide"], ["slide"], ["tumble"], ["tumble"], ["slide", "tumble"]))
    path: list[Tree] = [
        {"slide": {"by": [rounded(draw.between(0.3, 2) * size[0], 2), 0, 0]}}
        if piece == "slide"
        else {"tumble": {"towards": "+x", "angle": f"{draw.pick((30, 60, 90))} deg"}}
        for piece in pieces
    ]
    few = {1: (3, 6), 2: (2, 3)}[len(pieces)]
    fingers = _hand(draw, size, mass)
    return {
        "description": "A small problem for the plain search.",
        "object": {"shape": {"box": size}, "mass": mass},
        "friction": {
            "environment": draw.between(0.1, 1.0, 2),
            "finger": _unequal(draw, draw.between(0.3, 1.2, 2), fingers["count"]),
        },
        "gravity": GRAVITY,
        "fingers": fingers,
        "environment": {"floor": True, "obstacles": _obstacles(draw, size)},
        "motion": {"start": {"position": [0, 0, size[2] / 2]}, "path": path},
        "lattice": {"segments": [draw.whole(*few) for _ in pieces]},
        "mechanics": {
            "cone_edges": draw.pick((4, 6)),
            "directions": 76,
            "z_min": rounded(draw.between(0.002, 0.04) * mass * GRAVITY, 2),
        },
        "cost": {
            # Cheap regrasps now and then: the heuristic must hold for every X_regr.
            "regrasp": rounded(draw.pick((0.02, 1.0, 5.0)) * max(size), 2),
            "stability": rounded(0.001 * mass * GRAVITY, 2),
            "samples_per_arc": draw.pick((1, 1, 1, 2)),
        },
    }


def _unequal(draw: Draw, value: float, count: int) -> float | list[float]:
    """Return ``value``, or one value per finger around it."""
    if not draw.chance(0.2):
        return value
    return [rounded(value * draw.between(0.6, 1.4), 2) for _ in range(count)]


def _hand(draw: Draw, size: list[float], mass: float) -> Tree:
    count = draw.pick((1, 2, 2, 2, 3))
    grid, number = draw.pick(FACES[count])
    faces = draw.some(("-x", "+y", "-y", "+z", "+x"), number)
    limit = rounded(draw.pick((0.1, 0.5, 1.0, 2.0, 4.0)) * mass * GRAVITY, 2)
    hand: Tree = {
        "count": count,
        "radius": rounded(draw.between(0.05, 0.2) * min(size), 2),
        "max_normal_force": _unequal(draw, limit, count),
        "placements": {"grid": grid, "faces": faces},
    }
    for key in ("start", "goal"):
        if draw.chance(0.15):
            cells = [
                {"face": face, "cell": [i, j]}
                for face in faces
                for i in range(grid[0])
                for j in range(grid[1])
            ]
            given = draw.some(cells, count)
            hand[key] = [place if draw.chance(0.6) else "any" for place in given]
    return hand


def _obstacles(draw: Draw, size: list[float]) -> Tree:
    """Return at most two walls, out of the object's way, at various gaps and heights."""
    far = 20.0 * max(size)
    obstacles: Tree = {}
    if draw.chance(0.4):
        edge = rounded(size[0] / 2 + draw.between(0.01, 0.6) * min(size), 4)
        top = rounded(draw.pick((0.4, 5.0)) * size[2], 3)
        obstacles["behind"] = {"box": {"min": [-far, -far, 0.0], "max": [-edge, far, top]}}
    if draw.chance(0.3):
        edge = rounded(size[1] / 2 + draw.between(0.01, 0.6) * min(size), 4)
        top = rounded(draw.pick((0.4, 5.0)) * size[2], 3)
        obstacles["beside"] = {"box": {"min": [-far, edge, 0.0], "max": [far, far, top]}}
    return obstacles
