"""Parts that are moved, turned and rounded, and what planning with them costs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import gm_ompl
from gm_ompl.arrays import Array
from gm_ompl.geometry.surface import face_labels

SCENARIO = """\
format: gm-ompl-scenario/1
name: test/part
object: {shape: {mesh: part.stl}, mass: 0.2}
friction: {environment: 0.4, finger: 0.8}
fingers: {count: 2, radius: 0.008, max_normal_force: 5, placements: {grid: [2, 2]}}
motion: {start: {position: [0, 0, 1]}, path: [{slide: {by: [0.1, 0, 0]}}]}
lattice: {segments: 3}
mechanics: {z_min: 0.05}
cost: {regrasp: 1, stability: 0.0005}
"""
"""A part of a few centimetres is slid; its height is filled in when it is known."""

L = ((0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3))


def parts() -> dict[str, trimesh.Trimesh]:
    """Return parts of about 0.06 m: convex and not, with square, slanted and curved faces."""
    return {
        "box": trimesh.creation.box([0.06, 0.08, 0.04]),
        "L": _drawn_out(0.015 * np.array(L), 0.045),
        "octagon": trimesh.creation.cylinder(0.04, 0.06, sections=8),
        "ring": trimesh.creation.annulus(0.02, 0.04, 0.05, sections=8),
        "wedge": _drawn_out(np.array([[0, 0], [0.06, 0], [0.04, 0.05], [0, 0.05]]), 0.05),
    }


def _drawn_out(profile: Array, depth: float) -> trimesh.Trimesh:
    """Return a profile in x and z, star-shaped from its first corner, drawn out along y."""
    n = len(profile)
    vertices = [(x, y, z) for y in (0.0, depth) for x, z in profile]
    caps = [(0, k, k + 1) for k in range(1, n - 1)]
    faces = [*caps, *((n + a, n + c, n + b) for a, b, c in caps)]
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, n + j, j), (i, n + i, n + j)]
    return trimesh.Trimesh(vertices, faces, process=False)


@dataclass(frozen=True)
class Outcome:
    """What a part came to: its faces, convex pieces and placements, and the optimal cost."""

    faces: int
    pieces: int
    placements: int
    cost: float


def moved(mesh: trimesh.Trimesh, rng: np.random.Generator) -> tuple[trimesh.Trimesh, list[float]]:
    """Return the part turned at random and 1 m from its origin, and what turns it back."""
    w, *axis = rng.normal(size=4).tolist()
    offset = rng.normal(size=3)
    turn = trimesh.transformations.quaternion_matrix([w, *axis])[:3, :3]
    vertices = mesh.vertices @ turn.T + offset / np.linalg.norm(offset)
    return trimesh.Trimesh(vertices, mesh.faces, process=False), [w, *(-part for part in axis)]


def outcome(folder: Path, shape: dict[str, Any]) -> Outcome:
    """Return what the shape comes to, resting on the floor; its files are in ``folder``."""
    file = folder / "part.yaml"
    file.write_text(SCENARIO)
    lines = [f"object.shape={shape}".replace("'", "")]
    body = gm_ompl.load(file, lines).problem.body
    lines.append(f"motion.start.position=[0, 0, {float(-body.vertices[:, 2].min())!r}]")
    scenario = gm_ompl.load(file, lines)
    plan = gm_ompl.plan(scenario)
    assert plan.cost is not None
    placements = len(scenario.problem.fingers.placements)
    return Outcome(len(face_labels(body)), len(body.pieces), placements, plan.cost)
