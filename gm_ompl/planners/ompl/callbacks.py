"""What OMPL asks back: what is valid, what may be executed and what it costs, what is a goal.

Every answer goes through a ``Guard``: nothing is thrown through OMPL.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, TypeVar, final

from ompl import base as ob

from gm_ompl.planners.ompl.convert import Codec
from gm_ompl.planners.ompl.draws import Draws
from gm_ompl.planners.ompl.motions import HybridMotions
from gm_ompl.sampling.motions import UNPLACED


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


Answer = TypeVar("Answer")


def answered(
    otherwise: Answer, *, when_closed: bool = True
) -> Callable[[Callable[..., Answer]], Callable[..., Answer]]:
    """Let a method answer ``otherwise`` where it fails; its object keeps ``_guard``.

    Args:
        otherwise: the answer.
        when_closed: whether it is the answer, too, once the run is over.
    """

    def decorate(method: Callable[..., Answer]) -> Callable[..., Answer]:
        @functools.wraps(method)
        def ask(self: Any, *states: Any) -> Answer:
            guard: Guard = self._guard
            try:
                return otherwise if when_closed and guard.closed() else method(self, *states)
            except BaseException as error:
                guard.keep(error)
                return otherwise

        return ask

    return decorate


@final
class NodeValidity(ob.StateValidityChecker):
    """Whether a state is a valid node: bounds, and nothing penetrates (Sec. 4.2)."""

    def __init__(self, si: Any, codec: Codec, motions: HybridMotions, guard: Guard) -> None:
        super().__init__(si)
        self._codec, self._motions, self._guard = codec, motions, guard
        self._space = si.getStateSpace()

    @answered(False)
    def isValid(self, state: Any) -> bool:
        """Return whether ``state`` is valid."""
        meaning = self._codec.meant(state)
        within = self._space.satisfiesBounds(state)
        return bool(within and self._motions.state_valid(meaning))


@final
class DirectedMotions(ob.MotionValidator):
    """Whether the motion from one state to another can be executed in that direction.

    The motion is expanded into displacements and regrasps, each judged as in Sec. 4.2; OMPL's
    interpolation is never asked. What can be pushed cannot always be pulled: the answer for the
    opposite direction is another one.
    """

    def __init__(self, si: Any, codec: Codec, motions: HybridMotions, guard: Guard) -> None:
        super().__init__(si)  # si is not kept: OMPL could never free the pair
        self._codec, self._motions, self._guard = codec, motions, guard

    @answered(False)
    def checkMotion(self, origin: Any, target: Any) -> bool:
        """Return whether the motion from ``origin`` to ``target`` is feasible."""
        begin = self._codec.meant(origin)
        return self._motions.check(begin, self._codec.meant(target, begin))


@final
class PlanCost(ob.OptimizationObjective):
    """Eq. (9) for displacements plus Eq. (10) for regrasps; not symmetric."""

    def __init__(self, si: Any, codec: Codec, motions: HybridMotions, guard: Guard) -> None:
        super().__init__(si)
        self._codec, self._motions, self._guard = codec, motions, guard

    def isSymmetric(self) -> bool:
        """Return False: motions have a direction."""
        return False

    def stateCost(self, state: Any) -> Any:  # noqa: ARG002 (OMPL's signature)
        """Return 0: only motions cost."""
        return ob.Cost(0.0)

    def motionCost(self, origin: Any, target: Any) -> Any:
        """Return the cost of the motion; +inf where it is infeasible.

        From a state to itself it is 0 whatever happens, also when the run is over: FMT takes this
        cost for a distance, and its nearest neighbours keep a state twice, and free it twice,
        where a state is not the nearest to itself.
        """
        return ob.Cost(self._cost(origin, target))

    @answered(math.inf, when_closed=False)
    def _cost(self, origin: Any, target: Any) -> float:
        a, b = self._codec.read(origin), self._codec.read(target)
        if a == b:
            return 0.0
        return math.inf if self._guard.closed() else self._motions.compared(a, b)

    def motionCostHeuristic(self, origin: Any, target: Any) -> Any:
        """Return a lower bound on the cost of every way from ``origin`` to ``target``."""
        return ob.Cost(self._bound(origin, target))

    @answered(0.0)
    def _bound(self, origin: Any, target: Any) -> float:
        a, b = self._codec.said(origin), self._codec.said(target)
        return 0.0 if a is None or b is None else self._motions.model.least_cost(a, b)


@final
class GoalRegion(ob.GoalSampleableRegion):
    """All valid placements with the object in the goal.

    Args:
        si: OMPL's space information.
        codec: the state space.
        draws: where states come from.
        guard: keeps errors.
        count: how many different goal states to draw at most.
        elsewhere: the share of draws that are not goal states but states from anywhere. OMPL
            offers no other way to bring samplers of one's own to planners with a goal bias; what
            is a goal is still decided by ``distanceGoal``.
    """

    def __init__(
        self,
        si: Any,
        codec: Codec,
        draws: Draws,
        guard: Guard,
        count: int,
        elsewhere: float = 0.0,
    ) -> None:
        super().__init__(si)
        self._codec, self._draws, self._guard = codec, draws, guard
        self._count, self._elsewhere = count, elsewhere

    @answered(math.inf, when_closed=False)
    def distanceGoal(self, state: Any) -> float:
        """Return how far ``state`` is from the goal, 0 inside; relative to the ranges."""
        here = self._codec.read(state)
        wanted = zip(here.placements, self._codec.problem.fingers.goal, strict=True)
        wrong = sum(
            have == UNPLACED or (want is not None and have != want) for have, want in wanted
        )
        return float(wrong + self._draws.to_goal(here.q) + self._draws.stuck(here))

    @answered(None, when_closed=False)
    def sampleGoal(self, state: Any) -> None:
        """Draw a goal state (or, as the share ``elsewhere`` says, any state) into ``state``.

        Where none is found the result is no valid state.
        """
        draws = self._draws
        anywhere = self._elsewhere and draws.rng.random() < self._elsewhere
        drawn = None
        if not self._guard.closed():
            drawn = draws.anywhere() if anywhere else draws.goal()
        self._codec.write(state, drawn or self._codec.nowhere, draws.rng.random())

    def maxSampleCount(self) -> int:
        """Return how many goal states there are to draw."""
        return self._count


@final
class ObjectProjection(ob.ProjectionEvaluator):
    """From a state to where the object is: what KPIECE1 covers.

    The size of cells is left to OMPL, which takes a twentieth of what it sees.
    """

    def __init__(self, space: Any, codec: Codec, guard: Guard) -> None:
        super().__init__(space)  # not kept: the space owns the projection
        self._codec, self._guard = codec, guard

    def getDimension(self) -> int:
        """Return how many numbers there are."""
        return self._codec.projects

    @answered(None, when_closed=False)
    def project(self, state: Any, projection: Any) -> None:
        """Write the projection of ``state`` into the array ``projection``."""
        projection[:] = self._codec.projected(state)
