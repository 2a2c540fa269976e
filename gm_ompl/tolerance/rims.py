"""How far a fingertip's contact may be shifted before it leaves its face."""

from __future__ import annotations

import math

import numpy as np

from gm_ompl.arrays import Array, cross
from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.surface import Face, faces_of
from gm_ompl.planfile.model import PlacementRecord, Spot
from gm_ompl.uncertainty.worlds import shifts

PARALLEL = 1e-12  # an edge that runs along the shift, but for this part of its length, is not met


class Rims:
    """The faces of an object, and the ways to their rims met so far."""

    def __init__(self, body: Body) -> None:
        self._faces: dict[str, Face] = dict(faces_of(body))
        self._known: dict[Spot, Array] = {}

    def room(self, placement: PlacementRecord) -> Array:
        """Return how far the contact may go along both tangents, (2, 2): backward, forward."""
        key = placement.spot
        if key not in self._known:
            normal = np.array([placement.normal])
            tangents = [shifts(normal, np.array([along]))[0] for along in ((1.0, 0.0), (0.0, 1.0))]
            point = np.array(placement.point)
            face = self._faces.get(placement.face)
            self._known[key] = np.array([
                [to_rim(face, point, sign * t) for sign in (-1.0, 1.0)] for t in tangents
            ])  # fmt: skip
        return self._known[key]


def to_rim(face: Face | None, point: Array, along: Array) -> float:
    """Return how far it is from a point of a face to its rim in a unit direction of its plane."""
    if face is None:
        return math.inf
    beside = cross(face.normal, along)
    nearest = math.inf
    for tail, head in face.region.rim:
        a, b = float((tail - point) @ beside), float((head - point) @ beside)
        if abs(a - b) <= PARALLEL * float(np.linalg.norm(head - tail)) or a * b > 0.0:
            continue
        way = float((tail + (a / (a - b)) * (head - tail) - point) @ along)
        if way >= 0.0:
            nearest = min(nearest, way)
    return nearest
