"""The public functions about one instant: judge it, or map where fingers may be."""

from __future__ import annotations

from typing import TYPE_CHECKING, SupportsFloat

from gm_ompl import limits
from gm_ompl.arguments import finite, kind_of
from gm_ompl.asking import (
    Coordinates,
    PlacementsLike,
    ScenarioLike,
    budget,
    coordinates,
    judge_of,
    loaded,
    placed,
    warned,
)
from gm_ompl.errors import InputError
from gm_ompl.feasibility.verdict import Verdict
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Problem

if TYPE_CHECKING:
    from gm_ompl.feasibility.placement_map import PlacementMap


def judge(
    scenario: ScenarioLike,
    q: Coordinates | None = None,
    direction: Coordinates | None = None,
    placements: PlacementsLike = (),
    *,
    pose: Pose | None = None,
    twist: Twist | None = None,
) -> Verdict:
    """Judge one instant (Sec. 4.2): geometry, the choice of modes, and the margin z.

    The instant is given by the scenario's coordinates (``q``, ``direction``) or, whatever the
    scenario's motion, by ``pose`` and ``twist``.

    Args:
        scenario: where it happens.
        q: object coordinates (d,): ``[s]`` on a path, ``[x, y, yaw]`` in the plane.
        direction: of the object's motion (d,); None at rest.
        placements: per finger, a row of the placement table or (face, cell).
        pose: instead of ``q``, where the object is.
        twist: with ``pose``, the object's velocity, of any magnitude; None at rest.

    Raises:
        InputError: coordinates or placements do not fit the scenario (a path's s is from 0 to 1,
            planar coordinates lie in their ranges), or both forms are mixed.
    """
    problem = loaded(scenario).problem
    moment, rows = _moment(problem, q, direction, pose, twist), placed(problem, placements)
    return judge_of(problem).segment(moment, rows)


def placement_map(
    scenario: ScenarioLike,
    q: Coordinates | None = None,
    direction: Coordinates | None = None,
    *,
    pose: Pose | None = None,
    twist: Twist | None = None,
    time_limit: SupportsFloat | None = None,
    memory_limit: SupportsFloat | None = None,
) -> PlacementMap:
    """Map where each finger may be at an instant: its best z over all partners, or what blocks.

    Args:
        scenario: where it happens.
        q: object coordinates (d,), as for ``judge``; without ``q`` and ``pose``, the start.
        direction: of the object's motion (d,); None at rest.
        pose: instead of ``q``, where the object is.
        twist: with ``pose``, the object's velocity, of any magnitude; None at rest.
        time_limit: for all of it [s]; None is no limit.
        memory_limit: resident memory of the process [MiB].

    Raises:
        InputError: coordinates or the scenario do not fit.
        LimitError: a limit is reached.
    """
    from gm_ompl.feasibility.placement_map import placement_map  # brings the compiler

    asked = budget(time_limit, None, memory_limit)
    with limits.holding(asked.time_limit, asked.memory_limit_mb):
        problem = warned(loaded(scenario)).problem
        if q is None and pose is None:
            pose = problem.object_graph.pose(problem.object_graph.start)
        return placement_map(judge_of(problem), _moment(problem, q, direction, pose, twist))


def _moment(
    problem: Problem,
    q: Coordinates | None,
    direction: Coordinates | None,
    pose: Pose | None,
    twist: Twist | None,
) -> Moment:
    for name, value, kind in (("pose", pose, Pose), ("twist", twist, Twist)):
        if not (value is None or isinstance(value, kind)):
            raise InputError(f"judge: {name}: {kind_of(value)}: must be a gm_ompl.{kind.__name__}")
    if (q is None) == (pose is None) or (pose is None and twist is not None):
        raise InputError("judge: give either q (and direction) or pose (and twist)")
    if pose is not None:
        if direction is not None:
            raise InputError("judge: direction: goes with q; with pose, give twist")
        return Moment(pose, twist)
    moving = None if direction is None else finite("direction", direction, problem.motion.names)
    return problem.motion.moment(coordinates("q", q, problem), moving)
