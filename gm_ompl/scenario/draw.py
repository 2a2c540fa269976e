"""Random numbers that are the same on every platform and with every numpy."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import TypeVar

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
