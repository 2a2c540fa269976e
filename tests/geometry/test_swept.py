"""Swept tests: dense samples as a second opinion, contacts that are kept, walls between samples."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose, Twist, rotation_about
from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.geometry.swept import SweptScene
from gm_ompl.motion.arc import Arc
from gm_ompl.reference.swept import SweptJudge

NARROW = 1e-4
"""A clearance at every sample with which a motion must be let through."""


def _piece(rng: np.random.Generator, size: float) -> ConvexPiece:
    half = rng.uniform(0.1, 1.0, 3) * size
    if rng.random() < 0.5:
        return box(-half, half)
    return hull(rng.normal(size=(int(rng.integers(6, 12)), 3)) * half)


def _moved(piece: ConvexPiece, pose: Pose) -> ConvexPiece:
    return hull(pose.apply(piece.vertices))


def _pose(rng: np.random.Generator, spread: float) -> Pose:
    return Pose(rotation_about(rng.normal(size=3), rng.uniform(0, 3)), rng.normal(size=3) * spread)


def _sweep(rng: np.random.Generator, kind: str) -> Sweep:
    start, zero, up = _pose(rng, 1.0), np.zeros(3), np.array([0.0, 0.0, 1.0])
    if kind == "translation":
        return Sweep(start, start.position, up, 0.0, rng.normal(size=3) * 1.5)
    if kind == "rotation":
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        return Sweep(start, rng.normal(size=3), axis, rng.uniform(-2.0, 2.0), zero)
    drift = np.append(rng.normal(size=2), 0.0)
    return Sweep(start, start.position, up, rng.uniform(-2.0, 2.0), drift)


def _grown(piece: ConvexPiece, by: float) -> ConvexPiece:
    middle = piece.vertices.mean(axis=0)
    depth = (piece.face_offsets - piece.face_normals @ middle).min()
    return hull(middle + (1.0 + by / depth) * (piece.vertices - middle))


class _OneSweep(Arc):
    """An arc made of one sweep, for the reference's test."""

    def __init__(self, sweep: Sweep) -> None:
        self._sweep = sweep

    def pose(self, t: float) -> Pose:
        return self._sweep.pose(t)

    def twist(self, t: float) -> Twist:
        raise NotImplementedError

    @property
    def sweeps(self) -> tuple[Sweep, ...]:
        return (self._sweep,)

    @property
    def key(self) -> int:
        return id(self)


def object_case(rng: np.random.Generator, kind: str, samples: int) -> str:
    """Judge a random object beside a random obstacle; return "free", "hit" or "near".

    Free means that no sample penetrates; near, that none does but some would with the obstacle
    grown by ``NARROW``. The reference must agree.
    """
    body, other = Body((_piece(rng, 1.0),)), _moved(_piece(rng, 1.0), _pose(rng, 1.0))
    sweep = _sweep(rng, kind)
    ours = SweptScene(Scene(body, [Body((other,))], floor=False)).object_free(sweep)
    theirs = SweptJudge(body, (Body((other,)),), floor=False).object_blocked(_OneSweep(sweep))
    assert ours == (theirs is None)
    scene = Scene(body, [Body((other,))], floor=False)
    poses = [sweep.pose(t) for t in np.linspace(0.0, 1.0, samples)]
    if not all(scene.object_free(pose) for pose in poses):
        assert not ours
        return "hit"
    if ours:
        return "free"
    grown = Scene(body, [Body((_grown(other, NARROW),))], floor=False)
    assert not all(grown.object_free(pose) for pose in poses)
    return "near"


def tips_case(rng: np.random.Generator, kind: str, samples: int) -> Counter[str]:
    """Judge random fingertips beside a random obstacle and the floor; count as above."""
    body, none = Body((box([-0.3] * 3, [0.3] * 3),)), np.zeros(20, dtype=np.int64)
    other, sweep = _moved(_piece(rng, 1.0), _pose(rng, 1.0)), _sweep(rng, kind)
    radius, centres = float(rng.uniform(0.0, 0.3)), rng.normal(size=(20, 3))
    ours = SweptScene(Scene(body, [Body((other,))], True)).free_placements(sweep, centres, radius)
    reference, arc = SweptJudge(body, (Body((other,)),), True), _OneSweep(sweep)
    theirs = [reference.tip_blocked(arc, centre, radius) is None for centre in centres]
    assert ours.tolist() == theirs
    scene = Scene(body, [Body((other,))], True)
    poses = [sweep.pose(t) for t in np.linspace(0.0, 1.0, samples)]
    sampled, wide = (
        np.all([scene.free_placements(p, centres, r, none) for p in poses], axis=0)
        for r in (radius, radius + NARROW)
    )
    assert not (ours & ~sampled).any()
    assert not (wide & ~ours).any()
    near = int((sampled & ~ours).sum())
    return Counter(free=int(ours.sum()), near=near, hit=int((~sampled).sum()))


KINDS = ("translation", "rotation", "both")


@pytest.mark.parametrize("kind", KINDS)
def test_the_object_against_dense_samples(kind: str) -> None:
    """Free, and no sample penetrates; a sample does, and refused; nothing clear is refused."""
    rng = np.random.default_rng(5)
    seen = Counter(object_case(rng, kind, 60) for _ in range(40))
    assert seen["free"] > 5 and seen["hit"] > 5


@pytest.mark.parametrize("kind", KINDS)
def test_fingertips_against_dense_samples(kind: str) -> None:
    """Likewise for fingertips."""
    rng = np.random.default_rng(6)
    seen = sum((tips_case(rng, kind, 60) for _ in range(8)), Counter[str]())
    assert seen["free"] > 20 and seen["hit"] > 20


def test_a_kept_contact_is_free() -> None:
    """A box slides along a wall, tumbles on its edge beside one, turns in place on the floor."""
    body = Body((box([-1.0, -2.0, -1.0], [1.0, 2.0, 1.0]),))
    wall = Body((box([-9.0, 2.0, 0.0], [9.0, 3.0, 9.0]),))
    behind = Body((box([-3.0, -9.0, 0.0], [-1.0, 9.0, 9.0]),))
    table = Body((box([-9.0, -9.0, -1.0], [9.0, 9.0, 0.0]),))
    start, zero = Pose.from_yaw([0.0, 0.0, 1.0]), np.zeros(3)
    up, y = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    edge = np.array([1.0, 0.0, 0.0])
    slide = Sweep(start, start.position, up, 0.0, np.array([4.0, 0.0, 0.0]))
    tumble = Sweep(start, edge, y, np.pi / 2, zero)
    turn = Sweep(start, start.position, up, 1.0, zero)
    for sweep, obstacles, free in (
        (slide, [wall, behind, table], True),
        (tumble, [wall, behind, table], True),
        (turn, [table], True),
        (turn, [wall, table], False),
    ):
        assert SweptScene(Scene(body, obstacles, True)).object_free(sweep) is free
        blocked = SweptJudge(body, tuple(obstacles), True).object_blocked(_OneSweep(sweep))
        assert (blocked is None) is free


def test_a_box_tips_over_the_edge_of_a_step() -> None:
    """It turns about a step's edge that its bottom face lies on: contact all along, and free."""
    body = Body((box([-1.0, -2.0, -1.0], [1.0, 2.0, 1.0]),))
    step = Body((box([-9.0, -9.0, -5.0], [0.0, 9.0, 0.0]),))
    start, edge = Pose.from_yaw([0.5, 0.0, 1.0]), np.zeros(3)
    over = Sweep(start, edge, np.array([0.0, 1.0, 0.0]), 1.2, np.zeros(3))
    back = Sweep(start, edge, np.array([0.0, 1.0, 0.0]), -1e-3, np.zeros(3))
    for sweep, free in ((over, True), (back, False)):
        assert SweptScene(Scene(body, [step], False)).object_free(sweep) is free
        assert (SweptJudge(body, (step,), False).object_blocked(_OneSweep(sweep)) is None) is free


def test_a_fingertip_grazes_a_wall() -> None:
    """On its circle it comes as near to a wall as its radius, and not a hair nearer."""
    body = Body((box([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),))
    start, y = Pose.from_yaw([0.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    turn, centre = Sweep(start, np.zeros(3), y, np.pi, np.zeros(3)), np.array([[0.0, 0.0, 2.0]])
    for gap, free in ((0.0, True), (-1e-6, False)):
        wall = Body((box([2.5 + gap, -9.0, -9.0], [2.6, 9.0, 9.0]),))
        assert SweptScene(Scene(body, [wall], False)).free_placements(turn, centre, 0.5)[0] == free
        at = SweptJudge(body, (wall,), False).tip_blocked(_OneSweep(turn), centre[0], 0.5)
        assert (at is None) is free
        assert at is None or at == pytest.approx(0.5, abs=1e-3)
