"""Random points of the faces on which fingers may be placed."""

from __future__ import annotations

from typing import Final

import numpy as np

from gm_ompl.geometry.patches import Patch
from gm_ompl.holds.spots import Spot, Spots

BEYOND: Final = 1.25
"""Points are drawn in a rectangle larger than the face's by this factor and moved onto it: many
fingers do best at the rim."""

TRIES: Final = 4
"""Points drawn per point wanted, at most: a face need not fill its rectangle."""


def drawn(spots: Spots, count: int, rng: np.random.Generator) -> list[Spot]:
    """Return so many random spots, as many on each face, fewer where a face offers little room.

    Args:
        spots: where fingers may be placed.
        count: in all; each face gets one at least.
        rng: the source of randomness.
    """
    each = max(1, -(-count // max(len(spots.patches), 1)))
    return [spot for f, patch in enumerate(spots.patches) for spot in _on(f, patch, each, rng)]


def _on(f: int, patch: Patch, count: int, rng: np.random.Generator) -> list[Spot]:
    half = patch.rectangle.half
    places = rng.uniform(-BEYOND * half, BEYOND * half, size=(TRIES * count, len(half)))
    points = patch.points(np.clip(places, -half, half))
    kept = points[patch.offers(points)][:count]
    return [(f, (x, y, z)) for x, y, z in kept.tolist()]
