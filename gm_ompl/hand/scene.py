"""A hand's file among an object and obstacles, in MuJoCo's language."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.solids import Body
from gm_ompl.hand.spec import HandSpec, Tip

HAND: Final = "hand/"
"""Before the names of everything that the hand's file names."""


ROUND: Final = 12
"""Corners of a circle around a capsule."""


def scene(library: Any, hand: Any, spec: HandSpec, world: tuple[Body, Sequence[Body], bool]) -> Any:
    """Return the compiled model of a hand, an object and obstacles.

    Args:
        library: MuJoCo.
        hand: its specification of the hand's file.
        spec: the hand.
        world: the object, fixed bodies, and whether z < 0 is solid.
    """
    body, obstacles, floor = world
    whole = library.MjSpec()
    whole.compiler.degree = False
    base = whole.worldbody.add_frame(pos=spec.base.position, quat=spec.base.quaternion())
    for geom in hand.geoms:
        geom.contype, geom.conaffinity = (1, 3) if geom.contype or geom.conaffinity else (0, 0)
    whole.attach(hand, prefix=HAND, frame=base)
    for i, tip in enumerate(spec.tips):
        _site(whole, i, tip)
    free = whole.worldbody.add_body(name="object")
    free.add_freejoint(name="object")
    for k, piece in enumerate(body.pieces):
        _hull(library, whole, free, f"piece {k} of the object", piece.vertices)
    parts = [piece for obstacle in obstacles for piece in obstacle.pieces]
    for k, piece in enumerate(parts):
        _hull(library, whole, whole.worldbody, f"obstacle {k}", piece.vertices)
    if floor:
        whole.worldbody.add_geom(
            name="the floor", type=library.mjtGeom.mjGEOM_PLANE, size=[1, 1, 1],
            contype=2, conaffinity=0,
        )  # fmt: skip
    return whole.compile()


def _site(whole: Any, number: int, tip: Tip) -> None:
    whole.body(HAND + tip.link).add_site(name=f"tip{number}", pos=tip.offset)


def _hull(library: Any, whole: Any, body: Any, name: str, vertices: Array) -> None:
    whole.add_mesh(name=name, uservert=vertices.ravel().tolist())
    body.add_geom(
        name=name, type=library.mjtGeom.mjGEOM_MESH, meshname=name, contype=2, conaffinity=0,
        mass=0.1,
    )  # fmt: skip


def capsule(radius: float, half: float) -> Array:
    """Return points (p, 3) of a capsule along z: a sphere where ``half`` is 0."""
    around = 2.0 * np.pi * np.arange(ROUND) / ROUND
    up = np.linspace(-np.pi / 2.0, np.pi / 2.0, ROUND // 2 + 1)
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    rows = [
        np.column_stack([radius * np.cos(a) * ring, np.full(ROUND, radius * np.sin(a))]) for a in up
    ]
    ball = np.concatenate(rows)
    end = np.array([0.0, 0.0, half])
    return np.concatenate([ball + end, ball - end])
