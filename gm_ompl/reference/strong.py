"""z_strong: the least disturbance under which the contacts may give way.

Problem (6) lets contacts find any forces that balance a load, whatever brought them about. Where
they are indeterminate that is optimistic (Maeda, Oda and Makita 2007). A wrench is *strongly held*
(Pang and Trinkle, ICRA 2000) if no deviation v != 0 of the object goes with forces that balance
it. For each mode of all contacts (``contact_modes``) the wrenches that are not form a polyhedron;
z_strong is z or the least t with one of them in the load's neighbourhood of size t, the hull of
t l_i that Problem (6) has.

Branch and bound over the contacts, one after the other: a linear program in which the rest may
press as they like bounds t from below, and modes that no v != 0 has are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy import sparse
from scipy.optimize import nnls

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.reference import highs
from gm_ompl.reference.contact_modes import ContactMode, contacts_of
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.stability import DIRECTIONS
from gm_ompl.reference.statics import Statics, statics

CANCELS = 1e-9
"""What is left of rows of unit length, each taken at least once, when they cancel."""

CLOSER = 1e-9
"""By how much less, over M g, another mode must give way to be told instead."""


@dataclass(frozen=True, eq=False)
class StrongMargin:
    """How much is strongly held.

    Attributes:
        z: z_strong in the scenario's units of force, at most the z it was asked with.
        modes: what every contact does at z_strong, in words, the environment's first; empty where
            nothing gives way below z.
        wrench: (6,), the disturbance about the origin, object frame, scenario's units, under which
            they do; zero where none does.
    """

    z: float
    modes: tuple[str, ...]
    wrench: Array


def strong_margin(
    instant: Instant, modes: Sequence[ControlMode], f_com: Sequence[float | None], z: float,
    fingers: Sequence[int] | None = None, enough: float = -np.inf,
) -> StrongMargin:  # fmt: skip
    """Return z_strong of control modes and commands at an instant, in the nominal world.

    Args:
        instant: the contacts, the fingers, the object.
        modes: per finger.
        f_com: per finger, its commanded normal force; None under position control.
        z: the margin of Problem (6), the scenario's units; what gives way only beyond is not asked.
        fingers: the numbers that the fingers are told by; counted from 0 where left out.
        enough: where z_strong is at most this, it need not be known any better.

    Raises:
        SolverError: the solver returned no answer.
        LimitError: a limit in force is reached.
    """
    model = statics(instant)
    commands = np.array([0.0 if f is None else f for f in f_com], dtype=np.float64) / model.scale
    force = np.array([mode is ControlMode.FORCE for mode in modes], dtype=bool)
    # Fingertips first: they have most to say about what can move.
    contacts = contacts_of(instant, model, modes, fingers)[::-1]
    search = _Search(
        [[_unit(mode) for mode in contact.modes(instant.cone_edges)] for contact in contacts],
        [_unit_rows(contact.least) for contact in contacts], _Load(model, force, commands),
        z / model.scale, enough / model.scale,
    )  # fmt: skip
    search.run()
    wrench = np.asarray(np.linalg.solve(model.R_sqrt, search.disturbance), dtype=np.float64)
    return StrongMargin(search.best * model.scale, search.names[::-1], wrench * model.scale)


@final
class _Load:
    """The least disturbance that some of the columns balance, together with the load."""

    def __init__(self, model: Statics, force: BoolArray, commands: Array) -> None:
        n, N = model.fingers, len(DIRECTIONS)
        wrenches = np.hstack([model.env_wrenches, model.rob_wrenches])
        self.columns = wrenches.shape[1]
        matrix = np.zeros((6 + n, N + self.columns))
        matrix[:6] = np.hstack([DIRECTIONS.T, wrenches])
        matrix[6:, matrix.shape[1] - model.normal_parts.shape[1] :] = model.normal_parts
        free = np.full(matrix.shape[1], np.inf)
        lower = np.concatenate([-model.load, np.where(force, commands, 0.0)])
        upper = np.concatenate([-model.load, np.where(force, commands, model.f_max)])
        cost = np.concatenate([np.ones(N), np.zeros(self.columns)])
        self._solver = highs.Solver(
            LinearProgram(
                cost, sparse.csc_array(matrix), lower, upper, np.zeros(matrix.shape[1]), free
            )
        )

    def least(self, pressing: BoolArray) -> tuple[float, Array]:
        """Return t, proven not to be less, and the disturbance (6,) in norm (7), over M g.

        t is inf where nothing balances.
        """
        upper = np.concatenate([np.full(len(DIRECTIONS), np.inf), np.where(pressing, np.inf, 0.0)])
        solution = self._solver.solve_within(upper)
        if solution.status is not LpStatus.OPTIMAL:
            return np.inf, np.zeros(6)
        disturbance: Array = solution.x[: len(DIRECTIONS)] @ DIRECTIONS
        return max(solution.dual_bound(), 0.0), disturbance


@final
class _Search:
    """Depth first over the contacts' modes, what gives way under least first."""

    def __init__(
        self, modes: list[list[ContactMode]], least: list[Array], load: _Load, z: float,
        enough: float,
    ) -> None:  # fmt: skip
        self._modes, self._least, self._load, self._enough = modes, least, load, enough
        self.best, self.names, self.disturbance = z, tuple[str, ...](), np.zeros(6)

    def run(self) -> None:
        """Find the least t."""
        everything = np.ones(self._load.columns, dtype=bool)
        self._descend([], everything, 0.0, np.zeros(6))

    def _descend(
        self, chosen: list[ContactMode], pressing: BoolArray, t: float, disturbance: Array
    ) -> None:
        limits.check()
        depth = len(chosen)
        if depth == len(self._modes):
            self.best, self.disturbance = t, disturbance
            self.names = tuple(mode.name for mode in chosen)
            return
        open_ = []
        own = np.concatenate([mode.pressing for mode in self._modes[depth]])
        for mode in self._modes[depth]:
            if not self._moves([*chosen, mode]):
                continue
            allowed = pressing.copy()
            allowed[own] = False
            allowed[mode.pressing] = True
            open_.append((*self._load.least(allowed), allowed, mode))
        for bound, wrench, allowed, mode in sorted(open_, key=lambda entry: entry[0]):
            if self.best > self._enough and bound < self.best - CLOSER:
                self._descend([*chosen, mode], allowed, bound, wrench)

    def _moves(self, chosen: list[ContactMode]) -> bool:
        """Whether some v != 0 goes with the modes chosen, the other contacts not penetrated."""
        least = np.vstack([mode.least for mode in chosen] + self._least[len(chosen) :])
        return not _only_zero(least, np.vstack([mode.zero for mode in chosen]))


def only_zero(least: Array, zero: Array) -> bool:
    """Whether v = 0 alone has ``least @ v >= 0`` and ``zero @ v = 0``.

    By Stiemke's theorem: the rows have rank 6, and those of ``least``, each taken some positive
    number of times, cancel with the others.
    """
    return _only_zero(_unit_rows(least), _unit_rows(zero))


def _only_zero(least: Array, zero: Array) -> bool:
    """As ``only_zero``, of rows of unit length; the cheaper question first."""
    if len(least) + len(zero) < 6:
        return False
    if len(least):
        try:
            left = nnls(np.hstack([least.T, zero.T, -zero.T]), -least.sum(axis=0))[1]
        except RuntimeError:  # too many iterations
            return False
        if left >= CANCELS:
            return False
    return bool(np.linalg.svd(np.vstack([least, zero]), compute_uv=False)[5] >= CANCELS)


def _unit(mode: ContactMode) -> ContactMode:
    return replace(mode, least=_unit_rows(mode.least), zero=_unit_rows(mode.zero))


def _unit_rows(rows: Array) -> Array:
    lengths = np.linalg.norm(rows, axis=1)
    unit: Array = rows[lengths > 0.0] / lengths[lengths > 0.0, None]
    return unit
