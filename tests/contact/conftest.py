"""Touching pairs of random pieces, and the library that gives a second opinion."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.geometry.polygon import plane_basis
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import ConvexPiece, box, hull


@pytest.fixture(scope="session")
def coal() -> ModuleType:
    """Return the coal library; without it skip, in CI fail."""
    try:
        return importlib.import_module("coal")
    except ImportError:
        if os.environ.get("CI") == "true":
            pytest.fail("coal is not installed: the second opinion on contact patches is missing")
        pytest.skip("coal is not installed (extra: dev); no second opinion on contact patches")


@dataclass(frozen=True)
class Touching:
    """A piece ``upper`` at a pose touching the piece ``lower`` at another; normal: into upper."""

    upper: ConvexPiece
    pose: Pose
    lower: ConvexPiece
    base: Pose
    normal: Array


def random_piece(rng: np.random.Generator, size: float) -> ConvexPiece:
    if rng.random() < 0.5:
        half = rng.uniform(0.4, 1.5, size=3) * size
        return box(-half, half)
    return hull(rng.normal(size=(12, 3)) * size)


def support(rng: np.random.Generator, piece: ConvexPiece, kind: str) -> tuple[Array, Array]:
    """Return a point in a random face, edge or corner and the direction it supports."""
    face = piece.faces[int(rng.integers(len(piece.faces)))]
    corners = {"face": face, "edge": face[:2], "vertex": face[:1]}[kind]
    meeting = [k for k, other in enumerate(piece.faces) if set(corners) <= set(other)]
    weights = rng.dirichlet(np.full(len(meeting), 4.0))
    direction = weights @ piece.face_normals[meeting]
    point = rng.dirichlet(np.full(len(corners), 2.0)) @ piece.vertices[list(corners)]
    return point, direction / np.linalg.norm(direction)


def make_touching(rng: np.random.Generator, kinds: str, size: float) -> Touching:
    upper_kind, lower_kind = kinds.split()
    upper, lower = random_piece(rng, size), random_piece(rng, 2 * size)
    p, d = support(rng, upper, upper_kind)
    q, n = support(rng, lower, lower_kind)
    angle = rng.uniform(0, 2 * np.pi)
    c, s = np.cos(angle), np.sin(angle)
    spin = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    onto = np.vstack([plane_basis(n), n]).T
    down = np.vstack([plane_basis(-d), -d]).T
    rotation = onto @ spin @ down.T
    world = Pose.from_quaternion(rng.normal(size=3) * 3 * size, rng.normal(size=4))
    pose = Pose(world.rotation @ rotation, world.apply(q - rotation @ p))
    return Touching(upper, pose, lower, world, world.rotation @ n)


@pytest.fixture(scope="session")
def touching() -> Callable[[np.random.Generator, str, float], Touching]:
    """Return a maker of touching pairs: (rng, kinds, size).

    ``kinds`` names upper's and lower's feature, each "face", "edge" or "vertex", such as
    "edge face".
    """
    return make_touching
