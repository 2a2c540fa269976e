"""Scenario -> Problem: shapes, placements, motion and lattice made from the checked values."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment, Obstacle
from gm_ompl.errors import GeometryError, ScenarioWarning
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.hulls import whole_hull
from gm_ompl.geometry.solids import Body, at_centre_of_mass, mass_properties, moved, shifted
from gm_ompl.motion.arc import Motion
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.lattice import Coordinates, Lattice
from gm_ompl.motion.path import path_lattice
from gm_ompl.motion.planar import PlanarMotion, planar_lattice
from gm_ompl.problem import CostSettings, Fingers, MechanicsSettings, Problem
from gm_ompl.scenario.checks import frictions
from gm_ompl.scenario.document import Document, Path
from gm_ompl.scenario.free import make_free
from gm_ompl.scenario.hand import make_fingers
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import ScenarioModel, TurnedObstacle
from gm_ompl.scenario.motions import Moving, make_motion, rotation_matrix
from gm_ompl.scenario.robot_hand import check_hand, make_hand, with_found_files
from gm_ompl.scenario.shapes import body_of
from gm_ompl.scenario.standing import Ground
from gm_ompl.scenario.uncertain import make_uncertainty
from gm_ompl.uncertainty.ranges import Uncertainty

THICK = 4.0
"""The least thickness of a convex object, in contact tolerances."""

MOST_CASES = 1024
"""Cases of one decision; each is judged."""

MAX_NODES = 2**62
"""Nodes are 64-bit numbers."""


class Built(NamedTuple):
    """What a scenario comes to.

    Attributes:
        problem: what the planners see.
        model: the values, heights that were to be found filled in.
        warnings: what looks like a mistake.
    """

    problem: Problem
    model: ScenarioModel
    warnings: tuple[ScenarioWarning, ...]


def build(model: ScenarioModel, document: Document) -> Built:
    """Return the problem that a valid ``model`` describes.

    Raises:
        ScenarioError: the shapes, faces or poses make no usable problem.
    """
    notes = Notes(document)
    model = with_found_files(model, notes)
    made = notes.attempt(("object", "shape"), lambda: _object(model))
    obstacles = _obstacles(model, notes)
    notes.stop()
    assert made is not None
    body, inertia = made
    environment = _environment(model, obstacles)
    _check_thickness(body, environment, notes)
    ground = Ground(body, environment, inertia / model.object.mass, model.gravity, document)
    moving = _moving(model, ground, notes)
    fingers = make_fingers(model, body, notes)
    hand = make_hand(model.hand, model.fingers.count, notes)
    notes.stop()
    assert moving is not None
    assert fingers is not None
    lattice = _lattice(model, moving.motion, fingers, notes)
    problem = Problem(
        name=model.name,
        body=body,
        mass=model.object.mass,
        inertia=inertia,
        environment=environment,
        fingers=fingers,
        motion=moving.motion,
        lattice=lattice,
        start=moving.start,
        goal=moving.goal,
        mechanics=MechanicsSettings(
            gravity=model.gravity,
            **model.mechanics.model_dump(include={"cone_edges", "z_min", "backend", "margin"}),
        ),
        cost=CostSettings(**model.cost.model_dump()),
        uncertainty=_uncertainty(model, body, fingers, notes),
        hand=hand,
    )
    _check(problem, notes)
    filled = model.model_copy(update={"motion": moving.model})
    return Built(problem, filled, tuple(ground.warnings))


def _check(problem: Problem, notes: Notes) -> None:
    """Raise what is wrong with the problem as a whole."""
    _check_poses(problem, notes)
    notes.stop()
    check_hand(problem, notes)
    notes.stop()


def _moving(model: ScenarioModel, ground: Ground, notes: Notes) -> Moving | None:
    """Return the motion, or None after noting what is wrong with it."""
    moving = (make_motion if model.motion.free is None else make_free)(model, ground, notes)
    if moving is not None:
        moving.motion.ends = model.cost.samples_at == "ends"
    return moving


def _uncertainty(model: ScenarioModel, body: Body, fingers: Fingers, notes: Notes) -> Uncertainty:
    if model.uncertainty is None:
        return Uncertainty()
    from gm_ompl.uncertainty.worlds import corner_count

    names = tuple(sorted(model.environment.obstacles))
    found = make_uncertainty(model.uncertainty, body, frictions(model), model.object.mass, names)
    count = corner_count(found, fingers.count)
    if count > MOST_CASES:
        text = (
            f"these ranges make {count} cases, of which {MOST_CASES} are the most; leave out "
            "position or command, which multiply them for every finger, or use fewer fingers"
        )
        notes.add(("uncertainty",), text)
    return found


def _environment(model: ScenarioModel, obstacles: tuple[Obstacle, ...]) -> Environment:
    return Environment(
        floor=model.environment.floor,
        obstacles=obstacles,
        friction=model.friction.environment,
        patch_points=model.mechanics.patch_points or 0,
        contact_tolerance=model.mechanics.contact_tolerance,
        by_surface=isinstance(
            None if model.uncertainty is None else model.uncertainty.environment_friction, dict
        ),
    )


def _object(model: ScenarioModel) -> tuple[Body, Array]:
    """Return the object in its own frame, origin at the centre of mass, and its inertia."""
    mass, given = model.object.mass, model.object.centre_of_mass
    body = body_of(model.object.shape)
    if given is not None:
        body = shifted(body, -np.array(given))
        if (whole_hull(body).face_offsets < -1e-9 * body.diagonal).any():
            raise GeometryError("object.centre_of_mass lies outside the shape")
        return body, np.array(model.object.inertia)
    if model.object.shape.box is None:
        body, _ = at_centre_of_mass(body)
    return body, mass_properties(body, mass).inertia


def _obstacles(model: ScenarioModel, notes: Notes) -> tuple[Obstacle, ...]:
    made = []
    # By name: programs that write YAML or JSON may sort keys, and the problem must not hang on it.
    for name, obstacle in sorted(model.environment.obstacles.items()):
        path: Path = ("environment", "obstacles", name)
        body = notes.attempt(path, lambda obstacle=obstacle: _obstacle(obstacle))  # type: ignore[misc]
        if body is not None:
            made.append(Obstacle(name, body))
    return tuple(made)


def _obstacle(model: TurnedObstacle) -> Body:
    body = body_of(model)
    if model.rotation is None:
        return body
    corners = body.vertices
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    rotation = rotation_matrix(model.rotation)
    return moved(body, rotation, middle - rotation @ middle)


def _check_thickness(body: Body, environment: Environment, notes: Notes) -> None:
    """Note a convex object that is so thin that two opposite faces touch a plane at once."""
    if len(body.pieces) > 1:
        return
    (piece,), D = body.pieces, body.diagonal
    width = piece.face_offsets - (piece.vertices @ piece.face_normals.T).min(axis=0)
    thinnest = float(width.min())
    if thinnest < THICK * environment.contact_tolerance * D:
        most = float(f"{thinnest / D / (1.01 * THICK):.2g}")
        text = (
            f"is {thinnest:.3g} thin, less than {THICK:g} contact tolerances; make it thicker, "
            f"or set mechanics.contact_tolerance to {most:g} or less"
        )
        notes.add(("object", "shape"), text)


def _lattice(model: ScenarioModel, motion: Motion, fingers: Fingers, notes: Notes) -> Lattice:
    """Return the lattice, once its size is looked at."""
    lattice = _nodes(model, motion)
    _check_size(model, lattice, fingers, notes)
    return lattice


def _nodes(model: ScenarioModel, motion: Motion) -> Lattice:
    if isinstance(motion, FreeMotion):
        return Lattice((), ())
    if isinstance(motion, PlanarMotion):
        assert model.lattice.steps is not None
        return planar_lattice(motion, tuple(model.lattice.steps.given.values()))
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
        text = (
            f"together with the placements this makes {nodes:.3g} nodes, more than 2^62; "
            "use fewer segments, a coarser grid or fewer fingers"
        )
        notes.add(("lattice", key), text)


def _check_poses(problem: Problem, notes: Notes) -> None:
    """Note what the object penetrates at the start and, where the goal is one pose, there."""
    goal = problem.goal
    whole_goal = goal.low == goal.high and None not in goal.low and goal.low
    ends: list[tuple[str, Path, Coordinates]] = [("start", ("motion", "start"), problem.start)]
    if whole_goal:
        path: Path = ("motion", "path" if problem.motion.dimension == 1 else "goal")
        ends.append(("goal", path, tuple(float(v or 0.0) for v in goal.low)))
    touching = problem.environment.contact_tolerance
    parts: list[tuple[str, Scene]] = [
        (f"obstacle {obstacle.name!r}", Scene(problem.body, [obstacle.body], False, touching))
        for obstacle in problem.environment.obstacles
    ]
    if problem.environment.floor:
        parts.insert(0, ("the floor", Scene(problem.body, [], True, touching)))
    for name, where, q in ends:
        pose = problem.motion.pose(q)
        for part, scene in parts:
            if not scene.object_free(pose):
                position = ", ".join(f"{value:.6g}" for value in pose.position)
                text = (
                    f"at the {name} (centre of mass at {position}) the object penetrates {part}; "
                    "move one of them so that they are apart or just touch"
                )
                notes.add(where, text)
