"""Laws: a shape is the same wherever its file has it, and however it is written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.moved import outcome, parts
from tests.verify.count_meshes import compare


@pytest.mark.parametrize(("name", "seed"), [("box", 50), ("L", 51), ("wedge", 52)])
def test_a_part_far_from_its_origin_is_the_same_part(name: str, seed: int, tmp_path: Path) -> None:
    """Turned at random, 1 m away, in float32: the same faces, the same optimal cost (1e-4)."""
    same, off = compare(name, seed, tmp_path)
    assert same
    assert off <= 1e-4


def test_a_box_is_a_box_however_it_is_written(tmp_path: Path) -> None:
    """As box, hull, mesh, its mesh's hull, or decomposed mesh: six faces, the same cost."""
    pytest.importorskip("coacd")
    mesh = parts()["box"]
    mesh.export(tmp_path / "part.stl")
    corners = mesh.vertices.tolist()
    ways: list[dict[str, Any]] = [
        {"box": [0.06, 0.08, 0.04]},
        {"hull": corners},
        {"mesh": {"vertices": corners, "faces": mesh.faces.tolist()}},
        {"mesh": "part.stl"},
        {"mesh": "part.stl", "convex": "hull"},
        {"mesh": "part.stl", "convex": "decompose"},
    ]
    found = [outcome(tmp_path, way) for way in ways]
    assert {(o.faces, o.pieces, o.placements) for o in found} == {(6, 1, 24)}
    np.testing.assert_allclose([o.cost for o in found], found[0].cost, rtol=1e-6)
