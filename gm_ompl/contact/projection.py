"""A pose brought onto what it touches within the contact tolerance, so that its contacts are exact.

Of all poses near by that keep the contacts it is the nearest in the norm (7): the displacement d is
measured by |v|^2 + w . (J / M) w, v that of the centre of mass, w the turn.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gm_ompl.arrays import Array, cross
from gm_ompl.contact.environment import UP, Environment
from gm_ompl.contact.patch import ContactPatch, contact_patch
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import PlacedPiece
from gm_ompl.geometry.solids import Body

ROUNDING = 1e-12
"""Gaps of at most this, relative to D and the coordinates, are none: the pose stays as it is."""

CONVERGED = 1e-15
"""A step that moves no vertex by more than this, relative to D, is the last."""

MOST_STEPS = 20
"""Newton's method takes two or three."""

FARTHEST = 4.0
"""A way of closing gaps that moves a vertex by more than so many contact tolerances is no rounding
of the pose: the gaps that it would close stay."""

STEEP = 0.05
"""A face whose plane meets the line along a contact's normal at a smaller sine is left aside."""

ANY_WAY = np.eye(6)
"""The object may move and turn in every way."""

UPRIGHT_WAYS = np.eye(6)[[2, 3, 4]]
"""It may rise and tilt."""


def projected(
    body: Body, environment: Environment, pose: Pose, spread: Array, ways: Array = ANY_WAY
) -> Pose:
    """Return the pose nearest to ``pose`` whose gaps are zero, to rounding.

    Gaps that cannot all be zero at once (a face's corners that lie in no plane) are made least in
    the sum of their squares: none then exceeds what it was by more than the others did.

    Args:
        body: the object, object frame.
        environment: what it can touch.
        pose: where it is.
        spread: (3, 3), J / M about the centre of mass, object frame.
        ways: (k, 6), unit displacements and turns, world frame, that are allowed.
    """
    D = body.diagonal
    farthest = FARTHEST * environment.contact_tolerance * D
    level = ROUNDING * max(D, float(np.abs(pose.apply(body.vertices)).max()))
    for _ in range(MOST_STEPS):
        points, normals, gaps = _gaps(body, environment, pose)
        if not len(gaps) or np.abs(gaps).max() <= level:
            break
        arms = points - pose.position
        rates = np.concatenate([normals, cross(arms, normals)], axis=1)
        corners = body.vertices @ pose.rotation.T
        metric = np.eye(6)  # of the norm of displacements, world frame
        metric[3:, 3:] = pose.rotation @ spread @ pose.rotation.T
        step = _step(rates, gaps, metric, ways, (corners, farthest))
        angle = float(np.linalg.norm(step[3:]))
        turned = pose.turned(pose.position, step[3:], angle) if angle > 0.0 else pose
        pose = Pose(turned.rotation, turned.position + step[:3])
        if _motion(corners, step) <= CONVERGED * D:
            break
    return pose


def _step(
    rates: Array, gaps: Array, metric: Array, ways: Array, limit: tuple[Array, float]
) -> Array:
    """Return the shortest displacement (6,) that closes the gaps (m,), linearised.

    The ways of closing gaps, singular vectors of ``rates`` (m, 6), are taken from the stiffest on.
    """
    corners, farthest = limit
    root = np.linalg.inv(np.linalg.cholesky(ways @ metric @ ways.T)).T
    basis = ways.T @ root
    of_gaps, stiffness, of_ways = np.linalg.svd(rates @ basis, full_matrices=False)
    step = np.zeros(6)
    for k in np.flatnonzero(stiffness > 1e-9 * stiffness[:1].max(initial=0.0)):
        part = basis @ of_ways[k] * (-(of_gaps[:, k] @ gaps) / stiffness[k])
        if _motion(corners, part) <= farthest:
            step += part
    return step


def _motion(corners: Array, step: Array) -> float:
    """Return how far a displacement moves the farthest of ``corners`` (v, 3)."""
    ways = step[:3] + cross(np.broadcast_to(step[3:], corners.shape), corners)
    return float(np.sqrt(np.einsum("ij,ij->i", ways, ways).max()))


def _gaps(body: Body, environment: Environment, pose: Pose) -> tuple[Array, Array, Array]:
    """Return points (m, 3), normals (m, 3) into the object and gaps (m,) of what it touches."""
    found = list(_touching(body, environment, pose))
    if not found:
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
    points, normals, gaps = (np.concatenate(part) for part in zip(*found, strict=True))
    return points, normals, gaps


def _touching(
    body: Body, environment: Environment, pose: Pose
) -> Iterator[tuple[Array, Array, Array]]:
    tolerance = environment.contact_tolerance * body.diagonal
    pieces = [PlacedPiece(piece, pose) for piece in body.pieces]
    if environment.floor:
        corners = pose.apply(body.vertices)
        feet = corners[np.abs(corners[:, 2]) <= tolerance]
        # What lies below the floor by more than the tolerance is no contact, here as there.
        if len(feet) and corners[:, 2].min() >= -tolerance:
            yield feet * [1.0, 1.0, 0.0], np.tile(UP, (len(feet), 1)), feet[:, 2]
    for obstacle in environment.obstacles:
        for other in map(PlacedPiece, obstacle.body.pieces):
            for piece in pieces:
                (low, high), (least, most) = piece.bounds, other.bounds
                if (low <= most + tolerance).all() and (least <= high + tolerance).all():
                    patch = contact_patch(piece, other, tolerance)
                    if patch is not None:
                        yield _widths(piece, other, patch, tolerance)


def _widths(
    piece: PlacedPiece, other: PlacedPiece, patch: ContactPatch, tolerance: float
) -> tuple[Array, Array, Array]:
    """Return points and normals of a patch of two pieces, and the gaps along the normal there."""
    points, normal = patch
    gaps = _depth(piece, points, normal) + _depth(other, points, -normal)
    # A point on the rim of a slanting face may miss it by the tolerance: its gap says nothing.
    known = np.abs(gaps) <= 2.0 * tolerance
    return points[known], np.tile(normal, (int(known.sum()), 1)), gaps[known]


def _depth(piece: PlacedPiece, points: Array, along: Array) -> Array:
    """Return how far the piece's surface is from ``points`` (k, 3) along a direction into it."""
    slopes = piece.normals @ along
    facing = slopes < -STEEP
    if not facing.any():
        return np.full(len(points), np.inf)
    heights = points @ piece.normals[facing].T - piece.offsets[facing]
    farthest: Array = (heights / -slopes[facing]).max(axis=1)
    return farthest
