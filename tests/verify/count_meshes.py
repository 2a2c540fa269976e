"""Counts on meshes: parts far from their origin, in single precision."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from tests.moved import Outcome, moved, outcome, parts
from tests.verify.counting import Result, count

NAMES = tuple(parts())


@cache
def in_place(name: str) -> Outcome:
    """Return what a part comes to where it was drawn, in double precision."""
    with tempfile.TemporaryDirectory() as folder:
        parts()[name].export(Path(folder) / "part.off", digits=17)
        return outcome(Path(folder), {"mesh": "part.off"})


def compare(name: str, seed: int, folder: Path) -> tuple[bool, float]:
    """Whether a moved part has the same faces, pieces, placements; and how far its cost is off."""
    mesh, back = moved(parts()[name], np.random.default_rng(seed))
    mesh.export(folder / "part.stl")
    want, got = (
        in_place(name),
        outcome(folder, {"mesh": "part.stl", "frame": {"rotation": {"quaternion": back}}}),
    )
    same = (got.faces, got.pieces, got.placements) == (want.faces, want.pieces, want.placements)
    return same, abs(got.cost / want.cost - 1.0)


@count(50)
def moved_meshes(instance: int) -> Result:
    """A part turned at random, 1 m away, in float32: the same faces, the optimal cost to 1e-4."""
    name = NAMES[instance % len(NAMES)]
    with tempfile.TemporaryDirectory() as folder:
        same, off = compare(name, instance, Path(folder))
    return Result(same and off <= 1e-4, worst=off, note=f"{name}, seed {instance}", outcome=name)
