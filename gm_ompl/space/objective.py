"""The cost of a motion for OMPL: Eqs. (9) and (10), and a bound from below."""

from __future__ import annotations

import math
from typing import Any, final

from ompl import base as ob

from gm_ompl.sampling.motions import UNPLACED, ContinuousModel, HybridState
from gm_ompl.space.convert import Codec
from gm_ompl.space.guard import Guard
from gm_ompl.space.motions import Motions


def cost_bound(model: ContinuousModel, origin: HybridState, target: HybridState) -> float:
    """Return a lower bound on the cost of every plan from ``origin`` to ``target``.

    A finger whose placement differs is regrasped at least once. Where none differs, either no
    finger is regrasped and each travels at least the straight line between its places, or at
    least one regrasp is paid for: the first case of Eq. (11), limited to X_regr. A finger
    without placement gets its first one free of charge.
    """
    price = model.problem.cost.regrasp
    pairs = list(zip(origin.placements, target.placements, strict=True))
    changed = sum(UNPLACED not in pair and pair[0] != pair[1] for pair in pairs)
    if changed or any(UNPLACED in pair for pair in pairs):
        return changed * price
    return min(model.least_travel(origin.q, target.q, target.placements), price)


@final
class PlanCost(ob.OptimizationObjective):
    """Eq. (9) for displacements plus Eq. (10) for regrasps; not symmetric."""

    def __init__(self, si: Any, codec: Codec, motions: Motions, guard: Guard) -> None:
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
        guard = self._guard
        try:
            a, b = self._codec.read(origin), self._codec.read(target)
            if a == b:
                return ob.Cost(0.0)
            if guard.closed():
                return ob.Cost(math.inf)
            return ob.Cost(self._motions.cost(a, b))
        except BaseException as error:
            guard.keep(error)
            return ob.Cost(math.inf)

    def motionCostHeuristic(self, origin: Any, target: Any) -> Any:
        """Return a lower bound on the cost of every way from ``origin`` to ``target``."""
        guard = self._guard
        try:
            if guard.closed():
                return ob.Cost(0.0)
            read = self._codec.read
            return ob.Cost(cost_bound(self._motions.model, read(origin), read(target)))
        except BaseException as error:
            guard.keep(error)
            return ob.Cost(0.0)
