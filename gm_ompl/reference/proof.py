"""A decision of Sec. 3.4 with its proof: HiGHS first, exact arithmetic where that proves nothing.

For each largest set of position-controlled fingers that passes Problem (5) there are two bounds on
z that trust no solver. From below: the solver's forces balance z l_i up to r_i for all i; as the
l_i circumscribe the unit ball, z - max |r_i| is resisted exactly. From above: multipliers y_i in
the polar of the environment's cone, moved into it along Problem (5)'s separating wrench.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.cases import Case, cases, exact_stability
from gm_ompl.reference.exact import Effort, balanced
from gm_ompl.reference.exact_command import exact_best, joint_best
from gm_ompl.reference.internal_force import InternalForce
from gm_ompl.reference.modes import Modes, ModeSet, choose, decision, maximal_sets, squeezed
from gm_ompl.reference.program import LpStatus
from gm_ompl.reference.stability import DIRECTIONS, Stability, stability_program
from gm_ompl.reference.statics import Statics

CLOSE = 9e-7
"""Both bounds lie within this of each other, relative to max(z, LITTLE): else no proof."""
LITTLE = 1e-3
"""z below this (over M g) need only be known to CLOSE times this."""


def closed(least: float, most: float) -> bool:
    """Whether bounds on z are close enough to be a proof."""
    return most - least <= CLOSE * max(most, LITTLE)


@dataclass(frozen=True, eq=False)
class Bracket:
    """What is proven of z for given modes.

    Attributes:
        least: z at ``f_com`` is at least this.
        most: z is at most this for every f_com; negative where nothing balances the load.
        f_com: (n,), 0 under position control.
        direction: number of a direction that limits z, or -1.
    """

    least: float
    most: float
    f_com: Array
    direction: int

    @property
    def closed(self) -> bool:
        """Whether the bounds are close enough to be a proof of z."""
        return self.most < 0.0 or closed(self.least, self.most)


def proven_decision(instant: Instant, prefer: Modes | None = None) -> ModeDecision | None:
    """Return the decision of Sec. 3.4, or None where it cannot be proven.

    Args:
        instant: the contacts, the fingers, the object.
        prefer: modes to prefer among equally many position-controlled fingers, in a tie.
    """
    among, judged = cases(instant), []
    try:
        sets = maximal_sets(squeezed(instant))
        found = [
            bracket(among[0].model, modes, verdict) if len(among) == 1 else common(among, modes)
            for modes, verdict in sets.passed
        ]
    except SolverError:
        return None
    if sets.marginal or not all(each.closed for each in found):
        return None
    for (modes, verdict), each in zip(sets.passed, found, strict=True):
        z = each.least if each.most >= 0.0 else -np.inf
        judged.append(ModeSet(modes, verdict, Stability(z, each.f_com, each.direction, 0.0)))
    return decision(choose(judged, prefer), instant)


def bracket(model: Statics, modes: Modes, verdict: InternalForce) -> Bracket:
    """Return what is proven of z for modes that pass Problem (5), by the verdict given.

    Raises:
        SolverError: where exact arithmetic takes too long.
    """
    force = np.array([mode is ControlMode.FORCE for mode in modes], dtype=bool)
    try:
        solution = highs.solve(stability_program(model, modes))
    except SolverError:
        solution = None
    if solution is not None and solution.status is LpStatus.OPTIMAL:
        found = _by_solution(model, force, verdict, solution.x, solution.dual)
        if found.closed:
            return found
    effort, nobody = Effort(), np.zeros(model.fingers, dtype=bool)
    best = exact_best(model, force, effort)
    if not closed(best.least, max(best.most, 0.0)):
        best = joint_best(model, force, effort)
    if best.least <= 0.0 and not balanced(model, model.f_max, nobody, effort):
        return Bracket(-np.inf, -np.inf, np.zeros(model.fingers), -1)
    return Bracket(best.least, max(best.most, 0.0), best.f_com, best.direction)


def common(among: Sequence[Case], modes: Modes) -> Bracket:
    """Return what is proven of z in the worst case for modes that pass Problem (5).

    Raises:
        SolverError: where exact arithmetic takes too long.
    """
    best = exact_stability(among, modes, Effort())
    if best.least == -np.inf:
        return Bracket(-np.inf, -np.inf, np.zeros(len(modes)), -1)
    return Bracket(best.least, max(best.most, 0.0), best.f_com, best.direction)


def _by_solution(
    model: Statics, force: BoolArray, verdict: InternalForce, x: Array, dual: Array
) -> Bracket:
    """Return what a solution of ``stability_program`` and its multipliers prove."""
    n, N = model.fingers, len(DIRECTIONS)
    z, f_com = float(x[0]), np.clip(x[1 : 1 + n], 0.0, model.f_max)
    A = np.hstack([model.env_wrenches, model.rob_wrenches])
    k = np.maximum(x[1 + n :].reshape(N, -1), 0.0)
    rest = np.linalg.norm(model.load + k @ A.T - z * DIRECTIONS, axis=1)
    pressing = k[:, model.env_wrenches.shape[1] :] @ model.normal_parts.T
    wrong = np.where(force, np.abs(pressing - f_com), np.maximum(pressing - model.f_max, 0.0))
    # A normal force put right moves the wrench by so much.
    arms = np.array([
        (np.linalg.norm(model.rob_wrenches[:, own], axis=0) / model.normal_parts[i, own]).max()
        for i, own in enumerate(model.columns)
    ])  # fmt: skip
    least = z - float((rest + wrong @ arms).max())
    y = dual.reshape(N, 6 + n)[:, :6]
    direction = int(np.abs(np.einsum("ij,ij->i", y, DIRECTIONS)).argmax())
    most = min(upper_bound(model, force, verdict, sign * y) for sign in (1.0, -1.0))
    return Bracket(max(least, 0.0), most, np.where(force, f_com, 0.0), direction)


def upper_bound(model: Statics, force: BoolArray, verdict: InternalForce, y: Array) -> float:
    """Return the bound on z for every f_com that wrenches y (K, 6) prove together."""
    env = model.env_wrenches
    outside = np.maximum(y @ env, 0.0).max(axis=1, initial=0.0)
    if outside.any():
        y = y - (outside / verdict.margin)[:, None] * verdict.wrench
    h = float((y @ DIRECTIONS.T).max(axis=1).sum())
    bound = float((y @ model.load).sum())
    for i, own in enumerate(model.columns):
        tips = model.rob_wrenches[:, own] / model.normal_parts[i, own]
        sigma = (y @ tips).max(axis=1)
        slope = sigma.sum() if force[i] else np.maximum(sigma, 0.0).sum()
        bound += float(model.f_max[i]) * max(float(slope), 0.0)
    return bound / h if h > 0.0 else np.inf
