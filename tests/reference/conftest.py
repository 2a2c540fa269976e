"""Instants and problems simple enough to reason about by hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from gm_ompl.contact.environment import Environment, Obstacle
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.solids import box as box_piece
from gm_ompl.geometry.surface import PlacementTable, placements
from gm_ompl.motion.arc import Motion
from gm_ompl.motion.lattice import Goal, Lattice
from gm_ompl.motion.path import PathMotion, path_lattice, tumble_towards
from gm_ompl.motion.screw import Slide
from gm_ompl.problem import CostSettings, Fingers, MechanicsSettings, Problem

MakeBox = Callable[..., Instant]


def box_on_floor(
    points: Sequence[Sequence[float]] = (),
    normals: Sequence[Sequence[float]] = (),
    *,
    half: Sequence[float] = (2.5, 5.0, 2.5),
    slip: Sequence[float] = (0.0, 0.0, 0.0),
    f_max: float | Sequence[float] = 10.0,
    mu_env: float = 0.5,
    mu_finger: float = 0.7,
    mass: float = 1.0,
    gravity: float = 9.8,
    edges: int = 6,
) -> Instant:
    """A uniform box on its bottom face, world axes along its sides, all corners touching."""
    a, b, c = half
    corners = [[x, y, -c] for x in (-a, a) for y in (-b, b)]
    rows = len(corners)
    n = len(points)
    inertia = mass / 3.0 * np.diag([b * b + c * c, c * c + a * a, a * a + b * b])
    contacts = ContactState(
        np.array(corners), np.tile([0.0, 0.0, 1.0], (rows, 1)), np.tile(slip, (rows, 1)), np.eye(3)
    )
    return Instant(
        contacts=contacts,
        points=np.array(points, dtype=float).reshape(n, 3),
        normals=np.array(normals, dtype=float).reshape(n, 3),
        friction=np.full(n, mu_finger),
        max_normal_force=np.broadcast_to(np.asarray(f_max, dtype=float), (n,)),
        environment_friction=mu_env,
        mass=mass,
        inertia=inertia,
        gravity=gravity,
        cone_edges=edges,
    )


@pytest.fixture(scope="session")
def box() -> MakeBox:
    """``box(points, normals, ...)``: a box at rest or sliding on the floor."""
    return box_on_floor


def small_problem(
    *,
    half: Sequence[float] = (2.5, 5.0, 2.5),
    by: Sequence[float] = (3.0, 0.0, 0.0),
    tumble: float | None = None,
    segments: int = 3,
    grid: tuple[int, int] = (1, 1),
    faces: Sequence[str] = ("+x", "-x", "+y", "-y", "+z"),
    f_max: Sequence[float] = (10.0, 10.0),
    radius: Sequence[float] | None = None,
    start: Sequence[int | None] | None = None,
    goal: Sequence[int | None] | None = None,
    walls: Sequence[tuple[Sequence[float], Sequence[float]]] = (),
    regrasp: float = 100.0,
    stability: float = 0.01,
    samples: int = 3,
    z_min: float = 0.5,
    motion: Motion | None = None,
    lattice: Lattice | None = None,
    goal_at: Sequence[float] = (1.0,),
) -> Problem:
    """The paper's sliding box, smaller: coarse grids, few segments; or a tumble, or any motion."""
    size = np.asarray(half, dtype=float)
    body = Body((box_piece(-size, size),))
    motion = path(body, size[2], by, tumble) if motion is None else motion
    obstacles = [Obstacle("wall", Body((box_piece(low, high),))) for low, high in walls]
    return Problem(
        name="small",
        body=body,
        mass=1.0,
        inertia=np.diag((size**2).sum() - size**2) / 3.0,
        environment=Environment(True, tuple(obstacles), 0.5),
        fingers=hand(placements(body, grid, faces), f_max, radius, start, goal),
        motion=motion,
        lattice=path_lattice([segments]) if lattice is None else lattice,
        start=(0.0,) * motion.dimension,
        goal=Goal(tuple(goal_at), tuple(goal_at), (None,) * motion.dimension),
        mechanics=MechanicsSettings(z_min=z_min),
        cost=CostSettings(regrasp, stability, samples),
    )


def path(body: Body, height: float, by: Sequence[float], tumble: float | None) -> PathMotion:
    """One slide by ``by``, or one tumble by an angle towards +x."""
    pose = Pose.from_yaw([0.0, 0.0, height])
    if tumble is not None:
        ahead = np.array([1.0, 0.0, 0.0])
        return PathMotion(pose, [tumble_towards(body, pose, ahead, tumble)])
    return PathMotion(pose, [Slide(np.asarray(by, dtype=float))])


def hand(
    table: PlacementTable,
    f_max: Sequence[float],
    radius: Sequence[float] | None,
    start: Sequence[int | None] | None,
    goal: Sequence[int | None] | None,
) -> Fingers:
    """Fingers of radius 1 that may start and end anywhere, unless given."""
    n = len(f_max)
    wide = np.ones(n) if radius is None else np.asarray(radius, dtype=float)
    return Fingers(
        radius=wide,
        max_normal_force=np.asarray(f_max, dtype=float),
        friction=np.full(n, 0.7),
        soft=np.zeros(n),
        placements=table,
        start=(None,) * n if start is None else tuple(start),
        goal=(None,) * n if goal is None else tuple(goal),
        clearance=wide / 2.0,
    )


@pytest.fixture(scope="session")
def problem() -> Callable[..., Problem]:
    """``problem(...)``: a small planning problem; see ``small_problem`` for what may vary."""
    return small_problem
