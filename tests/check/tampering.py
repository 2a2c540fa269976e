"""Ways to tamper with a plan, and what the check must say of each."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any, NamedTuple

Draft = dict[str, Any]


class Case(NamedTuple):
    """One kind of tampering and what the check must say of it."""

    tamper: Callable[[Draft], object]
    step: int | None  # None: the plan as a whole
    topic: str
    words: str = ""


def put(path: str, value: Any) -> Callable[[Draft], object]:
    """Return a tampering that sets the value at ``path`` ("steps.0.cost")."""

    def tamper(draft: Draft) -> None:
        *where, last = [int(key) if key.isdigit() else key for key in path.split(".")]
        place: Any = draft
        for key in where:
            place = place[key]
        place[last] = value

    return tamper


def _add(path: str, amount: float) -> Callable[[Draft], object]:
    """Return a tampering that adds to the number at ``path``."""

    def tamper(draft: Draft) -> None:
        place: Any = draft
        for key in path.split("."):
            place = place[int(key) if key.isdigit() else key]
        put(path, place + amount)(draft)

    return tamper


def _every_segment(draft: Draft, step: int, **values: Any) -> None:
    for segment in draft["steps"][step]["segments"]:
        segment.update(copy.deepcopy(values))


def _turned(angle: float) -> list[float]:
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def total(draft: Draft) -> None:
    """Make the totals agree with the steps again, so that only the tampering remains."""
    draft["cost"] = math.fsum(step["cost"] for step in draft["steps"])
    draft["regrasps"] = sum(step["kind"] == "regrasp" for step in draft["steps"])


def _then_total(tamper: Callable[[Draft], object]) -> Callable[[Draft], object]:
    """Return ``tamper`` with the totals made to agree afterwards."""

    def both(draft: Draft) -> None:
        tamper(draft)
        total(draft)

    return both


def _repeat_segments(draft: Draft, more: int) -> None:
    draft["steps"][1]["segments"] += draft["steps"][1]["segments"][:more]


def _reverse(draft: Draft) -> None:
    step = draft["steps"][0]
    step["from"], step["to"] = step["to"], step["from"]
    step["pose_from"], step["pose_to"] = step["pose_to"], step["pose_from"]
    step["arc"] = {"translation": [-value for value in step["arc"]["translation"]]}


def _target(face: str, cell: list[int], point: list[float], normal: list[float]) -> Draft:
    return {"face": face, "cell": cell, "point": point, "normal": normal}


def _retarget(target: Draft) -> Callable[[Draft], object]:
    def tamper(draft: Draft) -> None:
        draft["steps"][2]["to"] = target
        draft["steps"][3]["placements"][1] = target

    return tamper


def _merge_pieces(draft: Draft) -> None:
    """Let the second arc run on over the piece boundary to the goal."""
    second, last = draft["steps"][1], draft["steps"][3]
    second.update(to=last["to"], pose_to=last["pose_to"], arc=last["arc"])
    second["segments"] += last["segments"] * 2
    del draft["steps"][2:]
    total(draft)


def _swap_fingers(draft: Draft) -> None:
    draft["steps"][1]["placements"].reverse()
    for segment in draft["steps"][1]["segments"]:
        segment["modes"].reverse()
        segment["f_com"].reverse()


def _not_solved(draft: Draft) -> None:
    draft.update(status="budget")


CASES: dict[str, Case] = {
    "pose: position": Case(_add("steps.0.pose_to.position.0", 1e-3), 0, "pose", "0.001"),
    "pose: position, a hair": Case(_add("steps.3.pose_to.position.2", 1e-6), 3, "pose"),
    "pose: quaternion": Case(put("steps.1.pose_from.quaternion", _turned(0.01)), 1, "pose"),
    "pose: not unit": Case(put("steps.0.pose_to.quaternion", [2.0, 0, 0, 0]), 0, "pose", "2"),
    "arc: another way": Case(_add("steps.0.arc.translation.0", 1e-6), 0, "arc", "translation"),
    "arc: another kind": Case(
        put("steps.1.arc", {"straight": {"from": [0.0, 0.0, 0.0], "to": [1.0, 0.0, 0.0]}}),
        1,
        "arc",
        "a straight is claimed",
    ),
    "placement: face": Case(put("steps.0.placements.0.face", "+y"), 0, "placements", "point"),
    "placement: no such face": Case(
        put("steps.0.placements.1.face", "top"), 0, "placements", "+x, -x, +y"
    ),
    "placement: face not allowed": Case(
        put("steps.0.placements.1.face", "-y"), 0, "placements", "-y"
    ),
    "placement: cell": Case(put("steps.0.placements.0.cell", [2, 1]), 0, "placements", "point"),
    "placement: no such cell": Case(
        put("steps.0.placements.0.cell", [2, 5]), 0, "placements", "no such cell"
    ),
    "placement: point": Case(_add("steps.3.placements.0.point.0", 1e-4), 3, "placements", "0.0001"),
    "placement: off the surface": Case(_add("steps.1.placements.0.point.2", 0.1), 1, "placements"),
    "placement: normal": Case(
        put("steps.1.placements.0.normal", [0.0, 0.6, -0.8]), 1, "placements", "normal"
    ),
    "placement: one finger short": Case(
        lambda d: d["steps"][0]["placements"].pop(), 0, "placements", "2 fingers"
    ),
    "order of fingers": Case(_swap_fingers, 1, "continuity", "placements"),
    "mode: position for force": Case(
        lambda d: _every_segment(d, 0, modes=["position", "position"], f_com=[None, None]),
        0,
        "modes",
        "excessive internal force",
    ),
    "mode: force for position": Case(
        lambda d: _every_segment(d, 0, modes=["force", "force"], f_com=[10.0, 1.0]), 0, "best modes"
    ),
    "modes: one short": Case(put("steps.0.segments.1.modes", ["force"]), 0, "segments", "1 modes"),
    "f_com: changed": Case(put("steps.1.segments.2.f_com.0", 8.0), 1, "z", "claimed"),
    "f_com: changed, z to match": Case(
        lambda d: _every_segment(d, 0, f_com=[8.0, None], z=3.7),
        0,
        "best modes",
        "best of all modes",
    ),
    "f_com: negative": Case(put("steps.0.segments.0.f_com.0", -1.0), 0, "f_com", "1 outside"),
    "f_com: above the limit": Case(put("steps.0.segments.0.f_com.0", 10.5), 0, "f_com", "0.5"),
    "f_com: null under force": Case(put("steps.0.segments.0.f_com.0", None), 0, "f_com", "null"),
    "f_com: under position": Case(put("steps.0.segments.0.f_com.1", 1.0), 0, "f_com", "null"),
    "z: up": Case(_add("steps.0.segments.0.z", 1e-4), 0, "z", "0.0001"),
    "z: down": Case(_add("steps.3.segments.1.z", -1e-4), 3, "z", "0.0001"),
    "z: of the rest": Case(_add("steps.2.z", 0.01), 2, "z", "0.01"),
    "z: negative": Case(put("steps.0.segments.0.z", -1.0), 0, "z_min", "below z_min"),
    "cost of an arc": Case(_then_total(_add("steps.0.cost", -0.01)), 0, "cost", "(9)"),
    "cost of a regrasp": Case(_then_total(put("steps.2.cost", 1.0)), 2, "cost", "(10)"),
    "total cost": Case(_add("cost", -1.0), None, "cost", "add up"),
    "total cost: null": Case(put("cost", None), None, "cost", "None"),
    "regrasps": Case(put("regrasps", 0), None, "regrasps", "the plan has 1"),
    "missing arc": Case(_then_total(lambda d: d["steps"].pop(1)), 1, "continuity", "0.25"),
    "missing regrasp": Case(_then_total(lambda d: d["steps"].pop(2)), 2, "continuity", "+y"),
    "duplicated arc": Case(
        _then_total(lambda d: d["steps"].insert(1, copy.deepcopy(d["steps"][0]))), 1, "continuity"
    ),
    "arcs in another order": Case(
        lambda d: d["steps"].insert(0, d["steps"].pop(1)), 0, "start", "[0.25]"
    ),
    "steps merged over a piece boundary": Case(_merge_pieces, 1, "coordinates", "boundary at 0.5"),
    "too few segments": Case(lambda d: d["steps"][1]["segments"].pop(), 1, "segments", "exactly 3"),
    "a segment too many": Case(lambda d: _repeat_segments(d, 1), 1, "segments", "exactly 3"),
    "twice the segments": Case(lambda d: _repeat_segments(d, 3), 1, "segments", "exactly 3"),
    "no segments": Case(put("steps.1.segments", []), 1, "segments", "0 segments"),
    "wrong start": Case(_then_total(lambda d: d["steps"].pop(0)), 0, "start", "[0.25]"),
    "wrong goal": Case(_then_total(lambda d: d["steps"].pop()), 2, "goal", "[0.5]"),
    "no steps": Case(_then_total(lambda d: d["steps"].clear()), None, "goal", "no steps"),
    "reversed arc": Case(_reverse, 0, "start", "[0.25]"),
    "coordinate out of bounds": Case(put("steps.3.to", [1.5]), 3, "coordinates", "bounds"),
    "coordinate beyond all bounds": Case(put("steps.3.to", [1e308]), 3, "coordinates", "bounds"),
    "regrasp: point it comes from": Case(
        _add("steps.2.from.point.2", 0.1), 2, "placements", "from"
    ),
    "coordinates: too many": Case(put("steps.0.to", [0.25, 0.0]), 0, "coordinates", "2"),
    "coordinate changed": Case(put("steps.0.to", [0.2]), 0, "pose"),
    "arc of no length": Case(put("steps.0.to", [0.0]), 0, "coordinates", "does not move"),
    "regrasp elsewhere": Case(put("steps.2.at", [0.4]), 2, "continuity", "[0.5]"),
    "regrasp to the same place": Case(
        lambda d: _retarget(copy.deepcopy(d["steps"][2]["from"]))(d), 2, "target", "where it was"
    ),
    "regrasp to a taken place": Case(
        lambda d: _retarget(copy.deepcopy(d["steps"][2]["placements"][0]))(d), 2, "target", "taken"
    ),
    "regrasp too close to a fingertip": Case(
        _retarget(_target("+z", [3, 2], [1.0, 0.0, 2.5], [0.0, 0.0, -1.0])), 2, "target", "apart"
    ),
    "regrasp through the floor": Case(
        _retarget(_target("+x", [2, 0], [2.5, 0.0, -2.0], [-1.0, 0.0, 0.0])), 2, "target", "floor"
    ),
    "another finger lifted": Case(put("steps.2.finger", 0), 2, "lifted finger", "'from'"),
    "no such finger lifted": Case(put("steps.2.finger", 2), 2, "lifted finger", "0 to 1"),
    "lifted finger has a mode": Case(
        put("steps.2.modes", ["force", "position"]), 2, "lifted finger", "null"
    ),
    "resting finger has no mode": Case(
        put("steps.2.modes", [None, None]), 2, "lifted finger", "null"
    ),
    "regrasp from elsewhere": Case(put("steps.2.from.cell", [1, 2]), 2, "lifted finger", "'from'"),
    "optimal without proof": Case(put("optimal", True), None, "optimal", "does not prove"),
    "optimal without bound": Case(
        lambda d: d.update(optimal=True, lower_bound=None), None, "optimal", "None"
    ),
    "bound above the cost": Case(put("lower_bound", 1e3), None, "lower_bound", "above"),
    "not solved, yet steps": Case(_not_solved, None, "status", "'budget'"),
    "scenario: mass": Case(put("scenario.object.mass", 2), 0, "z"),
    "scenario: environment friction": Case(put("scenario.friction.environment", 0.4), 0, "z"),
    "scenario: finger friction": Case(put("scenario.friction.finger", [0.6, 0.6]), 0, "z"),
    "scenario: f_max": Case(
        put("scenario.fingers.max_normal_force", [5.0, 5.0]), 0, "f_com", "5 outside"
    ),
    "scenario: gravity": Case(put("scenario.gravity", 9.81), 0, "z"),
    "scenario: z_min": Case(put("scenario.mechanics.z_min", 5.0), 0, "z_min", "z_min = 5"),
    "scenario: cone edges": Case(put("scenario.mechanics.cone_edges", 6), 0, "z"),
    "scenario: size": Case(put("scenario.object.shape.box", [5, 12, 5]), 3, "placements", "point"),
    "scenario: grid": Case(put("scenario.fingers.placements.grid", [7, 7]), 0, "placements"),
    "scenario: radius": Case(put("scenario.fingers.radius", [1.0, 1.5]), 2, "target", "finger 1"),
    "scenario: a wall in the way of the object": Case(
        put("scenario.environment.obstacles.wall.box.min", [5.5, 3.5, 0]), 1, "geometry", "object"
    ),
    "scenario: a wall in the way of a finger": Case(
        put("scenario.environment.obstacles.wall.box.min", [-20, 5.5, 0]),
        3,
        "geometry",
        "finger 1",
    ),
    "scenario: longer path": Case(
        put("scenario.motion.path.0.slide.by", [5.0, 0.0, 0.0]), 0, "pose"
    ),
    "scenario: finer lattice": Case(put("scenario.lattice.segments", [4, 1]), 0, "segments"),
    "scenario: cost of a regrasp": Case(put("scenario.cost.regrasp", 50.0), 2, "cost", "(10)"),
    "scenario: X_stab": Case(put("scenario.cost.stability", 0.1), 0, "cost", "(9)"),
    "scenario: samples": Case(put("scenario.cost.samples_per_arc", 4), 0, "segments", "4"),
    "scenario: start of a finger": Case(
        put("scenario.fingers.start", [{"face": "+z", "cell": [1, 1]}, "any"]),
        0,
        "start",
        "[1, 1]",
    ),
    "scenario: goal of a finger": Case(
        put("scenario.fingers.goal", ["any", {"face": "-x", "cell": [2, 2]}]),
        3,
        "goal",
        "finger 1",
    ),
}
