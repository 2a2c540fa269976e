"""Swept tests: dense samples as a second opinion, contacts that are kept, walls between samples."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.geometry.swept import SweptScene

SAMPLES = 2000
NARROW = 1e-4
"""A clearance at every sample with which a motion must be let through."""


def _piece(rng: np.random.Generator, size: float) -> ConvexPiece:
    half = rng.uniform(0.1, 1.0, 3) * size
    if rng.random() < 0.5:
        return box(-half, half)
    return hull(rng.normal(size=(int(rng.integers(6, 12)), 3)) * half)


def _moved(piece: ConvexPiece, pose: Pose) -> ConvexPiece:
    return hull(pose.apply(piece.vertices))


def _pose(rng: np.random.Generator, spread: float) -> Pose:
    return Pose(rotation_about(rng.normal(size=3), rng.uniform(0, 3)), rng.normal(size=3) * spread)


def _sweep(rng: np.random.Generator, kind: str) -> Sweep:
    start, zero, up = _pose(rng, 1.0), np.zeros(3), np.array([0.0, 0.0, 1.0])
    if kind == "translation":
        return Sweep(start, start.position, up, 0.0, rng.normal(size=3) * 1.5)
    if kind == "rotation":
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        return Sweep(start, rng.normal(size=3), axis, rng.uniform(-2.0, 2.0), zero)
    drift = np.append(rng.normal(size=2), 0.0)
    return Sweep(start, start.position, up, rng.uniform(-2.0, 2.0), drift)


def _shrunk(piece: ConvexPiece, by: float) -> ConvexPiece:
    middle = piece.vertices.mean(axis=0)
    depth = (piece.face_offsets - piece.face_normals @ middle).min()
    return hull(middle + (1.0 + by / depth) * (piece.vertices - middle))


@pytest.mark.parametrize("kind", ["translation", "rotation", "both"])
def test_the_object_against_dense_samples(kind: str) -> None:
    """Free means that no sample penetrates; one that does means refused; nothing clear is refused.

    Clear means: at every sample, with the obstacle grown by 1e-4.
    """
    rng = np.random.default_rng(5)
    refused = free = 0
    for _ in range(120):
        body, other = Body((_piece(rng, 1.0),)), _moved(_piece(rng, 1.0), _pose(rng, 1.0))
        sweep = _sweep(rng, kind)
        ours = SweptScene(body, [Body((other,))], floor=False).object_free(sweep)
        scene = Scene(body, [Body((other,))], floor=False)
        times = np.linspace(0.0, 1.0, SAMPLES if ours else SAMPLES // 4)
        sampled = all(scene.object_free(sweep.pose(t)) for t in times)
        if ours:
            assert sampled
            free += 1
        elif sampled:
            grown = Scene(body, [Body((_shrunk(other, NARROW),))], floor=False)
            assert not all(grown.object_free(sweep.pose(t)) for t in times)
        else:
            refused += 1
    assert free > 20 and refused > 20


@pytest.mark.parametrize("kind", ["translation", "rotation", "both"])
def test_fingertips_against_dense_samples(kind: str) -> None:
    """Likewise for fingertips, whose distance from the obstacle is tried at every sample."""
    rng = np.random.default_rng(6)
    body = Body((box([-0.3, -0.3, -0.3], [0.3, 0.3, 0.3]),))
    none = np.zeros(40, dtype=np.int64)
    seen = np.zeros(2, dtype=int)
    for _ in range(25):
        other = _moved(_piece(rng, 1.0), _pose(rng, 1.0))
        sweep, radius = _sweep(rng, kind), float(rng.uniform(0.0, 0.3))
        centres = rng.normal(size=(40, 3))
        ours = SweptScene(body, [Body((other,))], True).free_placements(sweep, centres, radius)
        scene = Scene(body, [Body((other,))], True)
        poses = [sweep.pose(t) for t in np.linspace(0.0, 1.0, SAMPLES // 4)]
        sampled = np.array([scene.free_placements(p, centres, radius, none) for p in poses]).all(
            axis=0
        )
        wide = np.array(
            [scene.free_placements(p, centres, radius + NARROW, none) for p in poses]
        ).all(axis=0)
        assert not (ours & ~sampled).any()
        assert not (wide & ~ours).any()
        seen += [int(ours.sum()), int((~ours).sum())]
    assert (seen > 200).all()
