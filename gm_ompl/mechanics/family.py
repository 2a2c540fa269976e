"""The columns of all cases: what ``decide_cases`` is asked with, built from ranges and contacts."""

from __future__ import annotations

import dataclasses

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.state import Instant
from gm_ompl.mechanics import columns
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.robust import Surroundings, Tips
from gm_ompl.uncertainty.ranges import Uncertainty
from gm_ompl.uncertainty.worlds import (
    World,
    contact_friction,
    corners,
    excess_load,
    shift_corners,
    shifts,
)

SAME = 1e-12
"""Loads, and columns, that differ by no more than this (in norm (7), over force_scale) are one."""


def surroundings(
    instant: Instant, uncertainty: Uncertainty, U: Array, known: dict[bytes, Array] | None = None
) -> Surroundings:
    """Return what the cases have around the object; the instant's fingers do not matter.

    Args:
        instant: the nominal contacts and the object.
        uncertainty: the ranges.
        U: (6, 6), see ``wrench_norm``.
        known: loads of the same object by its orientation, added to.
    """
    ranges = dataclasses.replace(uncertainty, finger_friction=(), position=0.0, command=0.0)
    worlds, scale = corners(ranges, 0, instant.mass), instant.force_scale
    known, key = {} if known is None else known, instant.contacts.rotation.tobytes()
    if key not in known:
        weight = instant.mass * instant.gravity / scale
        nominal = columns.load(instant.contacts.rotation, weight, U)
        loads = [nominal + U @ (excess_load(instant, world) / scale) for world in worlds]
        known[key] = worst_loads(np.array(loads), np.zeros((1, 0, 6)))
    friction = dict.fromkeys(world.sliding_friction for world in worlds)
    low = tuple(-width for width in ranges.environment_friction)
    high = ranges.environment_friction
    envs = [_environment(instant, World(low, sliding), U) for sliding in friction]
    squeeze = [_environment(instant, World(high, sliding), U) for sliding in (high, low)]
    around = np.array(_distinct(envs))
    return Surroundings(
        around,
        worst_loads(known[key], around),
        np.array(_distinct(np.concatenate(squeeze))).reshape(-1, 6),
        DIRECTIONS,
    )


def _environment(instant: Instant, world: World, U: Array) -> Array:
    friction = contact_friction(instant, world)
    return columns.environment_columns(instant.contacts, friction, instant.cone_edges, U)


def hand_tips(
    points: Array, normals: Array, friction: Array, soft: Array, s: int, U: Array,
    uncertainty: Uncertainty, *, f_max: Array,
) -> Tips:  # fmt: skip
    """Return what the cases of a hand have; arguments as for ``hand_columns``, and the ranges.

    ``f_max`` (n,) is over force_scale.
    """
    width = np.asarray(uncertainty.finger_friction or np.zeros(len(friction)))
    places = [points + _shifted(normals, at) for at in shift_corners(uncertainty.position)]
    low, high = (
        [columns.hand_columns(place, normals, mu, soft, s, U) for place in places]
        for mu in (np.maximum(friction - width, 0.0), friction + width)
    )
    return Tips(np.array(low), np.concatenate(high, axis=2), f_max, uncertainty.command)


def _shifted(normals: Array, at: tuple[float, float]) -> Array:
    flat = normals.reshape(-1, 3)
    moved: Array = shifts(flat, np.tile(at, (len(flat), 1))).reshape(normals.shape)
    return moved


def worst_loads(loads: Array, envs: Array) -> Array:
    """Return the loads (D, 6) among which the worst is, for all hands.

    z is concave in the load, so a mean of others need not be asked about. Nor need one that
    contact forces of the environment carry over into such a mean: what resists a disturbance of
    the mean resists it with these forces added. (A heavier object on a floor is one, at rest.)

    Args:
        loads: (D, 6).
        envs: (V, e, 6), the environment's columns in several cases.
    """
    kept = _distinct(loads)
    k = 0
    while k < len(kept) and len(kept) > 1:
        others = np.array(kept[:k] + kept[k + 1 :])
        if all(_covered(kept[k], others, env) for env in envs):
            del kept[k]
        else:
            k += 1
    return np.array(kept)


def _covered(load: Array, others: Array, env: Array) -> bool:
    """Whether the load plus some forces of the environment (e, 6) is a mean of others."""
    from scipy.optimize import nnls  # takes long to load

    weights = np.append(np.ones(len(others)), np.zeros(len(env)))
    matrix = np.vstack([np.hstack([others.T, -env.T]), weights])
    return bool(nnls(matrix, np.append(load, 1.0))[1] <= SAME)


def _distinct(arrays: Array | list[Array]) -> list[Array]:
    """Return arrays of one shape, those that equal an earlier one left out."""
    kept: list[Array] = []
    for array in arrays:
        if not any(np.abs(array - other).max(initial=0.0) <= SAME for other in kept):
            kept.append(array)
    return kept
