"""What a scenario's motion and lattice must satisfy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TypeAlias

from gm_ompl.motion.planar import FULL_TURN
from gm_ompl.scenario.document import Path
from gm_ompl.scenario.fields import Located, PoseModel, Strict
from gm_ompl.scenario.goals import GoalModel, RegionModel
from gm_ompl.scenario.model import MotionModel, ScenarioModel, StepsModel
from gm_ompl.scenario.motions import goal_tilt, goal_yaw, start_yaw
from gm_ompl.scenario.placements import MAX_COUNT

Finding: TypeAlias = tuple[Path, object, str]
"""Path, value (or ``...`` where the message needs none), what would be right."""

Wanted: TypeAlias = dict[str, tuple[Path, tuple[float, ...]]]
"""Per coordinate where its value stands, and its least and greatest value."""


def one_of(path: Path, part: Strict, keys: tuple[str, ...]) -> Iterator[Finding]:
    """Yield a finding unless exactly one of ``keys`` is given."""
    given = [key for key in keys if getattr(part, key) is not None]
    if len(given) != 1:
        have = " and ".join(given) if given else "none"
        yield path, ..., f"needs exactly one of {', '.join(keys)}; given: {have}"


PLANAR_STEPS = {"x": "0.5", "y": "0.5", "yaw": "5 deg"}
"""Per key an example."""

KINDS = ("path", "planar", "free")


def kind_of(motion: MotionModel) -> str | None:
    """Return which kind of motion is given; None where it is none or several."""
    given = [key for key in KINDS if getattr(motion, key) is not None]
    return given[0] if len(given) == 1 else None


def motion_findings(model: ScenarioModel) -> Iterator[Finding]:
    """Yield the mistakes in ``motion``."""
    motion = model.motion
    yield from one_of(("motion",), motion, KINDS)
    kind = kind_of(motion)
    wrong = [*_place(("motion", "start"), motion.start), *_turn(("motion", "start"), motion.start)]
    if isinstance(motion.goal, GoalModel):
        wrong += _place(("motion", "goal"), motion.goal)
        if kind != "free":
            wrong += _turn(("motion", "goal"), motion.goal)
    yield from wrong
    for i, piece in enumerate(motion.path or ()):
        path: Path = ("motion", "path", i)
        yield from one_of(path, piece, ("slide", "tumble"))
        if piece.slide is not None and not any(piece.slide.by):
            by = list(piece.slide.by)
            yield (*path, "slide", "by"), by, "must not be zero; leave the piece out"
        if piece.tumble is not None and not 0 < piece.tumble.angle <= FULL_TURN:
            degrees = f"{math.degrees(piece.tumble.angle):g} deg"
            wanted = "must be > 0 deg and at most 360 deg; for the other way change towards"
            yield (*path, "tumble", "angle"), degrees, wanted
    if kind == "path" and motion.goal is not None:
        yield ("motion", "goal"), ..., "a path ends at its last piece; leave goal out"
    if kind == "planar" and not wrong:
        yield from _planar(model)


def _place(path: Path, part: Located) -> Iterator[Finding]:
    """Yield ``rest`` where only a number may stand."""
    for i, value in enumerate(part.position[:2]):
        if isinstance(value, str):
            wanted = "must be a finite number; only the third, the height, may be rest"
            yield (*path, "position", i), value, wanted


def _turn(path: Path, part: PoseModel | GoalModel) -> Iterator[Finding]:
    """Yield that a pose is turned in two ways at once."""
    if part.rotation is not None and part.yaw:
        wanted = "give either yaw or rotation; a rotation may hold yaw: rotation: {yaw: 30 deg}"
        yield (*path, "yaw"), ..., wanted


def _planar(model: ScenarioModel) -> Iterator[Finding]:
    motion = model.motion
    assert motion.planar is not None
    bounds = {"x": motion.planar.x, "y": motion.planar.y, "yaw": motion.planar.yaw}
    for key, (low, high) in bounds.items():
        if not low < high:
            yield ("motion", "planar", key, 1), high, f"must be > the first, {low!r}"
    low, high = bounds["yaw"]
    if high - low > FULL_TURN * (1 + 1e-9):
        yield ("motion", "planar", "yaw"), ..., "covers more than a full turn (360 deg)"
    if motion.goal is None:
        yield ("motion", "goal"), ..., "missing; a planar motion needs a goal (pose or region)"
        return
    missing = list(_unbounded(motion.goal))
    yield from missing
    if missing:
        return
    tilt = goal_tilt(motion, motion.goal) if isinstance(motion.goal, GoalModel) else 0.0
    if tilt:
        wanted = (
            f"tilts the object by {math.degrees(tilt):.3g} deg against the start; a planar motion "
            "turns it about the vertical alone: give yaw"
        )
        yield ("motion", "goal", "rotation"), ..., wanted
    yield from _within(bounds, ("motion", "start"), _wanted(motion, motion.start))
    yield from _within(bounds, ("motion", "goal"), _wanted(motion, motion.goal))


def _unbounded(goal: GoalModel | RegionModel) -> Iterator[Finding]:
    """Yield what a planar goal lacks."""
    if isinstance(goal, GoalModel):
        return
    lacking = [key for key in ("x", "y") if getattr(goal, key) is None]
    if len(lacking) == 2:
        wanted = "missing; add it, for example position: [0, 0, 5]; or, for a region, x and y"
        yield ("motion", "goal", "position"), ..., wanted
        return
    for key in lacking:
        yield ("motion", "goal", key), ..., f"missing; add it, for example {key}: [-10, 10]"


def _wanted(motion: MotionModel, part: PoseModel | GoalModel | RegionModel) -> Wanted:
    """Return per coordinate where its value stands and its least and greatest value."""
    if not isinstance(part, RegionModel):
        (x, y), key = part.xy, "yaw" if part.rotation is None else "rotation"
        yaw = start_yaw(motion) if isinstance(part, PoseModel) else goal_yaw(motion, part)
        return {
            "x": (("position", 0), (x, x)),
            "y": (("position", 1), (y, y)),
            "yaw": ((key,), (yaw, yaw)),
        }
    ranges = {"x": part.x, "y": part.y, "yaw": part.yaw}
    return {key: ((key,), found) for key, found in ranges.items() if isinstance(found, tuple)}


def _within(
    bounds: dict[str, tuple[float, ...]],
    path: Path,
    wanted: Wanted,
) -> Iterator[Finding]:
    for key, (below, (least, most)) in wanted.items():
        low, high = bounds[key]
        if least > most:
            yield (*path, *below), [least, most], "the first must not exceed the second"
            continue
        if key == "yaw" and high - low >= FULL_TURN * (1 - 1e-9):
            continue
        slack = 1e-9 * (high - low)
        if least < low - slack or most > high + slack:
            value = least if least == most else [least, most]
            yield (*path, *below), value, f"outside motion.planar.{key}, {low!r} to {high!r}"


def lattice_findings(model: ScenarioModel) -> Iterator[Finding]:
    """Yield the mistakes in ``lattice``, which must suit ``motion``."""
    motion, lattice = model.motion, model.lattice
    kind = kind_of(motion)
    if kind == "path":
        assert motion.path is not None
        if lattice.steps is not None:
            yield ("lattice", "steps"), ..., "steps are for planar and free motion; use segments"
        if lattice.segments is None:
            yield ("lattice", "segments"), ..., "missing; add it, for example segments: 30"
        elif isinstance(lattice.segments, tuple) and len(lattice.segments) != len(motion.path):
            wanted = f"needs one entry per piece of motion.path: {len(motion.path)}"
            yield ("lattice", "segments"), list(lattice.segments), wanted
    if kind == "planar":
        if lattice.segments is not None:
            yield ("lattice", "segments"), ..., "segments are for a path; use steps"
        example = "steps: {x: 0.5, y: 0.5, yaw: 5 deg}"
        if lattice.steps is None:
            yield ("lattice", "steps"), ..., f"missing; add it, for example {example}"
        else:
            foreign = [
                *foreign_steps(lattice.steps, tuple(PLANAR_STEPS), f"planar motion has {example}")
            ]
            yield from foreign or _steps(model)


def foreign_steps(steps: StepsModel, keys: tuple[str, ...], instead: str) -> Iterator[Finding]:
    """Yield the steps that another kind of motion has."""
    foreign = [key for key in steps.given if key not in keys]
    if foreign:
        kind = "free" if "translation" in foreign or "rotation" in foreign else "planar"
        verb = "is" if len(foreign) == 1 else "are"
        text = f"{', '.join(foreign)} {verb} for {kind} motion; {instead}"
        yield ("lattice", "steps", foreign[0]), ..., text


def _steps(model: ScenarioModel) -> Iterator[Finding]:
    planar, steps = model.motion.planar, model.lattice.steps
    assert planar is not None
    assert steps is not None
    for key, example in PLANAR_STEPS.items():
        (low, high), step = getattr(planar, key), getattr(steps, key)
        path: Path = ("lattice", "steps", key)
        if step is None:
            yield path, ..., f"missing; add it, for example {key}: {example}"
        elif not step > 0:
            yield path, step, "must be > 0"
        elif (high - low) / step > MAX_COUNT:
            yield path, step, f"gives more than {MAX_COUNT} steps; make it larger"
        elif key == "yaw" and math.isclose(high - low, FULL_TURN, rel_tol=1e-9):
            turns = FULL_TURN / step
            if abs(turns - round(turns)) > 1e-6 or round(turns) < 3:
                degrees = f"{math.degrees(step):g} deg"
                yield path, degrees, "must divide a full turn, 360 deg, in at least 3 steps"
