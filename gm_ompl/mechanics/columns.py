"""The columns of Problems (5) and (6): R^(1/2) W C and R^(1/2) Q_known, forces over force_scale.

Everything here is in the norm (7): a wrench Q stands as U Q, with U the upper Cholesky factor of
R of Eq. (8), which also makes lengths dimensionless.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gm_ompl.arrays import Array, cross, read_only
from gm_ompl.contact.state import ContactState


def wrench_norm(mass: float, inertia: Array) -> Array:
    """Return U (6, 6) with U^T U = R of Eq. (8), so that |U Q| is the norm (7)."""
    R = np.eye(6)
    R[3:, 3:] = mass * np.linalg.inv(inertia)
    upper: Array = np.asarray(np.linalg.cholesky(0.5 * (R + R.T)).T, dtype=np.float64)
    return upper


def cone_axes(normals: Array, reference: Array) -> Array:
    """Return each friction cone's own axes as rows (n, 3, 3): the normal and two tangents.

    Args:
        normals: (n, 3), unit, into the object.
        reference: (2, 3), the reference axis and the one used where the normal is within
            |n . axis| >= 0.9 of it.
    """
    near = np.abs(normals @ reference[0]) >= 0.9
    axis = np.where(near[:, None], reference[1], reference[0])
    t1 = axis - (axis * normals).sum(axis=1, keepdims=True) * normals
    t1 /= np.sqrt((t1 * t1).sum(axis=1, keepdims=True))
    axes = np.empty((len(normals), 3, 3))
    axes[:, 0], axes[:, 1], axes[:, 2] = normals, t1, cross(normals, t1)
    return axes


@lru_cache(maxsize=256)
def edge_weights(friction: float, s: int) -> Array:
    """Return the s unit edges of a cone in its own axes, shape (s, 3), read-only."""
    theta = 2.0 * np.pi * np.arange(s) / s
    edges = np.stack([np.ones(s), friction * np.cos(theta), friction * np.sin(theta)], axis=1)
    return read_only(edges / np.sqrt(1.0 + friction**2), (s, 3), "edges")


def wrenches(points: Array, forces: Array, U: Array) -> Array:
    """Return U [f; p x f] for forces (..., 3) at points (..., 3), shape (..., 6)."""
    moments = cross(points, forces)
    scaled: Array = np.concatenate([forces, moments], axis=-1) @ U.T
    return scaled


def environment_columns(contacts: ContactState, friction: Array | float, s: int, U: Array) -> Array:
    """Return R^(1/2) W_env C_env as rows, shape (columns, 6): s per static contact, 1 per sliding.

    The cones' reference axes are the world's x and y. ``friction`` is one coefficient for all
    contacts, or (m,).
    """
    m = len(contacts.points)
    if m == 0:
        return np.zeros((0, 6))
    axes = wrenches(contacts.points[:, None], cone_axes(contacts.normals, contacts.rotation[:2]), U)
    if isinstance(friction, float):
        static = edge_weights(friction, s) @ axes
    else:
        static = np.array([edge_weights(mu, s) for mu in friction.tolist()]) @ axes
        friction = friction[:, None]
    slides = np.abs(contacts.slip).sum(axis=1) > 0
    if not slides.any():
        return np.ascontiguousarray(static.reshape(-1, 6))
    opposite = contacts.normals - friction * contacts.slip
    opposite = opposite / np.linalg.norm(opposite, axis=1, keepdims=True)
    sliding = wrenches(contacts.points, opposite, U)
    return np.concatenate([sliding[i : i + 1] if slides[i] else static[i] for i in range(m)])


def fingertip_columns(points: Array, normals: Array, friction: float, s: int, U: Array) -> Array:
    """Return R^(1/2) W_rob C_rob per placement for unit normal force, shape (P, s, 6).

    Edges are scaled so that the normal component of each is 1: coefficients are then the normal
    forces themselves. The cones' reference axes are the object's x and y.
    """
    axes = wrenches(points[:, None], cone_axes(normals, np.eye(3)[:2]), U)
    return np.ascontiguousarray(edge_weights(friction, s) * np.sqrt(1.0 + friction**2) @ axes)


def twisting_columns(points: Array, normals: Array, moment: float, U: Array) -> Array:
    """Return what a soft fingertip has besides its edges, shape (P, 2, 6), U applied.

    Unit normal force with plus and minus ``moment`` (mu L) about the normal.
    """
    arms = cross(points, normals)
    twists = [np.concatenate([normals, arms + m * normals], axis=1) for m in (moment, -moment)]
    both: Array = np.stack(twists, axis=1) @ U.T
    return both


def hand_columns(
    points: Array, normals: Array, friction: Array, soft: Array, s: int, U: Array
) -> Array:
    """Return the columns of all fingers at their placements, (n, P, s, 6), or (n, P, s + 2, 6).

    Args:
        points: (n, P, 3), each finger's placements.
        normals: (n, P, 3), unit, into the object.
        friction: (n,), Coulomb coefficients.
        soft: (n,), lengths L. Where any is positive all fingers have two more columns: those of a
            point beside soft ones are its plain normal force, which its cone contains.
        s: edges per cone.
        U: (6, 6), see ``wrench_norm``.
    """
    n, P = points.shape[:2]
    edges = [fingertip_columns(points[i], normals[i], friction[i], s, U) for i in range(n)]
    if not soft.any():
        return np.array(edges).reshape(n, P, s, 6)
    moments = friction * soft
    twists = [twisting_columns(points[i], normals[i], moments[i], U) for i in range(n)]
    return np.concatenate([np.array(edges), np.array(twists)], axis=2)


def load(rotation: Array, weight: float, U: Array) -> Array:
    """Return U Q_known (6,) for gravity: ``weight`` (over force_scale) along the world's -z."""
    Q_known = np.zeros(6)
    Q_known[:3] = -weight * rotation[2]
    scaled: Array = U @ Q_known
    return scaled


def directions() -> Array:
    """Return the 76 directions l_i of Sec. 5, shape (76, 6).

    The order is +k e_1, -k e_1, ..., -k e_6, then the corners, (+, ..., +) first and the last
    coordinate's sign changing fastest.
    """
    k = 2.0 * np.sqrt(3.0 - np.sqrt(6.0))
    axes = np.zeros((12, 6))
    for j in range(6):
        axes[2 * j, j], axes[2 * j + 1, j] = k, -k
    bits = (np.arange(64)[:, None] >> np.arange(5, -1, -1)) & 1
    corners = (k / np.sqrt(6.0)) * (1.0 - 2.0 * bits)
    return np.concatenate([axes, corners])
