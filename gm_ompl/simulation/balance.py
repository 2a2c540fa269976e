"""Forces that a plan allows: one balance to lean on, and the range of each normal force.

The plan commands the normal forces under force control and nothing else. All other forces are
indeterminate: Eq. (3) has many solutions, and a position-controlled finger is only assumed to find
one. What a real finger finds depends on how it leans on its target. The solution used here keeps
all contacts as far inside their friction cones as they can be at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.environment import contacts_at
from gm_ompl.errors import SolverError
from gm_ompl.motion.arc import Moment
from gm_ompl.planfile.model import PlacementRecord
from gm_ompl.problem import Problem
from gm_ompl.reference import highs
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.statics import Statics, statics

THRIFT = 1e-3  # weight of the sum of all forces against the depth in the cones: settles ties alone

SPARE = 1e-6  # distance from the cones' faces, of ``Statics.scale``, below which there is none


@dataclass(frozen=True, eq=False)
class Balance:
    """Finger forces in equilibrium, at one place of a plan; object frame, scenario's units."""

    holds: bool  # whether Eq. (3) is found to have a solution at all.
    forces: Array  # (n, 3), each finger's force on the object; zero where ``holds`` is False
    least: Array  # (n,), least normal force in any solution; NaN where ``holds`` is False
    most: Array  # (n,), greatest


def balance(
    problem: Problem,
    moment: Moment,
    placements: Sequence[PlacementRecord],
    force: BoolArray,
    f_com: Array,
    lifted: int | None = None,
) -> Balance:
    """Return finger forces that hold the object at ``moment``.

    Args:
        problem: the scenario.
        moment: where the object is and how it moves.
        placements: per finger.
        force: (n,), whether each finger is force-controlled.
        f_com: (n,), commanded normal forces; counts where ``force`` says so.
        lifted: a finger that does not touch.
    """
    n = len(placements)
    down = [i for i in range(n) if i != lifted]
    model = statics_at(problem, moment, placements, down)
    forced, commanded = force[down], f_com[down] / model.scale
    forces, least, most = np.zeros((n, 3)), np.full(n, np.nan), np.full(n, np.nan)
    program, edges = _program(model, forced, commanded), model.env_wrenches.shape[1]
    try:
        found = highs.solve(program)
        if found.status is not LpStatus.OPTIMAL:
            return Balance(False, forces, least, most)
        least[down], most[down] = _ranges(program, model, forced, commanded)
    except SolverError:
        return Balance(False, forces, least, most)
    forces[down] = model.scale * (model.C_rob @ found.x[edges:-1]).reshape(-1, 3)
    return Balance(True, forces, least, most)


def balances(
    problem: Problem,
    moment: Moment,
    placements: Sequence[PlacementRecord],
    force: BoolArray,
    f_com: Array,
) -> bool:
    """Return whether Eq. (3) has a solution with anything to spare; see ``balance``."""
    model = statics_at(problem, moment, placements, range(len(placements)))
    try:
        found = highs.solve(_program(model, force, f_com / model.scale))
    except SolverError:
        return False
    return found.status is LpStatus.OPTIMAL and found.objective > SPARE


def statics_at(
    problem: Problem, moment: Moment, placements: Sequence[PlacementRecord], down: Sequence[int]
) -> Statics:
    """Return the mechanics of Sec. 2.2 at one place of a plan, the fingers ``down`` touching."""
    contacts = contacts_at(moment, problem.body, problem.environment)
    # The plan's own points, whatever the table says: what is executed is the plan.
    instant = replace(
        problem.instant(contacts, tuple(down), (0,) * len(down)),
        points=np.array([placements[i].point for i in down]),
        normals=np.array([placements[i].normal for i in down]),
    )
    return statics(instant)


def _program(model: Statics, forced: BoolArray, commanded: Array) -> LinearProgram:
    """Build: maximise t subject to Eq. (3) without disturbance and every coefficient >= t.

    Variables k_env, k_rob, t; rows: equilibrium (6), normal force per finger, k - t >= 0.
    """
    env, rob = model.env_wrenches, model.rob_wrenches
    edges = env.shape[1] + rob.shape[1]
    normal = np.hstack([np.zeros((len(forced), env.shape[1])), model.normal_parts])
    upper = np.vstack([np.hstack([env, rob]), normal])
    deeper = np.hstack([np.eye(edges), -np.ones((edges, 1))])
    matrix = np.vstack([np.hstack([upper, np.zeros((len(upper), 1))]), deeper])
    limits = np.where(forced, commanded, model.f_max)
    # A position-controlled finger keeps as far from its limit as from its cone's faces.
    matrix[6 : 6 + len(forced), -1] = np.where(forced, 0.0, 1.0)
    return LinearProgram(
        cost=np.append(np.full(edges, -THRIFT), 1.0),
        matrix=sparse.csc_array(matrix),
        row_lower=np.concatenate(
            [-model.load, np.where(forced, commanded, -np.inf), np.zeros(edges)]
        ),
        row_upper=np.concatenate([-model.load, limits, np.full(edges, np.inf)]),
        col_lower=np.zeros(edges + 1),
        col_upper=np.append(np.full(edges, np.inf), 1.0 + float(limits.sum())),
        maximise=True,
    )


def _ranges(
    program: LinearProgram, model: Statics, forced: BoolArray, commanded: Array
) -> tuple[Array, Array]:
    """Return the least and greatest normal force of every finger, scenario's units."""
    least, most = commanded.copy(), commanded.copy()
    edges = model.env_wrenches.shape[1]
    col_upper = program.col_upper.copy()
    col_upper[-1] = 0.0
    for i in np.flatnonzero(~forced):
        cost = np.concatenate([np.zeros(edges), model.normal_parts[i], [0.0]])
        for sign, bound in ((-1.0, least), (1.0, most)):
            wanted = LinearProgram(
                sign * cost, program.matrix, program.row_lower, program.row_upper,
                program.col_lower, col_upper, maximise=True,
            )  # fmt: skip
            bound[i] = sign * highs.solve(wanted).objective
    return model.scale * least, model.scale * most
