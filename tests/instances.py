"""Random instants of manipulation: the same generator tries the reference and the kernel.

Layouts are those that planning meets (a block on its face, edge or corner, against a wall, still
or sliding) and those that break solvers: symmetric, coincident and collinear contacts, no
friction, no gravity, limits that leave f_com a thin range, any unit of length and force.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.pose import rotation_about

SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
FRICTIONS = (0.0, 0.15, 0.5, 0.7, 1.2)


def random_instance(rng: np.random.Generator, fingers: int | None = None) -> Instant:
    """Return a random instant with 0 to 5 fingers, or the given number."""
    n = int(rng.choice(6, p=[0.08, 0.22, 0.4, 0.2, 0.06, 0.04])) if fingers is None else fingers
    half = 10.0 ** rng.uniform(-3, 3) * rng.choice([0.5, 1.0, 1.0, 2.0], size=3)
    if rng.random() < 0.3:
        half *= rng.uniform(0.5, 1.5, size=3)
    force = 10.0 ** rng.uniform(-3, 4)
    mass = 10.0 ** rng.uniform(-2, 2)
    points, normals = _fingertips(rng, half, n)
    gravity = 0.0 if rng.random() < 0.05 else force / mass
    return Instant(
        contacts=random_contacts(rng, half),
        points=points,
        normals=normals,
        friction=_frictions(rng, n),
        max_normal_force=force * _limits(rng, n),
        environment_friction=float(_frictions(rng, 1)[0]),
        mass=mass,
        inertia=_inertia(rng, half, mass),
        gravity=gravity,
        cone_edges=int(rng.choice([3, 4, 5, 6, 6, 6, 6, 7, 8, 12])),
    )


def softened(rng: np.random.Generator, instant: Instant) -> Instant:
    """Return the instant with soft fingertips: all alike, each its own, or some of them points."""
    n, size = len(instant.points), float(np.linalg.norm(instant.points, axis=1).max(initial=1e-9))
    soft = size * 10.0 ** rng.uniform(-4, 0, size=n)
    kind = rng.random()
    if kind < 0.5:
        soft[:] = soft[:1]
    elif kind < 0.75:
        soft[rng.random(n) < 0.5] = 0.0
    return dataclasses.replace(instant, soft=soft)


def random_contacts(rng: np.random.Generator, half: Array) -> ContactState:
    """Return random environment contacts of a box with the given half sides (3,)."""
    kinds: dict[str, Callable[[np.random.Generator, Array], ContactState]] = {
        "face": _on_face, "edge": _on_edge, "corner": _on_corner, "wall": _against_wall,
        "patch": _on_patch, "none": _in_the_air, "wedge": _wedged,
    }  # fmt: skip
    kind = rng.choice(list(kinds), p=[0.35, 0.25, 0.05, 0.15, 0.1, 0.05, 0.05])
    return kinds[str(kind)](rng, half)


def in_other_axes(instant: Instant, turn: Array) -> Instant:
    """Return the same instant in an object frame whose axes are turned by ``turn`` (3, 3).

    Object vectors v become ``turn @ v``; the world stays, gravity with it. The fingers' cones
    turn with the object's axes unless ``turn`` maps their edges onto themselves.
    """
    c = instant.contacts
    contacts = ContactState(
        c.points @ turn.T, c.normals @ turn.T, c.slip @ turn.T, c.rotation @ turn.T
    )
    return Instant(
        contacts, instant.points @ turn.T, instant.normals @ turn.T, instant.friction,
        instant.max_normal_force, instant.environment_friction, instant.mass,
        turn @ instant.inertia @ turn.T, instant.gravity, instant.cone_edges, instant.soft,
    )  # fmt: skip


def rescaled(instant: Instant, length: float = 1.0, force: float = 1.0) -> Instant:
    """Return the same instant in other units: lengths and forces are multiplied."""
    c = instant.contacts
    contacts = ContactState(c.points * length, c.normals, c.slip, c.rotation)
    return Instant(
        contacts, instant.points * length, instant.normals, instant.friction,
        instant.max_normal_force * force, instant.environment_friction, instant.mass,
        instant.inertia * length**2, instant.gravity * force, instant.cone_edges,
        instant.soft * length,
    )  # fmt: skip


def _frictions(rng: np.random.Generator, count: int) -> Array:
    if rng.random() < 0.6:
        return np.full(count, rng.choice(FRICTIONS, p=[0.05, 0.15, 0.3, 0.3, 0.2]))
    return rng.uniform(0.05, 1.5, size=count)


def _limits(rng: np.random.Generator, count: int) -> Array:
    """Limits against the object's weight: ample, scarce, just enough, none."""
    kind = rng.random()
    if kind < 0.5:
        return np.full(count, rng.choice([0.5, 1.0, 2.0, 10.0]))
    if kind < 0.8:
        return 10.0 ** rng.uniform(-1, 1, size=count)
    if kind < 0.95:
        exact = rng.choice(FRICTIONS[1:], size=count)
        return exact * (1.0 + rng.choice([0.0, 1e-6, 1e-3, 1e-2], size=count))
    limits = 10.0 ** rng.uniform(-2, 2, size=count)
    limits[rng.random(count) < 0.3] = 0.0
    return limits


def _inertia(rng: np.random.Generator, half: Array, mass: float) -> Array:
    square = half**2
    uniform: Array = mass / 3.0 * np.diag(square.sum() - square)
    if rng.random() < 0.7:
        return uniform
    turn = _rotation(rng)
    turned: Array = turn @ (uniform * rng.uniform(0.8, 1.2)) @ turn.T
    return (turned + turned.T) / 2.0


def _fingertips(rng: np.random.Generator, half: Array, count: int) -> tuple[Array, Array]:
    """Points on the box's faces and normals into it: on a grid, anywhere, or degenerate."""
    axis = rng.integers(3, size=count)
    side = rng.choice([-1.0, 1.0], size=count)
    kind = rng.random()
    if kind < 0.5:
        m = int(rng.choice([1, 2, 3, 5, 7]))
        inside = (2.0 * rng.integers(m, size=(count, 3)) + 1.0) / m - 1.0
    elif kind < 0.8:
        inside = rng.uniform(-1, 1, size=(count, 3))
    else:  # on the faces' centres, edges and corners; often twice the same
        inside = rng.choice([-1.0, 0.0, 1.0], size=(count, 3))
    if count > 1 and rng.random() < 0.3:  # an opposed pair
        axis[1], side[1], inside[1] = axis[0], -side[0], inside[0]
    inside[np.arange(count), axis] = side
    normals = np.zeros((count, 3))
    normals[np.arange(count), axis] = -side
    return inside * half, normals


def _rotation(rng: np.random.Generator) -> Array:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    turn: Array = q if np.linalg.det(q) > 0 else q[:, [1, 0, 2]]
    return turn


def _flat(rng: np.random.Generator) -> Array:
    """An orientation with one face down: any of 24, at times turned about the vertical."""
    turn: Array = np.eye(3)[rng.permutation(3)] * rng.choice([-1.0, 1.0], size=(3, 1))
    if np.linalg.det(turn) < 0:
        turn[:, 0] *= -1.0
    if rng.random() < 0.3:
        turn = rotation_about([0, 0, 1], rng.uniform(-np.pi, np.pi)) @ turn
    return turn


def _standing(
    rng: np.random.Generator, half: Array, rotation: Array, points: Array
) -> ContactState:
    """Contacts at object ``points`` with a horizontal floor, at rest or sliding on it."""
    arms = points @ rotation.T  # world frame, from the centre of mass
    kind = rng.random()
    v = np.zeros_like(arms)
    if kind < 0.25:
        v[:] = np.append(np.eye(2)[rng.integers(2)] * rng.choice([-1.0, 1.0]), 0.0)
    elif kind < 0.45:
        angle = rng.uniform(-np.pi, np.pi)
        v[:] = [np.cos(angle), np.sin(angle), 0.0]
    elif kind < 0.6:  # turning about a vertical axis; one point may be that axis
        pivot = arms[0] if rng.random() < 0.5 else half.max() * rng.normal(size=3)
        v = np.cross([0.0, 0.0, 1.0], arms - pivot)
    speed = np.linalg.norm(v, axis=1, keepdims=True)
    moves = speed > 1e-9 * half.max()
    slip = np.where(moves, v / np.where(moves, speed, 1.0), 0.0) @ rotation
    up = np.tile(rotation[2], (len(points), 1))
    return ContactState(points, up, slip, rotation)


def _lowest(half: Array, rotation: Array) -> Array:
    corners = SIGNS * half
    height = corners @ rotation[2]
    low: Array = corners[height < height.min() + 1e-9 * half.max()]
    return low


def _on_face(rng: np.random.Generator, half: Array) -> ContactState:
    rotation = _flat(rng)
    return _standing(rng, half, rotation, _lowest(half, rotation))


def _on_edge(rng: np.random.Generator, half: Array) -> ContactState:
    base = np.eye(3)[:, np.roll(np.arange(3), rng.integers(3))]
    angle = np.deg2rad(rng.choice([3.0, 30.0, 45.0, 60.0, 87.0, rng.uniform(1, 89)]))
    rotation = rotation_about([1, 0, 0], rng.choice([-1.0, 1.0]) * angle) @ base
    if rng.random() < 0.3:
        rotation = rotation_about([0, 0, 1], rng.uniform(-np.pi, np.pi)) @ rotation
    return _standing(rng, half, rotation, _lowest(half, rotation))


def _on_corner(rng: np.random.Generator, half: Array) -> ContactState:
    rotation = _rotation(rng)
    return _standing(rng, half, rotation, _lowest(half, rotation))


def _on_patch(rng: np.random.Generator, half: Array) -> ContactState:
    """A polygon of 1 to 9 contacts under the box."""
    rotation = _flat(rng)
    floor = _lowest(half, rotation)
    angle = np.sort(rng.uniform(0, 2 * np.pi, size=int(rng.integers(1, 10))))
    weights = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.01, 0.5)
    sides = np.array([floor[1] - floor[0], floor[2] - floor[0]])
    return _standing(rng, half, rotation, floor.mean(axis=0) + weights @ sides)


def _against_wall(rng: np.random.Generator, half: Array) -> ContactState:
    """On the floor and touching a vertical wall; still, or sliding along the wall."""
    rotation = np.eye(3) if rng.random() < 0.5 else rotation_about([0, 0, 1], np.pi / 2)
    corners = SIGNS * half
    outward = rotation.T @ np.array([1.0, 0.0, 0.0])
    reach = corners @ outward
    at_wall = corners[reach > reach.max() - 1e-9 * half.max()]
    floor = _lowest(half, rotation)
    points = np.concatenate([floor, at_wall])
    normals = np.concatenate([
        np.tile(rotation[2], (len(floor), 1)), np.tile(-outward, (len(at_wall), 1))
    ])  # fmt: skip
    along = rotation.T @ np.array([0.0, rng.choice([-1.0, 0.0, 1.0]), 0.0])
    return ContactState(points, normals, np.tile(along, (len(points), 1)), rotation)


def _in_the_air(rng: np.random.Generator, half: Array) -> ContactState:
    none = np.zeros((0, len(half)))
    return ContactState(none, none, none, _flat(rng))


def _wedged(rng: np.random.Generator, half: Array) -> ContactState:
    """Contacts on several faces, normals inward: they may squeeze the object by themselves."""
    points, normals = _fingertips(rng, half, int(rng.integers(2, 6)))
    return ContactState(points, normals, np.zeros_like(points), _rotation(rng))
