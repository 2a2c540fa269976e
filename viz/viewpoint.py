"""From where to look at a plan."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, unit

from .story import Story


def viewpoint(story: Story, elevation: float = 24.0) -> Array:
    """Return the unit vector (3,) towards the viewer.

    Of sixteen directions round the vertical: the one with fewest obstacles in front of the
    object, and of these the one that sees the motion most from its side.
    """
    first, last = (story.beats[k].poses[k][:3] if story.beats else np.zeros(3) for k in (0, -1))
    travel = last - first
    heading = np.arctan2(travel[1], travel[0]) if np.hypot(*travel[:2]) > 0 else 0.0
    middle = 0.5 * (first + last) if story.beats else story.rest_pose()[:3]
    side = heading - np.pi / 2 + np.deg2rad(28.0)  # a little from ahead: three faces are seen
    best, least = unit([1.0, -1.0, 1.0]), np.inf
    for k in range(16):
        azimuth = side + k * np.pi / 8
        up = np.deg2rad(elevation)
        direction = np.array(
            [np.cos(up) * np.cos(azimuth), np.cos(up) * np.sin(azimuth), np.sin(up)]
        )
        turned = min(k, 16 - k) / 16
        hidden = _hiding(story, middle, direction)
        if hidden + turned < least:
            best, least = direction, hidden + turned
    return best


def _hiding(story: Story, middle: Array, direction: Array) -> int:
    """Return how many obstacle pieces stand between the viewer and ``middle``."""
    steps = np.linspace(0.0, 4.0 * story.problem.body.diagonal, 60)[:, None]
    ray = middle + steps * direction
    return sum(
        bool((ray @ piece.face_normals.T < piece.face_offsets).all(axis=1).any())
        for obstacle in story.problem.environment.obstacles
        for piece in obstacle.body.pieces
    )
