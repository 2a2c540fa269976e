"""Where the object stays off everything, wherever it is near a pose."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import PlacedPiece, gap
from gm_ompl.geometry.solids import Body, ConvexPiece, box

RandomHull = Callable[[np.random.Generator, float], ConvexPiece]
SIZES = [1e-3, 1.0, 1e3]


@pytest.mark.parametrize("size", SIZES)
def test_what_stays_clear_stays_clear(size: float, random_hull: RandomHull) -> None:
    """No pose near the given one, as near as it was said, overlaps anything; said as far as can be.

    Bodies of two pieces are moved along the worst direction, and turned about their middle.
    """
    rng, clear = np.random.default_rng(15), 0
    for _ in range(30):
        body = Body((random_hull(rng, 0.2 * size), random_hull(rng, 0.2 * size)))
        obstacles = [
            Body((random_hull(rng, 0.3 * size),)),
            Body((box([2 * size] * 3, [3 * size] * 3),)),
        ]
        floor = bool(rng.random() < 0.5)
        scene = Scene(body, obstacles, floor)
        place = rng.normal(size=3)
        place *= rng.uniform(0.7, 2.0) * size / np.linalg.norm(place)
        pose = Pose.from_quaternion(np.abs(place) if floor else place, rng.normal(size=4))
        arm = float(np.linalg.norm(body.vertices, axis=1).max())
        most = _longest_clear(scene, pose, angle := rng.uniform(0.0, 0.2), arm, size)
        if most is None:
            continue
        clear += 1
        for _ in range(20):
            axis = rng.normal(size=3)
            turned = pose.turned(pose.position, axis / np.linalg.norm(axis), angle)
            for by in (rng.uniform(-1, 1, 3), rng.choice([-1.0, 1.0], 3)):
                assert _apart(
                    body, Pose(turned.rotation, pose.position + most * by), obstacles, floor
                )
    assert clear > 8


def _longest_clear(scene: Scene, pose: Pose, angle: float, arm: float, size: float) -> float | None:
    """The longest shift along all axes, beside a turn, about which it says that it stays clear."""
    low, high = 0.0, 4.0 * size
    if not scene.stays_clear(pose, np.full(3, angle * arm)):
        return None
    for _ in range(30):
        middle = (low + high) / 2.0
        clear = scene.stays_clear(pose, np.full(3, middle + angle * arm))
        low, high = (middle, high) if clear else (low, middle)
    return low


def _apart(body: Body, pose: Pose, obstacles: list[Body], floor: bool) -> bool:
    """Whether nothing overlaps, by all separating axes."""
    pieces = [PlacedPiece(piece, pose) for piece in body.pieces]
    fixed = [PlacedPiece(piece) for other in obstacles for piece in other.pieces]
    if floor and min(piece.bounds[0][2] for piece in pieces) < 0.0:
        return False
    return all(gap(a, b).width > 0.0 for a in pieces for b in fixed)


def test_along_one_axis_it_is_exact() -> None:
    """A cube over the floor and beside a wall may go just as far as they are, along each alone."""
    wall = Body((box([2, -5, -5], [3, 5, 5]),))
    scene = Scene(Body((box([-0.5] * 3, [0.5] * 3),)), [wall], floor=True)
    pose = Pose(np.eye(3), np.array([0.5, 0.0, 1.5]))
    for axis, most in ((0, 1.0), (1, 1e3), (2, 1.0)):
        for shift, clear in ((0.999 * most, True), (1.001 * most, axis == 1)):
            assert scene.stays_clear(pose, shift * np.eye(3)[axis]) == clear
