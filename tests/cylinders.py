"""Cylinders of many facets, to place fingers on."""

from __future__ import annotations

from typing import Any

import numpy as np

from gm_ompl.scenario.load import load


def cylinder(facets: int) -> dict[str, Any]:
    """Return a scenario in which two fingers slide a standing cylinder; a mesh of triangles."""
    angles = 2.0 * np.pi * (np.arange(facets) + 0.5) / facets
    ring = [[float(f"{3.0 * x:.6f}") for x in (np.cos(a), np.sin(a))] for a in angles]
    vertices = [[*p, z] for z in (-2.0, 2.0) for p in ring] + [[0, 0, -2.0], [0, 0, 2.0]]
    faces = []
    for i in range(facets):
        j = (i + 1) % facets
        faces += [[i, j, facets + j], [i, facets + j, facets + i]]
        faces += [[2 * facets, j, i], [2 * facets + 1, facets + i, facets + j]]
    return load({
        "format": "gm-ompl-scenario/1",
        "name": "cylinder",
        "object": {"shape": {"mesh": {"vertices": vertices, "faces": faces}}, "mass": 1},
        "friction": {"environment": 0.5, "finger": 0.7},
        "fingers": {
            "count": 2, "radius": 0.5, "max_normal_force": 10,
            "placements": {"grid": [1, 2], "margin": 0.02},
        },
        "motion": {"start": {"position": [0, 0, 2.0]}, "path": [{"slide": {"by": [3, 0, 0]}}]},
        "lattice": {"segments": 6},
        "mechanics": {"z_min": 0.5},
        "cost": {"regrasp": 100, "stability": 0.01},
    }).resolved()  # fmt: skip
