from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import PlacedPiece, gap
from gm_ompl.geometry.solids import box
from gm_ompl.motion.screw import Screw, Slide
from gm_ompl.problem import Problem
from gm_ompl.reference.swept import SweptJudge
from tests.free_scenes import box_between, equal, explored, free_problem, is_set, lattice_of, steps

CLUTTER = {
    "wall": box_between([1.3, -5, 0], [2, 5, 3]),
    "ledge": box_between([-3, -5, 0], [-0.75, 5, 0.3]),
    "bar": box_between([-0.4, -5, 1.6], [-0.1, 5, 1.7]),
}
OPEN = ((-3, -2, 0), (3, 2, 4))


def cluttered(shift: Array | None = None, mirrored: bool = False, depth: int = 2) -> Problem:
    by = np.zeros(3) if shift is None else shift
    sign = np.array([-1.0, 1, 1]) if mirrored else np.ones(3)
    obstacles = {}
    for name, shape in CLUTTER.items():
        ends = np.array([shape["box"]["min"], shape["box"]["max"]]) * sign + by
        obstacles[name] = box_between(ends.min(axis=0).tolist(), ends.max(axis=0).tolist())
    place = np.array([0.0, 0, 0.5]) + by
    return free_problem(
        obstacles=obstacles, start=place.tolist(), region=(np.array(OPEN) + by).tolist(),
        by=steps(translation=0.4, rotation=40.0, depth=depth),
    )  # fmt: skip


def test_the_lattice_moves_with_the_scene() -> None:
    """Shifted along the floor by anything, the scene has the same poses, shifted."""
    shift = np.array([0.123, 0.077, 0.0])
    here, there = lattice_of(cluttered()), lattice_of(cluttered(shift))
    wanted = [Pose(here.pose(n).rotation, here.pose(n).position + shift) for n in explored(here)]
    found = [there.pose(n) for n in explored(there)]
    assert len(found) > 20
    assert is_set(distinct(found), distinct(wanted), 1e-8)


def test_the_lattice_is_mirrored_with_the_scene() -> None:
    """Mirrored at x = 0, the scene has the mirrored poses; the box is its own mirror image."""
    mirror = np.diag([-1.0, 1.0, 1.0])
    here, there = lattice_of(cluttered()), lattice_of(cluttered(mirrored=True))
    wanted = [
        Pose(mirror @ here.pose(n).rotation @ mirror, mirror @ here.pose(n).position)
        for n in explored(here)
    ]
    assert is_set(distinct(there.pose(n) for n in explored(there)), distinct(wanted), 1e-8)


def distinct(poses: Iterable[Pose]) -> list[Pose]:
    """Poses without the rotations under way in which nodes at one pose differ."""
    kept: list[Pose] = []
    for pose in poses:
        if not any(equal(pose, other, 1e-7) for other in kept):
            kept.append(pose)
    return kept


def test_arcs_end_where_they_must() -> None:
    """Along every arc nothing penetrates; one that ends early closes a contact or cannot go on.

    Asked of the swept test and of the gaps between pieces, that know nothing of early ends.
    """
    problem = cluttered()
    lattice = lattice_of(problem)
    bodies = tuple(obstacle.body for obstacle in problem.environment.obstacles)
    swept = SweptJudge(problem.body, bodies, True)
    D, early = problem.body.diagonal, 0
    fixed = [PlacedPiece(body.pieces[0]) for body in bodies]
    fixed.append(PlacedPiece(box([-50, -50, -50], [50, 50, 0])))  # the floor

    def gaps(pose: Pose) -> Array:
        return np.array([gap(PlacedPiece(problem.body.pieces[0], pose), f).width for f in fixed])

    for node in explored(lattice):
        for arc in lattice.arcs_from(node):
            assert swept.object_blocked(arc.arc) is None
            if arc.arc.pitch is None or not isinstance(arc.arc, Screw):
                continue
            before, after = gaps(arc.arc.start), gaps(arc.arc.end)
            closes = (before > 1e-5 * D) & (np.abs(after) <= 1e-10 * D)
            on = Screw(arc.arc.start, arc.arc.whole, 1.0, 1.01)
            x = (arc.arc.end.position - problem.motion.pose(()).position)[0] / 0.4
            whole = isinstance(arc.arc.piece, Slide) and abs(x - round(x)) < 1e-9
            assert closes.any() or swept.object_blocked(on) is not None or whole
            early += not whole
    assert early > 5
