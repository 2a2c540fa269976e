"""Random instants that break solvers: nearly parallel, coincident and badly scaled columns.

A block stands on a face or an edge, perhaps against a wall, and moves with one component of its
velocity a 1,000th to a 1,000,000,000,000th of another; contacts and fingertips come in pairs that
nearly coincide; lines of force nearly meet the centre of mass; units are anything.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.pose import rotation_about
from tests.instances import SIGNS

SPEED = 1e-9
"""Contacts slower than this against the fastest vertex are static (convention)."""


def degenerate_instance(rng: np.random.Generator) -> Instant:
    """Return a random degenerate instant with 0 to 5 fingers."""
    n = int(rng.choice(6, p=[0.05, 0.2, 0.45, 0.2, 0.06, 0.04]))
    half = 10.0 ** rng.uniform(-6, 6) * rng.choice([0.5, 1.0, 2.0], size=3)
    mass, weight = 10.0 ** rng.uniform(-3, 3), 10.0 ** rng.uniform(-6, 6)
    points, normals = _fingertips(rng, half, n)
    limits = rng.choice(
        [0.5, 1.0, 2.0, 10.0, 1e-3, 1e3], size=n, p=[0.2, 0.2, 0.3, 0.2, 0.05, 0.05]
    )
    inertia = mass / 3.0 * np.diag((half**2).sum() - half**2)
    return Instant(
        contacts=_contacts(rng, half),
        points=points,
        normals=normals,
        friction=_frictions(rng, n),
        max_normal_force=weight * (limits[:1].repeat(n) if n and rng.random() < 0.6 else limits),
        environment_friction=float(_frictions(rng, 1)[0]),
        mass=mass,
        inertia=inertia,
        gravity=0.0 if rng.random() < 0.05 else weight / mass,
        cone_edges=int(rng.choice([3, 4, 5, 6, 6, 6, 6, 8])),
    )


def tiny(rng: np.random.Generator) -> float:
    """Return +-10^-3 to +-10^-12, or 0."""
    return 0.0 if rng.random() < 0.15 else float(rng.choice([-1, 1]) * 10.0 ** rng.uniform(-12, -3))


def _frictions(rng: np.random.Generator, count: int) -> Array:
    values = rng.choice([0.1, 0.3, 0.5, 0.7, 1.2], size=count)
    if rng.random() < 0.1:
        values[rng.random(count) < 0.5] = abs(tiny(rng))
    return values if rng.random() < 0.4 else values[:1].repeat(count)


def _fingertips(rng: np.random.Generator, half: Array, n: int) -> tuple[Array, Array]:
    """Grid points of a box, some nearly coincident, opposed, or with no lever arm."""
    points, normals = np.zeros((n, 3)), np.zeros((n, 3))
    for i in range(n):
        axis, side = int(rng.integers(3)), rng.choice([-1.0, 1.0])
        at = (2.0 * rng.integers(5, size=3) + 1.0) / 5.0 - 1.0
        kind = rng.random()
        if i and kind < 0.25:  # beside an earlier one
            points[i], normals[i] = points[i - 1], normals[i - 1]
            points[i] += tiny(rng) * half * (1.0 - np.abs(normals[i])) * rng.normal(size=3)
            continue
        if i and kind < 0.4:  # nearly opposite
            at, axis = points[i - 1] / half, int(np.abs(normals[i - 1]).argmax())
            side = float(np.sign(normals[i - 1][axis]))
            at = at + tiny(rng) * rng.normal(size=3)
        elif kind < 0.6:  # nearly through the centre of mass
            at = tiny(rng) * rng.normal(size=3)
        points[i] = at * half
        points[i, axis] = side * half[axis]
        normals[i, axis] = -side
        if rng.random() < 0.15:  # a face that is nearly one of the box's
            normals[i] += tiny(rng) * rng.normal(size=3)
            normals[i] /= np.linalg.norm(normals[i])
    return points, normals


def _contacts(rng: np.random.Generator, half: Array) -> ContactState:
    base = np.eye(3)[:, np.roll(np.arange(3), rng.integers(3))]
    tilt = rng.choice([0.0, 0.0, 0.0, tiny(rng), np.pi / 4, rng.uniform(0, 1.5)])
    rotation = rotation_about([1, 0, 0], float(tilt)) @ base
    if rng.random() < 0.5:
        turn = rng.choice([tiny(rng), rng.uniform(-np.pi, np.pi)])
        rotation = rotation_about([0, 0, 1], float(turn)) @ rotation
    corners = SIGNS * half
    points, normals = _touching(rng, corners, rotation[2], half)
    if rng.random() < 0.25:  # a wall in the way, or along it
        side, wall = _touching(rng, corners, rotation[rng.integers(2)], half)
        points, normals = np.concatenate([points, side]), np.concatenate([normals, wall])
    if rng.random() < 0.3:  # contacts that nearly coincide
        twice = points + tiny(rng) * np.linalg.norm(half) * rng.normal(size=points.shape)
        points, normals = np.concatenate([points, twice]), np.concatenate([normals, normals])
    if rng.random() < 0.1:
        normals = normals + tiny(rng) * rng.normal(size=normals.shape)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    slip = _slip(rng, points, normals, rotation, corners)
    return ContactState(points, normals, slip, rotation)


def _touching(
    rng: np.random.Generator, corners: Array, normal: Array, half: Array
) -> tuple[Array, Array]:
    height = corners @ normal
    reach = 10.0 ** rng.choice([-9.0, -6.0, -3.0]) * float(np.linalg.norm(half))
    points = corners[height <= height.min() + reach]
    return points, np.tile(normal, (len(points), 1))


def _slip(
    rng: np.random.Generator, points: Array, normals: Array, rotation: Array, corners: Array
) -> Array:
    """Directions of sliding under a velocity whose components differ by orders of magnitude."""
    size = float(np.linalg.norm(corners[0]))
    linear, angular = np.zeros(3), np.zeros(3)
    kind = rng.random()
    if kind < 0.15:  # at rest
        return np.zeros_like(points)
    if kind < 0.7:  # almost a translation
        linear[:2] = [1.0, tiny(rng)]
        angular[2] = tiny(rng) / size
    elif kind < 0.85:  # almost a turn
        angular[2] = 1.0 / size
        linear[:2] = [tiny(rng), tiny(rng)]
        if rng.random() < 0.5:
            linear += np.cross(rotation @ points[0], angular)
    else:
        linear[:2], angular[2] = rng.normal(size=2), tiny(rng) / size
    v, w = linear @ rotation, angular @ rotation
    speeds = v + np.cross(w, points)
    speeds -= (speeds * normals).sum(axis=1, keepdims=True) * normals
    fastest = np.linalg.norm(v + np.cross(w, corners), axis=1).max()
    speed = np.linalg.norm(speeds, axis=1, keepdims=True)
    return np.where(speed > SPEED * fastest, speeds / np.where(speed > 0, speed, 1.0), 0.0)
