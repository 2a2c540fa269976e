"""Free motion in small scenes, for tests: a scene with the motion put in by hand."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.motion.free import ContactSteps, FreeMotion, PoseGoal, angle_between
from gm_ompl.motion.lattice import Goal, Lattice
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.motion.screw import Screw, Slide, Tumble
from gm_ompl.plain.contact_lattice import PlainContactLattice
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario

Vector = Sequence[float]

DEGREE = math.pi / 180
ACROSS = np.array([0.0, 1.0, 0.0])


def box_between(low: Vector, high: Vector) -> dict[str, Any]:
    """An obstacle as a scenario has it."""
    return {"box": {"min": list(low), "max": list(high)}}


WALL = {"wall": box_between([1.3, -5, 0], [2, 5, 3])}


def hull_of(points: Sequence[Vector]) -> dict[str, Any]:
    """An obstacle likewise."""
    return {"hull": [list(point) for point in points]}


def steps(
    translation: float = 0.5,
    rotation: float = 45.0,
    translate: tuple[int, ...] = (0,),
    rotate: Sequence[Vector] | None = ((0, 1, 0),),
    depth: int | None = None,
) -> ContactSteps:
    """Steps of a contact lattice; the rotation in degrees."""
    axes = None if rotate is None else np.array(rotate, dtype=np.float64)
    return ContactSteps(translation, rotation * DEGREE, translate, axes, depth)


def free_problem(
    *,
    box: Vector = (1, 1, 1),
    obstacles: Mapping[str, Any] | None = None,
    start: Pose | Vector = (0, 0, 0.5),
    goal: PoseGoal | Vector = (1, 0, 0.5),
    region: Sequence[Vector] = ((-1, 0, 0), (1, 0, 3)),
    by: ContactSteps | None = None,
    floor: bool = True,
    **settings: Any,
) -> Problem:
    """A box that moves freely; a goal as a place alone leaves the rotation open."""
    far = [0.0, 0.0, 1e3]  # the way that is replaced below touches nothing
    problem = Scenario.from_resolved({
        "format": "gm-ompl-scenario/1",
        "name": "test/free",
        "object": {"shape": {"box": list(box)}, "mass": 1},
        "friction": {"environment": 0.5, "finger": 0.7},
        "fingers": {"count": 1, "radius": 0.1, "max_normal_force": 20,
                    "placements": {"grid": [1, 1], "faces": "all"}},
        "environment": {"floor": floor, "obstacles": dict(obstacles or {})},
        "motion": {"start": {"position": far}, "path": [{"slide": {"by": [0.1, 0, 0]}}]},
        "lattice": {"segments": 1},
    } | settings).problem  # fmt: skip
    if not isinstance(goal, PoseGoal):
        place = np.array(goal, dtype=np.float64)
        goal = PoseGoal(place, place, None, None, 1e-3 * problem.body.diagonal, 0.5 * DEGREE)
    if not isinstance(start, Pose):
        start = Pose(np.eye(3), np.array(start, dtype=np.float64))
    motion = FreeMotion(start, goal, np.array(region, dtype=np.float64), by or steps())
    return replace(problem, motion=motion, start=(), goal=Goal((), (), ()), lattice=Lattice((), ()))


def lattice_of(problem: Problem) -> PlainContactLattice:
    assert isinstance(problem.motion, FreeMotion)
    return PlainContactLattice(problem, problem.motion)


def explored(lattice: PlainContactLattice, most: int = 500) -> list[int]:
    """All nodes, the start first."""
    found = [lattice.start]
    for node in found:
        assert len(found) <= most
        found += [arc.head for arc in lattice.arcs_from(node) if arc.head not in found]
    return found


def equal(a: Pose, b: Pose, tolerance: float = 1e-9) -> bool:
    near = np.abs(a.position - b.position).max() <= tolerance
    return bool(near) and angle_between(a.rotation, b.rotation) <= tolerance


def is_set(found: Iterable[Pose], wanted: Iterable[Pose], tolerance: float = 1e-9) -> bool:
    """Whether two sets of poses are equal; poses of one set differ from each other."""
    left = list(wanted)
    for pose in found:
        there = [other for other in left if equal(pose, other, tolerance)]
        if len(there) != 1:
            return False
        left.remove(there[0])
    return not left


def upright(x: float, z: float, angle: float, y: float = 0.0) -> Pose:
    """A pose turned about +y by an angle in degrees."""
    return Pose(rotation_about(ACROSS, angle * DEGREE), np.array([x, y, z]))


def turns(arcs: Iterable[GraphArc]) -> list[Tumble]:
    pieces = [arc.arc.piece for arc in arcs if isinstance(arc.arc, Screw)]
    return [piece for piece in pieces if isinstance(piece, Tumble)]


def slides(arcs: Iterable[GraphArc]) -> list[Array]:
    pieces = [arc.arc.piece for arc in arcs if isinstance(arc.arc, Screw)]
    return [piece.by for piece in pieces if isinstance(piece, Slide)]


def listed(vectors: Iterable[Array]) -> list[list[float]]:
    return sorted((np.round(vector, 9) + 0.0).tolist() for vector in vectors)


def over_and_against(**settings: Any) -> Problem:
    """A cube is tipped over and then leant against a wall, which takes a regrasp.

    Leaning 0.3 in front of the wall ends at 17.5 of 45 deg.
    """
    lean = upright(1.0, 0.5, 90.0).turned([1.5, 0.0, 0.0], ACROSS, math.asin(0.3))
    given: dict[str, Any] = {
        "obstacles": {"wall": box_between([1.8, -5, 0], [2, 5, 3])},
        "goal": PoseGoal(lean.position, lean.position, lean.rotation, None, 1e-3, 0.5 * DEGREE),
        "region": ((-0.2, 0, 0), (1.3, 0, 3)),
        "mechanics": {"z_min": 0.02},
        "fingers": {"count": 1, "radius": 0.05, "max_normal_force": 40,
                    "placements": {"grid": [1, 3], "faces": ["-x", "+z"]}},
    }  # fmt: skip
    return free_problem(**{**given, **settings})


def up_to_a_wall(**settings: Any) -> Problem:
    """Two fingers push a cube up to a wall: one whole step, then 0.3 of 0.5."""
    given: dict[str, Any] = {
        "obstacles": WALL,
        "goal": (0.8, 0, 0.5),
        "by": steps(rotate=((0, 0, 1),)),
        "mechanics": {"z_min": 0.02},
        "fingers": {"count": 2, "radius": 0.05, "max_normal_force": 40,
                    "placements": {"grid": [2, 1], "faces": ["-x", "+z"]}},
    }  # fmt: skip
    return free_problem(**{**given, **settings})
