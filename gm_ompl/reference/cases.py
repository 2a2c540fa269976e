"""Problem (6) in several cases at once: one f_com, and z the least of theirs.

A case is a world at a corner of what is not known exactly. Commands are chosen before the world is
known, so they are common to all; forces are found in each. Where nothing is uncertain there is one
case, the nominal one.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.optimize import nnls

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.bases import Bases, Margins
from gm_ompl.reference.equilibrium import BALANCED, blocks
from gm_ompl.reference.exact import Effort, balanced
from gm_ompl.reference.exact_command import ExactBest, exact_common
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.stability import (
    DIRECTIONS,
    NEGLIGIBLE,
    Stability,
    stability,
    stability_at,
)
from gm_ompl.reference.statics import Statics, known_wrench, statics
from gm_ompl.uncertainty.worlds import cases_of

AGREED = 1e-9
"""z of two programs that agree to this, relative to max(z, 1e-3), are equal."""


ROUNDING = 1e-12
"""What a sum of forces may miss a load by, in norm (7) over the unit of force."""


class Case(NamedTuple):
    """The mechanics in one case.

    Attributes:
        model: its matrices; norm, reference point and unit of force are the nominal ones.
        press: (n,), what a command of 1 presses with.
    """

    model: Statics
    press: Array

    def commanded(self, f_com: Array) -> Array:
        """Return what commands (n,) press with, within [0, f_max]."""
        pressed: Array = np.clip(f_com * self.press, 0.0, self.model.f_max)
        return pressed


def cases(instant: Instant) -> tuple[Case, ...]:
    """Return the cases of an instant; those that differ in the load alone share their matrices."""
    alike: dict[bytes, Statics] = {}
    found = []
    for there, world in cases_of(instant):
        arrays = (there.points, there.friction, there.friction_at_contacts)
        key = b"|".join(array.tobytes() for array in arrays)
        if key not in alike:
            alike[key] = statics(there)
        press = 1.0 + np.array(world.command) if world.command else np.ones(len(instant.points))
        found.append(Case(replace(alike[key], Q_known=known_wrench(there)), press))
    return tuple(found)


def hardest(among: tuple[Case, ...]) -> tuple[Case, ...]:
    """Return the cases among which the worst is, whatever is commanded.

    A case is left out where its load and some forces of the environment add up to a mean of the
    loads of others that differ from it in the load alone: z is concave in the load, and what
    resists a disturbance of that mean, with these forces added, resists it here.
    """
    kept = list(among)
    k = 0
    while k < len(kept):
        case = kept[k]
        others = [o.model.load for o in kept if o is not case and _same_but_for_load(case, o)]
        if others and is_mean(case.model, np.array(others), case.model.env_wrenches):
            del kept[k]
        else:
            k += 1
    return tuple(kept)


def _same_but_for_load(one: Case, other: Case) -> bool:
    pairs = ((one.press, other.press), (one.model.W_rob, other.model.W_rob),
             (one.model.C_env, other.model.C_env))  # fmt: skip
    return all(np.array_equal(a, b) for a, b in pairs)


def is_mean(model: Statics, loads: Array, forces: Array) -> bool:
    """Whether the load and some forces (6, e) add up to a mean of ``loads`` (D, 6)."""
    weights = np.append(np.ones(len(loads)), np.zeros(forces.shape[1]))
    matrix = np.vstack([np.hstack([loads.T, -forces]), weights])
    return bool(nnls(matrix, np.append(model.load, 1.0))[1] <= ROUNDING)


def most_command(among: Sequence[Case]) -> Array:
    """Return the largest commands (n,) that press with no more than f_max in any case."""
    press = np.array([case.press for case in among]).max(axis=0)
    most: Array = among[0].model.f_max / press
    return most


def stability_in(among: Sequence[Case], modes: Sequence[ControlMode]) -> Stability:
    """Return z in the worst case for the given modes, f_com chosen best for it.

    Directions of cases join one program as they turn out to be resisted less than its z.

    Raises:
        SolverError: the solver returned no answer.
    """
    if len(among) == 1:
        return stability(among[0].model, modes)
    most, chosen, bases = most_command(among), list[tuple[int, int]](), Bases()
    if ControlMode.FORCE not in modes:
        return min(stabilities(among, modes, most, bases), key=_margin)
    bound, f_com = np.inf, 0.5 * most
    try:
        while True:
            at = stabilities(among, modes, f_com, bases)
            worst = min(at, key=_margin)
            if bound < np.inf and bound - worst.z <= AGREED * max(bound, 1e-3):
                return Stability(min(bound, worst.z), f_com, worst.direction, 0.0)
            below = [(k, found.direction) for k, found in enumerate(at) if found.z < bound]
            new = [pair for pair in below if pair not in chosen]
            if not new:
                raise SolverError("the program's f_com is worse than the program says")
            chosen += new
            program = common_program(among, modes, chosen)
            solution = highs.solve(program)
            if solution.status is LpStatus.INFEASIBLE:
                return Stability(-np.inf, np.zeros(0), new[0][1], 0.0)
            if solution.status is LpStatus.UNBOUNDED:
                return Stability(np.inf, f_com, -1, 0.0)
            bound = solution.objective if solution.objective > NEGLIGIBLE else 0.0
            f_com = np.where(is_forced(modes), np.clip(solution.x[1 : 1 + len(most)], 0, most), 0.0)
    except SolverError:
        best = exact_stability(among, modes, Effort())
        return Stability(best.least, best.f_com, best.direction, 0.0)


def stabilities(
    among: Sequence[Case], modes: Sequence[ControlMode], f_com: Array, bases: Bases,
    allowed: float = BALANCED,
) -> list[Stability]:  # fmt: skip
    """Return what Problem (6) says in each case for a given f_com (n,).

    ``bases`` remembers from case to case; ``allowed`` may be missing of equilibrium.

    Raises:
        SolverError: the solver returned no answer.
    """
    force, answers = is_forced(modes), []
    for k, case in enumerate(among):
        pressed = np.where(force, case.commanded(f_com), 0.0)
        key = force.tobytes(), k
        found = bases.margins(key, case.model, force, pressed, (key[0], k - 1))
        if found is not None and NEGLIGIBLE < found.z < np.inf:
            answers.append(Stability(found.z, f_com, int(found.tau.argmax()), 0.0))
        else:
            answers.append(stability_at(case.model, modes, pressed, allowed))
    return answers


def margins_in(
    among: Sequence[Case], force: BoolArray, f_com: Array, bases: Bases, key: Hashable
) -> tuple[Margins, ...] | None:
    """Return Problem (6) per case for fixed f_com (n,); None where a direction has no optimum."""
    found = []
    for k, case in enumerate(among):
        pressed = np.where(force, case.commanded(f_com), 0.0)
        margins = bases.margins((key, k), case.model, force, pressed, (key, k - 1))
        if margins is None:
            return None
        found.append(margins)
    return tuple(found)


def common_program(
    among: Sequence[Case], modes: Sequence[ControlMode], chosen: Sequence[tuple[int, int]]
) -> LinearProgram:
    """Build Problem (6) for some directions of some cases.

    Variables z, f_com (n), then k per pair; rows per pair as in ``stability_program``.

    Args:
        among: the cases.
        modes: per finger.
        chosen: pairs of a case and a direction.
    """
    force, n = is_forced(modes), among[0].model.fingers
    common, own, low, high = [], [], [], []
    for k, direction in chosen:
        model, press = among[k]
        A, normal = blocks(model)
        shared = np.zeros((6 + n, 1 + n))
        shared[:6, 0] = -DIRECTIONS[direction]
        shared[6:, 1:] = -np.diag(force * press)
        common.append(shared)
        own.append(sparse.csc_array(np.vstack([A, normal])))
        low.append(np.append(-model.load, np.where(force, 0.0, -np.inf)))
        high.append(np.append(-model.load, np.where(force, 0.0, model.f_max)))
    forces = sparse.block_diag(own)
    columns = 1 + n + forces.shape[1]
    free = np.full(forces.shape[1], np.inf)
    most = np.where(force, most_command(among), 0.0)
    return LinearProgram(
        cost=np.append(1.0, np.zeros(columns - 1)),
        matrix=sparse.csc_array(sparse.hstack([sparse.csc_array(np.vstack(common)), forces])),
        row_lower=np.concatenate(low),
        row_upper=np.concatenate(high),
        col_lower=np.zeros(columns),
        col_upper=np.concatenate([[np.inf], most, free]),
        maximise=True,
    )


def exact_stability(
    among: Sequence[Case], modes: Sequence[ControlMode], effort: Effort
) -> ExactBest:
    """Return exact bounds on z in the worst case; ``least`` is -inf where nothing balances.

    Raises:
        SolverError: where it takes too long, or z is so small that it may be none.
    """
    models, force = [case.model for case in among], is_forced(modes)
    presses = [case.press for case in among]
    best = exact_common(models, presses, most_command(among), force, effort)
    if best.least > 0.0:
        return best
    nobody = np.zeros(len(force), dtype=bool)
    if not all(balanced(model, model.f_max, nobody, effort) for model in models):
        return best._replace(least=-np.inf, most=-np.inf)
    pressed = [np.where(force, case.commanded(best.f_com), case.model.f_max) for case in among]
    if not all(
        balanced(model, limits, force, effort)
        for model, limits in zip(models, pressed, strict=True)
    ):
        raise SolverError("whether any common f_com balances all cases could not be decided")
    return best


def is_forced(modes: Sequence[ControlMode]) -> BoolArray:
    """Return which fingers are force-controlled, (n,)."""
    return np.array([mode is ControlMode.FORCE for mode in modes], dtype=bool)


def _margin(found: Stability) -> float:
    return found.z
