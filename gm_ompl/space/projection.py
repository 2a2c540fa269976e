"""The projection that KPIECE1 covers: the object's coordinates."""

from __future__ import annotations

from typing import Any, final

from ompl import base as ob

from gm_ompl.sampling.lines import extents
from gm_ompl.space.convert import Codec
from gm_ompl.space.guard import Guard


@final
class ObjectProjection(ob.ProjectionEvaluator):
    """From a state to the object's coordinates, each over its range.

    The size of cells is left to OMPL, which takes a twentieth of what it sees.
    """

    def __init__(self, space: Any, codec: Codec, guard: Guard) -> None:
        super().__init__(space)  # not kept: the space owns the projection
        self._codec, self._guard = codec, guard
        self._extents = extents(codec.problem)

    def getDimension(self) -> int:
        """Return the number of coordinates."""
        return len(self._extents)

    def project(self, state: Any, projection: Any) -> None:
        """Write the projection of ``state`` into the array ``projection``."""
        try:
            q = self._codec.read(state).q
            projection[:] = [value / extent for value, extent in zip(q, self._extents, strict=True)]
        except BaseException as error:
            self._guard.keep(error)
