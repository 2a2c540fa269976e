"""What free motion and its lattice must satisfy, and where its keys do not belong."""

from __future__ import annotations

import math
from collections.abc import Iterator

from gm_ompl.motion.free import AXES
from gm_ompl.motion.planar import FULL_TURN
from gm_ompl.scenario.document import Path
from gm_ompl.scenario.fields import REST
from gm_ompl.scenario.goals import ANY, FreeModel, GoalModel, RegionModel, turn_of
from gm_ompl.scenario.model import ScenarioModel
from gm_ompl.scenario.motion_checks import Finding, foreign_steps, kind_of
from gm_ompl.scenario.placements import MAX_COUNT

GOAL: Path = ("motion", "goal")

FREE_STEPS = "steps: {translation: 0.5, rotation: 15 deg}"


def free_findings(model: ScenarioModel) -> Iterator[Finding]:
    """Yield the mistakes in a free ``motion``, and its keys in another."""
    motion = model.motion
    if kind_of(motion) == "planar" and motion.goal is not None:
        yield from _foreign(motion.goal)
    if kind_of(motion) != "free":
        return
    assert motion.free is not None
    yield from _room(motion.free)
    if motion.goal is None:
        example = "goal: {position: [1, 0, rest]}"
        yield GOAL, ..., f"missing; free motion needs a goal, for example {example}"
    else:
        yield from _goal(motion.goal)


def _room(free: FreeModel) -> Iterator[Finding]:
    path: Path = ("motion", "free")
    for key in AXES:
        yield from _ordered((*path, "region", key), getattr(free.region, key))
    for key in ("translate", "rotate"):
        names = getattr(free, key)
        for i, name in enumerate(names):
            if not isinstance(names, str) and name in names[:i]:
                yield (*path, key, i), name, "given twice; keep one"


def _ordered(path: Path, interval: tuple[float, ...] | None) -> Iterator[Finding]:
    if interval is not None and not interval[0] <= interval[1]:
        yield path, list(interval), "the first must not exceed the second"


def _goal(goal: GoalModel | RegionModel) -> Iterator[Finding]:
    given = [key for key in ("rotation", "yaw", "up") if getattr(goal, key) is not None]
    if len(given) > 1:
        wanted = f"give only one of rotation, yaw, up; given: {' and '.join(given)}"
        yield (*GOAL, given[1]), ..., wanted
    yield from _within(goal)
    if isinstance(goal, GoalModel):
        open_key = "up" if goal.up is not None else "rotation"
        if goal.position[2] == REST and (goal.up is not None or goal.rotation == ANY):
            wanted = (
                f"how high it rests hangs on how it is turned, which {open_key} leaves open; give "
                "a height, or ranges instead of position, for example x: [5, 5], y: [0, 0]"
            )
            yield (*GOAL, "position", 2), REST, wanted
        return
    if not _names_something(goal):
        wanted = "names neither a place nor a rotation; give one, for example position: [5, 0, 1]"
        yield GOAL, ..., wanted
    for key in AXES:
        yield from _ordered((*GOAL, key), getattr(goal, key))
    if goal.yaw == ANY:
        wanted = "write up: +z where the heading is open, rotation: any where all of it is"
        yield (*GOAL, "yaw"), ANY, wanted
    elif isinstance(goal.yaw, tuple):
        wanted = "must be one angle, for example 30 deg; where the heading is open write up: +z"
        yield (*GOAL, "yaw"), ..., wanted


def _names_something(goal: RegionModel) -> bool:
    """Whether a goal leaves anything out."""
    turned = goal.up is not None or goal.yaw is not None or turn_of(goal) is not None
    return turned or any(getattr(goal, key) is not None for key in AXES)


def _within(goal: GoalModel | RegionModel) -> Iterator[Finding]:
    if goal.within is not None and not 0 < goal.within.rotation <= math.pi:
        degrees = f"{math.degrees(goal.within.rotation):g} deg"
        wanted = (
            "must be > 0 deg and at most 180 deg; where the rotation is open write rotation: any"
        )
        yield (*GOAL, "within", "rotation"), degrees, wanted


def _foreign(goal: GoalModel | RegionModel) -> Iterator[Finding]:
    """Yield what only a goal of free motion may have."""
    if isinstance(goal, RegionModel) and goal.x is None and goal.y is None:
        return  # no planar region: what it lacks is said elsewhere
    for key in ("up", "within"):
        if getattr(goal, key) is not None:
            yield (*GOAL, key), ..., "only for free motion; leave it out"
    if goal.rotation == ANY:
        wanted = "only for free motion; a planar goal region has yaw: any"
        yield (*GOAL, "rotation"), ANY, wanted
    if not isinstance(goal, RegionModel):
        return
    if turn_of(goal) is not None:
        wanted = "a planar goal region has yaw, a range such as [-30 deg, 30 deg], or any"
        yield (*GOAL, "rotation"), ..., wanted
    if goal.z is not None:
        yield (*GOAL, "z"), list(goal.z), "only for free motion; planar motion keeps its height"
    if isinstance(goal.yaw, float):
        wanted = "must be 'any' or a range, for example [-30 deg, 30 deg]"
        yield (*GOAL, "yaw"), f"{math.degrees(goal.yaw):g} deg", wanted


def free_lattice_findings(model: ScenarioModel) -> Iterator[Finding]:
    """Yield the mistakes in the ``lattice`` of free motion, and its keys in another."""
    kind, lattice = kind_of(model.motion), model.lattice
    if kind in ("path", "planar") and lattice.depth is not None:
        yield ("lattice", "depth"), lattice.depth, "only for free motion; leave it out"
    if kind != "free":
        return
    if lattice.segments is not None:
        yield ("lattice", "segments"), ..., f"segments are for a path; use {FREE_STEPS}"
    if lattice.steps is None:
        if lattice.segments is None:
            yield ("lattice", "steps"), ..., f"missing; add it, for example {FREE_STEPS}"
        return
    foreign = [
        *foreign_steps(lattice.steps, ("translation", "rotation"), f"free motion has {FREE_STEPS}")
    ]
    if foreign:
        yield from foreign
        return
    for key, example in (("translation", "0.5"), ("rotation", "15 deg")):
        if getattr(lattice.steps, key) is None:
            yield ("lattice", "steps", key), ..., f"missing; add it, for example {key}: {example}"
    yield from _step_sizes(model)


def _step_sizes(model: ScenarioModel) -> Iterator[Finding]:
    free, steps = model.motion.free, model.lattice.steps
    assert free is not None
    assert steps is not None
    if steps.translation is not None:
        ranges = [getattr(free.region, key) for key in free.translate]
        if max(high - low for low, high in ranges) / steps.translation > MAX_COUNT:
            wanted = f"gives more than {MAX_COUNT} steps; make it larger"
            yield ("lattice", "steps", "translation"), steps.translation, wanted
    if steps.rotation is None:
        return
    path: Path = ("lattice", "steps", "rotation")
    degrees = f"{math.degrees(steps.rotation):g} deg"
    if not 0 < steps.rotation <= math.pi:
        yield path, degrees, "must be > 0 deg and at most 180 deg"
        return
    turns = FULL_TURN / steps.rotation
    if abs(turns - round(turns)) > 1e-6 and model.lattice.depth is None and free.rotate:
        wanted = (
            "must divide a full turn, 360 deg: of other steps the poses have no end; "
            f"make it {360 / round(turns):g} deg, or bound them, for example depth: 40"
        )
        yield path, degrees, wanted
