"""Scenario -> Problem: shapes, placements, motion and lattice made from the checked values."""

from __future__ import annotations

import math

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.hulls import whole_hull
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, at_centre_of_mass, mass_properties, shifted
from gm_ompl.motion.lattice import Coordinates, Lattice
from gm_ompl.motion.motion import Motion
from gm_ompl.motion.path import PathMotion, path_lattice, tumble_towards
from gm_ompl.motion.planar import FULL_TURN, PlanarMotion, planar_lattice
from gm_ompl.motion.screw import Piece, Slide
from gm_ompl.problem import (
    CostSettings,
    Environment,
    Fingers,
    Goal,
    MechanicsSettings,
    Obstacle,
    Problem,
)
from gm_ompl.scenario.document import Document, Path
from gm_ompl.scenario.hand import make_fingers
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import PoseModel, ScenarioModel
from gm_ompl.scenario.shapes import body_of

TOWARDS = {
    "+x": np.array([1.0, 0.0, 0.0]),
    "-x": np.array([-1.0, 0.0, 0.0]),
    "+y": np.array([0.0, 1.0, 0.0]),
    "-y": np.array([0.0, -1.0, 0.0]),
}
"""The directions a tumble may take, world frame."""

MAX_NODES = 2**62
"""Nodes are 64-bit numbers."""


def build_problem(model: ScenarioModel, document: Document) -> Problem:
    """Return the problem that a valid ``model`` describes.

    Raises:
        ScenarioError: the shapes, faces or poses make no usable problem.
    """
    notes = Notes(document)
    made = notes.attempt(("object", "shape"), lambda: _object(model))
    obstacles = _obstacles(model, notes)
    notes.stop()
    assert made is not None
    body, inertia = made
    motion, start, goal = _motion(model, body, notes)
    fingers = make_fingers(model, body, notes)
    notes.stop()
    assert motion is not None
    assert fingers is not None
    lattice = _lattice(model, motion)
    _check_size(model, lattice, fingers, notes)
    problem = Problem(
        name=model.name,
        body=body,
        mass=model.object.mass,
        inertia=inertia,
        environment=Environment(
            floor=model.environment.floor,
            obstacles=obstacles,
            friction=model.friction.environment,
            patch_points=model.mechanics.patch_points or 0,
        ),
        fingers=fingers,
        motion=motion,
        lattice=lattice,
        start=start,
        goal=goal,
        mechanics=_mechanics(model),
        cost=CostSettings(**model.cost.model_dump()),
    )
    _check_poses(problem, notes)
    notes.stop()
    return problem


def _mechanics(model: ScenarioModel) -> MechanicsSettings:
    return MechanicsSettings(
        gravity=model.gravity,
        cone_edges=model.mechanics.cone_edges,
        z_min=model.mechanics.z_min,
        backend=model.mechanics.backend,
    )


def _object(model: ScenarioModel) -> tuple[Body, Array]:
    """Return the object in its own frame, origin at the centre of mass, and its inertia."""
    mass, given = model.object.mass, model.object.centre_of_mass
    body = body_of(model.object.shape)
    if given is not None:
        body = shifted(body, -np.array(given))
        _check_centre(body)
        return body, np.array(model.object.inertia)
    if model.object.shape.box is None:
        body, _ = at_centre_of_mass(body)
    return body, mass_properties(body, mass).inertia


def _check_centre(body: Body) -> None:
    """Raise unless the centre of mass, the origin, lies in the body's convex hull."""
    whole = whole_hull(body)
    if (whole.face_offsets < -1e-9 * body.diagonal).any():
        raise GeometryError("object.centre_of_mass lies outside the shape")


def _obstacles(model: ScenarioModel, notes: Notes) -> tuple[Obstacle, ...]:
    made = []
    # By name: programs that write YAML or JSON may sort keys, and the problem must not hang on it.
    for name, obstacle in sorted(model.environment.obstacles.items()):
        path: Path = ("environment", "obstacles", name)
        body = notes.attempt(path, lambda obstacle=obstacle: body_of(obstacle))  # type: ignore[misc]
        if body is not None:
            made.append(Obstacle(name, body))
    return tuple(made)


def _motion(
    model: ScenarioModel, body: Body, notes: Notes
) -> tuple[Motion | None, Coordinates, Goal]:
    """Return the motion, the start's coordinates and the goal."""
    if model.motion.planar is not None:
        return _planar(model)
    first = Pose.from_yaw(model.motion.start.position, model.motion.start.yaw)
    pieces: list[Piece] = []
    pose = first
    for i, piece in enumerate(model.motion.path or ()):
        if piece.slide is not None:
            made: Piece | None = Slide(np.array(piece.slide.by))
        else:
            path = ("motion", "path", i, "tumble", "towards")
            tumble = piece.tumble
            assert tumble is not None
            made = notes.attempt(
                path,
                lambda tumble=tumble, pose=pose: tumble_towards(  # type: ignore[misc]
                    body, pose, TOWARDS[tumble.towards], tumble.angle
                ),
            )
        if made is None:
            return None, (0.0,), Goal((1.0,), (1.0,), (None,))
        pieces.append(made)
        pose = made.pose(pose, 1.0)
    return PathMotion(first, pieces), (0.0,), Goal((1.0,), (1.0,), (None,))


def _planar(model: ScenarioModel) -> tuple[PlanarMotion, Coordinates, Goal]:
    planar, first, last = model.motion.planar, model.motion.start, model.motion.goal
    assert planar is not None
    assert last is not None
    ranges = (planar.x, planar.y, planar.yaw)
    motion = PlanarMotion(
        [low for low, _ in ranges], [high for _, high in ranges], first.position[2]
    )
    start = motion.wrap((*first.position[:2], first.yaw))
    if isinstance(last, PoseModel):
        point = motion.wrap((*last.position[:2], last.yaw))
        return motion, start, Goal(point, point, motion.periods)
    low: list[float | None] = [last.x[0], last.y[0], None]
    high: list[float | None] = [last.x[1], last.y[1], None]
    if not isinstance(last.yaw, str) and last.yaw[1] - last.yaw[0] < FULL_TURN * (1 - 1e-9):
        low[2], high[2] = last.yaw
    return motion, start, Goal(tuple(low), tuple(high), motion.periods)


def _lattice(model: ScenarioModel, motion: Motion) -> Lattice:
    if isinstance(motion, PlanarMotion):
        steps = model.lattice.steps
        assert steps is not None
        return planar_lattice(motion, (steps.x, steps.y, steps.yaw))
    segments = model.lattice.segments
    assert segments is not None
    assert model.motion.path is not None
    per_piece = segments if isinstance(segments, tuple) else (segments,) * len(model.motion.path)
    return path_lattice(per_piece)


def _check_size(model: ScenarioModel, lattice: Lattice, fingers: Fingers, notes: Notes) -> None:
    """Note a lattice with more nodes than 64-bit numbers can name."""
    hands = 1
    for group in fingers.groups():
        hands *= math.comb(len(fingers.placements), len(group))
    nodes = math.prod(lattice.shape) * hands
    if nodes > MAX_NODES:
        key = "segments" if model.motion.path is not None else "steps"
        notes.problems.append(
            notes.document.line(
                ("lattice", key),
                f"together with the placements this makes {nodes:.3g} nodes, more than 2^62; "
                "use fewer segments, a coarser grid or fewer fingers",
            )
        )


def _check_poses(problem: Problem, notes: Notes) -> None:
    """Note what the object penetrates at the start and, where the goal is one pose, there."""
    whole_goal = problem.goal.low == problem.goal.high and None not in problem.goal.low
    ends: list[tuple[str, Path, Coordinates]] = [("start", ("motion", "start"), problem.start)]
    if whole_goal:
        path: Path = ("motion", "path" if problem.motion.dimension == 1 else "goal")
        ends.append(("goal", path, tuple(float(v or 0.0) for v in problem.goal.low)))
    parts: list[tuple[str, Scene]] = [
        (f"obstacle {obstacle.name!r}", Scene(problem.body, [obstacle.body], floor=False))
        for obstacle in problem.environment.obstacles
    ]
    if problem.environment.floor:
        parts.insert(0, ("the floor", Scene(problem.body, [], floor=True)))
    for name, where, q in ends:
        pose = problem.motion.pose(q)
        for part, scene in parts:
            if not scene.object_free(pose):
                position = ", ".join(f"{value:.6g}" for value in pose.position)
                text = (
                    f"at the {name} (centre of mass at {position}) the object penetrates {part}; "
                    "move one of them so that they are apart or just touch"
                )
                notes.problems.append(notes.document.line(where, text))
