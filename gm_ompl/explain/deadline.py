"""The time that an explanation may take, shared out among its parts."""

from __future__ import annotations

from typing import Final, final

from gm_ompl import clock

SECONDS: Final = 30.0
"""What an explanation may take, its searches included."""


@final
class Deadline:
    """A point in time; the clock is the budgets', which stands still while code is compiled.

    Args:
        seconds: from now.
    """

    def __init__(self, seconds: float) -> None:
        self._end = clock.now() + seconds

    def left(self) -> float:
        """Return the time left [s], at least 0."""
        return max(0.0, self._end - clock.now())

    def passed(self) -> bool:
        """Whether no time is left."""
        return self.left() <= 0.0

    def part(self, share: float, most: float) -> Deadline:
        """Return a deadline after ``share`` of the time left, in at most ``most`` seconds."""
        return Deadline(min(most, share * self.left()))
