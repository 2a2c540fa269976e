"""Is a state valid, may a motion be executed from start to end: OMPL's two questions."""

from __future__ import annotations

from typing import Any, final

from ompl import base as ob

from gm_ompl.space.convert import Codec
from gm_ompl.space.guard import Guard
from gm_ompl.space.motions import Motions


@final
class NodeValidity(ob.StateValidityChecker):
    """Whether a state is a valid node: bounds, and nothing penetrates (Sec. 4.2)."""

    def __init__(self, si: Any, codec: Codec, motions: Motions, guard: Guard) -> None:
        super().__init__(si)
        self._codec, self._motions, self._guard = codec, motions, guard
        self._space = si.getStateSpace()

    def isValid(self, state: Any) -> bool:
        """Return whether ``state`` is valid."""
        guard = self._guard
        try:
            if guard.closed() or not self._space.satisfiesBounds(state):
                return False
            return bool(self._motions.state_valid(self._codec.read(state)))
        except BaseException as error:
            guard.keep(error)
            return False


@final
class DirectedMotions(ob.MotionValidator):
    """Whether the motion from one state to another can be executed in that direction.

    The motion is expanded into regrasps and one displacement, each judged as in Sec. 4.2; OMPL's
    interpolation is never asked. What can be pushed cannot always be pulled: the answer for the
    opposite direction is another one.
    """

    def __init__(self, si: Any, codec: Codec, motions: Motions, guard: Guard) -> None:
        super().__init__(si)  # si is not kept: OMPL could never free the pair
        self._codec, self._motions, self._guard = codec, motions, guard

    def checkMotion(self, origin: Any, target: Any) -> bool:
        """Return whether the motion from ``origin`` to ``target`` is feasible."""
        guard = self._guard
        try:
            if guard.closed():
                return False
            read = self._codec.read
            return self._motions.expand(read(origin), read(target)) is not None
        except BaseException as error:
            guard.keep(error)
            return False
