"""Free motion made from the checked values: start, goal, region and the contact lattice's steps."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import PlacedPiece, penetrates
from gm_ompl.motion.free import AXES, SHORTEST, SLACK, ContactSteps, FreeMotion, PoseGoal
from gm_ompl.motion.lattice import Goal
from gm_ompl.scenario.document import Path
from gm_ompl.scenario.goals import FreeModel, GoalModel, RegionModel, WithinModel, turn_of
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import ScenarioModel
from gm_ompl.scenario.motions import Moving, start_rotation, turned, with_height
from gm_ompl.scenario.standing import Ground

WITHIN = 1e-3
"""How far from its place a goal is met, relative to D, where nothing is said."""

NOWHERE = Goal((), (), ())
"""In coordinates, of which free motion has none."""

GOAL: Path = ("motion", "goal")


def make_free(model: ScenarioModel, ground: Ground, notes: Notes) -> Moving | None:
    """Return the motion, or None after noting what is wrong with it."""
    free, given = model.motion.free, model.motion.goal
    assert free is not None
    assert given is not None
    rotation = start_rotation(model.motion.start)
    start = with_height(model.motion.start, rotation, "start", ground, notes)
    last = _filled(given, free, ground, notes)
    if notes.problems:
        return None
    first = ground.exact(Pose(rotation, np.array(start.position, dtype=np.float64)))
    goal = _goal(last)
    region = np.array([free.region.x, free.region.y, free.region.z]).T
    _check_inside(first, region, SLACK * ground.body.diagonal, notes)
    _check_reach(goal, last, region, SLACK * ground.body.diagonal, notes)
    _check_clear(goal, ground, notes)
    _check_steps(model, ground.body.diagonal, notes)
    ground.look("start", ("motion", "start"), first)
    whole = goal_pose(goal)
    if not ground.warnings and whole is not None:
        ground.look("goal", GOAL, whole, held=True)
    motion = FreeMotion(first, goal, region, _steps(model, free))
    filled = model.motion.model_copy(update={"start": start, "goal": last})
    return Moving(motion, (), NOWHERE, filled)


def goal_pose(goal: PoseGoal) -> Pose | None:
    """Return the one pose that a goal names; None where it leaves something open."""
    if goal.rotation is None or not np.array_equal(goal.low, goal.high):
        return None
    return Pose(goal.rotation, goal.low)


def _filled(
    goal: GoalModel | RegionModel, free: FreeModel, ground: Ground, notes: Notes
) -> GoalModel | RegionModel:
    """Return the goal, what it leaves to defaults filled in."""
    within = goal.within or WithinModel()
    if within.position is None:
        within = within.model_copy(update={"position": WITHIN * ground.body.diagonal})
    change: dict[str, object] = {"within": within}
    if goal.rotation is None and goal.up is None and goal.yaw is None:
        change["yaw"] = 0.0
    if isinstance(goal, RegionModel):
        room = free.region
        change |= {key: getattr(goal, key) or getattr(room, key) for key in AXES}
        return goal.model_copy(update=change)
    rotation = _rotation(goal)
    if rotation is not None:
        goal = with_height(goal, rotation, "goal", ground, notes)
    return goal.model_copy(update=change)


def _rotation(goal: GoalModel | RegionModel) -> Array | None:
    """Return how the object must be turned, (3, 3); None where that is left open."""
    if goal.up is not None or isinstance(goal.rotation, str):
        return None
    yaw = goal.yaw if isinstance(goal.yaw, float) else 0.0
    return turned(turn_of(goal), yaw)


def _goal(goal: GoalModel | RegionModel) -> PoseGoal:
    assert goal.within is not None
    assert goal.within.position is not None
    if isinstance(goal, RegionModel):
        low, high = np.array([getattr(goal, key) for key in AXES]).T
    else:
        low = high = np.array(goal.position, dtype=np.float64)
    return PoseGoal(
        low=low,
        high=high,
        rotation=_rotation(goal),
        up=None if goal.up is None else _upward(goal.up),
        distance=goal.within.position,
        angle=goal.within.rotation,
    )


def _upward(name: str) -> Array:
    """Return the direction (3,) that ``x``, ``+x`` or ``-x`` names."""
    direction = np.zeros(3)
    direction[AXES.index(name[-1])] = -1.0 if name[0] == "-" else 1.0
    return direction


def _steps(model: ScenarioModel, free: FreeModel) -> ContactSteps:
    steps = model.lattice.steps
    assert steps is not None
    assert steps.translation is not None
    assert steps.rotation is not None
    rotate = None if isinstance(free.rotate, str) else [_upward(name) for name in free.rotate]
    return ContactSteps(
        translation=steps.translation,
        rotation=steps.rotation,
        translate=tuple(sorted(AXES.index(name) for name in free.translate)),
        rotate=None if rotate is None else np.array(rotate).reshape(-1, 3),
        depth=model.lattice.depth,
    )


def _check_inside(start: Pose, region: Array, slack: float, notes: Notes) -> None:
    """Note a start outside the region."""
    for i, (value, low, high) in enumerate(zip(start.position, *region, strict=True)):
        if not low - slack <= value <= high + slack:
            wanted = f"outside motion.free.region.{AXES[i]}, {float(low)!r} to {float(high)!r}"
            notes.wrong(("motion", "start", "position", i), float(value), wanted)


def _check_reach(
    goal: PoseGoal, given: GoalModel | RegionModel, region: Array, slack: float, notes: Notes
) -> None:
    """Note a goal that the region keeps out of reach."""
    low, high = region
    missing = np.maximum(np.maximum(low - goal.high, goal.low - high), 0.0)
    if np.linalg.norm(missing) <= goal.distance + slack:
        return
    for i in np.flatnonzero(missing):
        place: Path = (AXES[i],) if isinstance(given, RegionModel) else ("position", int(i))
        least, most = float(goal.low[i]), float(goal.high[i])
        wanted = (
            f"outside motion.free.region.{AXES[i]}, {float(low[i])!r} to {float(high[i])!r}, "
            f"by more than the goal's within.position, {goal.distance:g}"
        )
        notes.wrong((*GOAL, *place), least if least == most else [least, most], wanted)


def _check_clear(goal: PoseGoal, ground: Ground, notes: Notes) -> None:
    """Note a goal pose at which, and as near it as counts, the object penetrates something."""
    pose, body = goal_pose(goal), ground.body
    if pose is None:
        return
    reach = float(np.linalg.norm(body.vertices, axis=1).max())
    slack = goal.distance + 2.0 * math.sin(goal.angle / 2.0) * reach
    slack = max(slack, ground.environment.contact_tolerance * body.diagonal)
    for part in _penetrated(pose, ground, slack):
        position = ", ".join(f"{value:.6g}" for value in pose.position)
        text = (
            f"at the goal (centre of mass at {position}) the object penetrates {part}, by more "
            "than within makes up for; move one of them so that they are apart or just touch"
        )
        notes.add(GOAL, text)


def _penetrated(pose: Pose, ground: Ground, slack: float) -> Iterator[str]:
    """Yield the names of what the object overlaps by more than ``slack`` (a length)."""
    pieces = [PlacedPiece(piece, pose) for piece in ground.body.pieces]
    if ground.environment.floor and min(piece.bounds[0][2] for piece in pieces) < -slack:
        yield "the floor"
    for obstacle in ground.environment.obstacles:
        others = [PlacedPiece(piece) for piece in obstacle.body.pieces]
        if any(penetrates(a, b, slack) for a in pieces for b in others):
            yield f"obstacle {obstacle.name!r}"


def _check_steps(model: ScenarioModel, D: float, notes: Notes) -> None:
    """Note steps so short that the lattice has no arcs of their length."""
    steps = model.lattice.steps
    assert steps is not None
    assert steps.translation is not None
    assert steps.rotation is not None
    short = f"makes arcs shorter than {SHORTEST:g} of the object's size, which do not count; "
    path: Path = ("lattice", "steps")
    if steps.translation < SHORTEST * D:
        wanted = f"{short}make it at least {SHORTEST * D:.3g}"
        notes.wrong((*path, "translation"), steps.translation, wanted)
    if steps.rotation < SHORTEST:
        wanted = f"{short}make it at least {math.degrees(SHORTEST):.3g} deg"
        notes.wrong((*path, "rotation"), f"{math.degrees(steps.rotation):g} deg", wanted)
