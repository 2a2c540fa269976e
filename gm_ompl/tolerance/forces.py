"""Problem (6) in one world, with forces for every direction at one level; Problem (5) beside it.

Columns are scaled to a normal force of 1 here: those of friction cones and fingertips then change
by a constant rate with a coefficient of friction and with a shift of the fingertip.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import SolverError
from gm_ompl.reference.equilibrium import blocks, in_equilibrium
from gm_ompl.reference.stability import DIRECTIONS, NEGLIGIBLE, K, stability_at
from gm_ompl.reference.statics import Statics, statics
from gm_ompl.tolerance.directions import Programs, Resisted
from gm_ompl.tolerance.sites import MISSING, Site
from gm_ompl.uncertainty.worlds import World, excess_load, in_world

LEVEL: Final = 2.0
"""Where every disturbance can be resisted, forces are taken that resist this many times z_min."""


FINE: Final = 0.7
"""A direction resisted z_min over this far need not be known better."""


@dataclass(frozen=True, eq=False)
class Held:
    """What the stored modes and commands come to in one world; forces over ``Statics.scale``.

    Attributes:
        slack: z less what it must be; where that is much, a lower bound; where it is negative, an
            upper one. -inf where z must be positive and some disturbance cannot be resisted, or
            where nothing balances the load.
        model: the mechanics.
        columns: (6, c), R^(1/2) W C of environment and fingers, per unit of normal force.
        forces: (76, c), normal forces on these columns that resist z l_i; (0, c) where slack is
            -inf, or where nothing but the load can be balanced.
        found: what the next world's programs may start from.
    """

    slack: float
    model: Statics
    columns: Array
    forces: Array
    found: Resisted | None


def held(
    site: Site, world: World, last: Held | None = None, exactly: bool = False, even: bool = False
) -> Held:
    """Solve Problem (6) for the stored modes and commands of ``site`` in a world.

    Args:
        site: where.
        world: how it differs.
        last: an answer for a world nearby.
        exactly: whether slack must be right, not only a bound, where it is large.
        even: whether forces should change little from world to world, for proofs rest on them.

    Raises:
        SolverError: the solver returned no answer.
    """
    model, columns, normal = mechanics(site, world)
    pressed = world.commanded(site.f_com, site.instant.max_normal_force) / model.scale
    limits, none = np.where(site.force, pressed, model.f_max), np.zeros((0, columns.shape[1]))
    least = site.z_min * (1.0 - MISSING / 2.0) / model.scale
    enough = 1.0 / least if least > 0.0 else np.inf
    fine = 0.0 if exactly or least == 0.0 else FINE * enough
    start = None if last is None else last.found
    try:
        found = Programs(model, limits, site.force).solve(start, fine, enough, even)
    except SolverError:  # exact arithmetic tells z, but no forces
        z = stability_at(model, site.modes, limits).z
        return Held(z - least, model, columns, none, None)
    if np.isinf(found.most):  # some disturbance cannot be resisted
        rests = least == 0.0 and in_equilibrium(model, limits, site.force)
        return Held(0.0 if rests else -np.inf, model, columns, none, found)
    if found.most > enough:
        return Held(1.0 / found.most - least, model, columns, none, found)
    tau, x = found.tau, np.maximum(found.k, 0.0) * normal
    sums, total = x.sum(axis=0), float(tau.sum())
    if found.most <= NEGLIGIBLE:
        weights = np.zeros(len(DIRECTIONS))
        weights[0:12:2], weights[1:12:2] = (
            np.maximum(sign * model.load, 0.0) / K for sign in (-1.0, 1.0)
        )
        level = LEVEL * max(least, 1.0)
        return Held(level - least, model, columns, level * x + weights @ x, found)
    # What solutions leave of l_i takes that much from z (docs/background/mechanics.md).
    left = DIRECTIONS - np.outer(tau, model.load) - x @ columns.T
    z = float(((1.0 - np.linalg.norm(left, axis=1)) / tau.max()).min())
    forces = z * x + np.outer(1.0 - z * tau, sums) / total
    return Held(z - least, model, columns, forces, found)


def wider(nominal: Held, site: Site, world: World) -> Held:
    """Return ``nominal`` as it holds where all cones are at least as wide, without solving."""
    model, columns, _ = mechanics(site, world)
    return replace(nominal, model=model, columns=columns, forces=nominal.forces[:0], found=None)


def mechanics(site: Site, world: World) -> tuple[Statics, Array, Array]:
    """Return Sec. 2.2 in a world, and its columns per unit of normal force.

    Returns:
        The matrices; the columns (6, c) of environment and fingers; the normal forces (c,) of
        those of unit length.
    """
    shape = replace(world, mass=0.0, centre_of_mass=(0.0, 0.0, 0.0), tilt=(0.0, 0.0), command=())
    if shape not in site.shapes:
        site.shapes[shape] = _columns(site, shape)
    model, columns, normal = site.shapes[shape]
    excess = excess_load(site.instant, world) / model.scale
    return replace(model, Q_known=model.Q_known + excess), columns, normal


def _columns(site: Site, world: World) -> tuple[Statics, Array, Array]:
    """Do as ``mechanics`` does, in a world with the nominal load."""
    model = statics(in_world(site.instant, world))
    A, pressing = blocks(model)
    normal = pressing.sum(axis=0)
    if len(site.instant.contacts.normals):
        # A column is of one contact: the sum over all normals has that contact's alone.
        inward = site.instant.contacts.normals.ravel() @ model.C_env
        normal[: len(inward)] += inward
    return model, A / normal, normal
