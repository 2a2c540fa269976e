"""What happens in a callback stays in Python: errors are kept, not thrown through OMPL."""

from __future__ import annotations

from collections.abc import Callable
from typing import final


@final
class Guard:
    """Ends a run from inside a callback.

    An exception thrown through OMPL's C++ kills the process in some of its planners and tools.
    Callbacks therefore hand it in here and return at once, like every callback after it, until
    the planner asks whether to stop.

    Attributes:
        error: the first exception met, or None.
    """

    def __init__(self) -> None:
        self.error: BaseException | None = None
        self._stop: Callable[[], bool] | None = None

    def watch(self, stop: Callable[[], bool] | None) -> None:
        """Forget the last run; callbacks of the next one give up where ``stop`` says so."""
        self.error, self._stop = None, stop

    def keep(self, error: BaseException) -> None:
        """Keep an exception met in a callback; only the first counts."""
        if self.error is None:
            self.error = error

    def closed(self) -> bool:
        """Whether the run is over: callbacks then answer at once, and negatively."""
        return self.error is not None or (self._stop is not None and self._stop())

    def finished(self, stop: Callable[[], bool]) -> bool:
        """Whether the planner must stop, by ``stop`` or an error; safe to be called by OMPL."""
        try:
            return self.error is not None or bool(stop())
        except BaseException as error:
            self.keep(error)
            return True

    def settle(self) -> None:
        """Raise the exception that ended the run, if one did."""
        error, self.error = self.error, None
        self._stop = None
        if error is not None:
            raise error
