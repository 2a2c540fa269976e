"""Problem (5) in all worlds between two: no internal force can grow without limit in any.

On the way from one world to the other the columns change by a constant rate, a(t). A wrench that
changes likewise, w(t), has a product with each of them that is quadratic in t; it is positive all
the way if its three coefficients in Bernstein's form are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.internal_force import excessive_internal_force, separation_program
from gm_ompl.reference.program import LpStatus
from gm_ompl.reference.statics import Statics
from gm_ompl.tolerance.sites import Site

CLEAR: Final = 1e-8
"""Products of unit wrenches count as positive from here on: ten times what (5) calls none."""


@dataclass(frozen=True, eq=False)
class Squeeze:
    """Problem (5) in one world.

    Attributes:
        excessive: whether internal force could grow without limit.
        columns: (6, e), of environment and position-controlled fingers, per unit of normal force.
    """

    excessive: bool
    columns: Array

    @cached_property
    def wrench(self) -> Array:
        """(6,), unit, its product with every column positive; zeros where none is known."""
        return np.zeros(6) if self.excessive else separating(self.columns)


def squeeze(site: Site, model: Statics, columns: Array) -> Squeeze:
    """Judge Problem (5) for the stored modes of ``site`` in a world, given by ``mechanics``."""
    verdict = excessive_internal_force(model, site.position)
    return Squeeze(verdict.excessive, columns[:, pressing(site, model)])


def pressing(site: Site, model: Statics) -> IntArray:
    """Return which columns may press without limit: the environment's, and position control's."""
    edges = model.C_env.shape[1]
    own = [np.arange(edges)]
    own += [
        edges + np.arange(part.start, part.stop)
        for i, part in enumerate(model.columns)
        if i in site.position
    ]
    return np.concatenate(own)


def separating(columns: Array) -> Array:
    """Return the unit wrench (6,) that keeps farthest from being normal to any column (6, e)."""
    none = np.zeros(6)
    if not columns.shape[1]:
        return none
    try:
        found = highs.solve(separation_program(columns / np.linalg.norm(columns, axis=0)))
    except SolverError:
        return none
    if found.status is not LpStatus.OPTIMAL:
        return none
    wrench: Array = found.x[:6] / (float(np.linalg.norm(found.x[:6])) or 1.0)
    return wrench


def clear(columns: Array) -> bool:
    """Whether some wrench has a positive product with every column (6, e)."""
    products = separating(columns) @ columns
    return bool((products >= CLEAR * np.linalg.norm(columns, axis=0)).all())


def clear_between(one: Squeeze, other: Squeeze) -> bool:
    """Whether in no world between two internal force can grow; their columns change evenly."""
    a, b = one.columns, other.columns
    if not a.shape[1]:
        return True
    least = CLEAR * np.maximum(np.linalg.norm(a, axis=0), np.linalg.norm(b, axis=0))
    shared = separating(np.hstack([a, b]))
    for w, v in ((one.wrench, other.wrench), (shared, shared)):
        middle = (w @ b + v @ a) / 2.0
        if all((product >= least).all() for product in (w @ a, middle, v @ b)):
            return True
    return False
