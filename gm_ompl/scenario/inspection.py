"""What is to know of a shape before it is planned with: ``gm-ompl inspect``."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gm_ompl.errors import ScenarioError
from gm_ompl.geometry.hulls import RestingPose, resting_poses
from gm_ompl.geometry.solids import Body, MassProperties, mass_properties, volume
from gm_ompl.geometry.surface import Face, faces_of, placements
from gm_ompl.reading import one_line
from gm_ompl.scenario.document import Document
from gm_ompl.scenario.hand import margin_of, offered_faces
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.scenario.shapes import body_of

GRID = (7, 7)
"""A face is offered where a placement of this grid lies on it, in no hole and under no piece."""

MESHES = (".stl", ".obj", ".ply", ".off", ".glb")


@dataclass(frozen=True, eq=False)
class Inspection:
    """What is to know of the object's shape.

    Attributes:
        scenario: with the shape as its object.
        body: the shape about its centre of mass.
        own: volume, centre and inertia in the shape's own coordinates, at the scenario's mass.
        rests: how it can lie.
        faces: its faces, numbered as placements name them.
        offered: names of the faces on which fingers may be placed.
    """

    scenario: Scenario
    body: Body
    own: MassProperties
    rests: tuple[RestingPose, ...]
    faces: tuple[tuple[str, Face], ...]
    offered: tuple[str, ...]

    @property
    def deviation(self) -> float:
        """The largest distance found between the surface used and the file's."""
        return self.scenario.model.object.shape.deviation or 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain values; lengths in the scenario's units."""
        corners, mass = self.body.vertices, self.scenario.problem.mass
        total = sum(volume(piece) for piece in self.body.pieces)
        return {
            "size": np.ptp(corners, axis=0).tolist(),
            "deviation": self.deviation,
            "mass": mass,
            "volume": self.own.volume,
            "centre_of_mass": self.own.centre.tolist(),
            "inertia": np.asarray(self.scenario.problem.inertia).tolist(),
            "resting_poses": [
                {
                    "down": pose.down.tolist(),
                    "height": pose.height,
                    "tilt_deg": float(np.rad2deg(pose.tilt)),
                    "corners": pose.corners,
                    "quaternion": pose.rotation.tolist(),
                }
                for pose in self.rests
            ],
            "pieces": [
                {
                    "corners": len(piece.vertices),
                    "faces": len(piece.faces),
                    "share": volume(piece) / total,
                }
                for piece in self.body.pieces
            ],
            "faces": [
                {
                    "name": name,
                    "normal": face.normal.tolist(),
                    "area": face.region.area,
                    "offered": name in self.offered,
                }
                for name, face in self.faces
            ],
        }


def inspect(name: str, overrides: Iterable[str] = ()) -> Inspection:
    """Return what is to know of the shape in a mesh file or of a scenario's object.

    Args:
        name: a mesh file, or what ``load`` takes.
        overrides: "KEY=VALUE"; for a mesh, keys that stand beside ``mesh:`` in a scenario.

    Raises:
        ScenarioError: no such file, or no usable shape in it.
    """
    scenario = _around(name, overrides) if name.lower().endswith(MESHES) else load(name, overrides)
    body = scenario.problem.body
    own = mass_properties(body_of(scenario.model.object.shape), scenario.model.object.mass)
    table = placements(
        body, GRID, offered_faces(scenario.model, body), margin_of(scenario.model, body)
    )
    offered = tuple(table.labels[k] for k in np.unique(table.face))
    return Inspection(scenario, body, own, resting_poses(body), tuple(faces_of(body)), offered)


def _around(name: str, overrides: Iterable[str]) -> Scenario:
    """Return a scenario with the mesh as its object, afloat, and no fingers."""
    path = Path(name)
    if not path.exists():
        raise ScenarioError(f"{one_line(name)}: no such file")
    tree = {
        "format": "gm-ompl-scenario/1",
        "name": path.name,
        "object": {"shape": {"mesh": path.name}, "mass": 1.0},
        "friction": {"environment": 0.5, "finger": 0.5},
        "gravity": 0.0,
        "fingers": {
            "count": 0, "radius": 1.0, "max_normal_force": 1.0, "placements": {"grid": [1, 1]},
        },
        "environment": {"floor": False},
        "motion": {
            "start": {"position": [0.0, 0.0, 0.0]}, "path": [{"slide": {"by": [1.0, 0.0, 0.0]}}],
        },
        "lattice": {"segments": 1},
    }  # fmt: skip
    document = Document(name, tree, folder=path.parent)
    return Scenario.from_document(document, [f"object.shape.{text}" for text in overrides])
