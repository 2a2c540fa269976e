"""The check of plans with free motion: what the plain search finds, and what is tampered with."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from gm_ompl.checking.check import check, check_against
from gm_ompl.checking.recheck import Recheck
from gm_ompl.checking.report import CheckReport
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import FreeMotion
from gm_ompl.plain.search import plain_search
from gm_ompl.planfile.arcs import arc_of, pose_before
from gm_ompl.planfile.assemble import assemble, pose_record
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario
from tests.check.tampering import Draft, put, total
from tests.free_plans import solved
from tests.free_scenes import DEGREE

Tamper = Callable[[Draft], object]


@cache
def recheck(scene: str) -> Recheck:
    """What is known of a scene: its answers are kept from plan to plan."""
    return Recheck(solved(scene)[0])


def judged(plan: Plan, scene: str) -> CheckReport:
    """Judge a plan for a scene."""
    return check_against(plan, recheck(scene))


@pytest.mark.parametrize(("scene", "kinds"), [
    ("lean", ["displacement", "displacement", "regrasp", "displacement"]),
    ("slide", ["displacement"] * 2),
    ("tilted", ["displacement"] * 2),
    ("there", []),
])  # fmt: skip
def test_what_the_plain_search_finds_holds(scene: str, kinds: list[str]) -> None:
    """The plain search's plans hold, as they are and read from a file."""
    plan = solved(scene)[1]
    assert [step.kind for step in plan.steps] == kinds
    again = Plan.model_validate_json(json.dumps(plan.to_dict()))
    assert again == plan
    report = judged(again, scene)
    assert report.holds, report.table()


def test_a_plan_says_what_the_object_does() -> None:
    """Without coordinates a step's place is said in words."""
    assert [step.where for step in judged(solved("lean")[1], "lean").steps] == [
        "turns 45 deg about +y through [0.5, -0.5, 0]",
        "turns 45 deg about +y through [0.5, -0.5, 0]",
        "at [1, 0, 0.5], finger 0 to -x:[0, 2]",
        "turns 17.4576 deg about +y through [1.5, -0.5, 0]",
    ]
    assert judged(solved("slide")[1], "slide").steps[1].where == "slides 0.3 along +x"


def test_a_plan_file_keeps_the_segments_of_short_arcs() -> None:
    """Coordinates are null; an arc that ends early has its nominal segments and a shorter one."""
    problem, plan = solved("slide")
    document = plan.to_dict()
    assert document["steps"][1]["from"] is document["steps"][1]["to"] is None
    step = plan.steps[1]
    assert step.kind == "displacement"
    cuts = arc_of(step, problem).cuts(len(step.segments))
    assert [pose.position[0] for pose in cuts] == pytest.approx([0.5, 0.5 + 0.5 / 3, 0.8])
    problem, plan = solved("lean")
    assert plan.to_dict()["steps"][2]["at"] is None
    assert pose_before(plan, 2, problem).position == pytest.approx([1.0, 0.0, 0.5])


SCENARIO = {
    "format": "gm-ompl-scenario/1",
    "name": "test/free",
    "object": {"shape": {"box": [1, 1, 1]}, "mass": 1},
    "friction": {"environment": 0.5, "finger": 0.7},
    "fingers": {"count": 1, "radius": 0.05, "max_normal_force": 40,
                "placements": {"grid": [1, 1], "faces": ["+z"]}},
    "environment": {"floor": True},
    "motion": {
        "free": {"region": {"x": [0, 1], "y": [0, 0], "z": [0, 2]},
                 "translate": ["x"], "rotate": ["y"]},
        "start": {"position": [0, 0, "rest"]},
        "goal": {"x": [0.4, 0.6], "y": [0, 0], "z": [0.7, 0.8], "rotation": "any"},
    },
    "lattice": {"steps": {"translation": 0.5, "rotation": "45 deg"}, "depth": 3},
    "mechanics": {"z_min": 0.02},
}  # fmt: skip


def test_a_plan_is_judged_from_its_file_alone(tmp_path: Path) -> None:
    """Scenario, steps and claims are read from the file, and hold until the scenario is changed."""
    scenario = Scenario.from_resolved(SCENARIO)
    found = plain_search(scenario.problem)
    statistics = {
        "time_s": 0.0, "expanded": 0, "mode_decisions": 0, "history": [],
        "failing_junctions": None,  # the plain search does not judge them
    }  # fmt: skip
    plan = assemble(
        scenario.problem, scenario.resolved(), found.moves, optimal=True,
        lower_bound=found.cost, status="solved", planner="plain", statistics=statistics,
    )  # fmt: skip
    plan.save(tmp_path / "plan.json")
    assert len(plan.steps) == 1
    report = check(tmp_path / "plan.json")
    assert report.holds, report.table()
    draft = plan.to_dict()
    draft["scenario"]["lattice"]["steps"]["rotation"] = "30 deg"
    report = check(Plan.model_validate_json(json.dumps(draft)))
    assert [v.topic for v in report.violations] == ["arc"]


class Case(NamedTuple):
    """One kind of tampering with a scene's plan and what the check must say of it."""

    scene: str
    tamper: Tamper
    step: int | None
    topic: str
    words: str = ""


def _arc(number: int, **changes: Any) -> Tamper:
    """Change an arc, the pose where it ends to match."""

    def tamper(draft: Draft) -> None:
        step = draft["steps"][number]
        if "translation" in changes:
            step["arc"] = changes
        else:
            step["arc"]["rotation"].update(changes)
        _end(draft, number)

    return tamper


def _end(draft: Draft, number: int) -> None:
    plan = Plan.model_validate_json(json.dumps(draft))
    step = plan.steps[number]
    assert step.kind == "displacement"
    end = arc_of(step, solved("slide")[0]).end
    draft["steps"][number]["pose_to"] = pose_record(end).model_dump(mode="json")


def _moved(number: int, key: str, by: float) -> Tamper:
    def tamper(draft: Draft) -> None:
        draft["steps"][number][key]["position"][0] += by

    return tamper


def _begin(number: int, by: float) -> Tamper:
    """Let an arc begin elsewhere, and the pose where it ends match."""

    def tamper(draft: Draft) -> None:
        draft["steps"][number]["pose_from"]["position"][0] += by
        _end(draft, number)

    return tamper


def _segments(number: int, count: int) -> Tamper:
    def tamper(draft: Draft) -> None:
        step = draft["steps"][number]
        step["segments"] = [copy.deepcopy(step["segments"][0]) for _ in range(count)]

    return tamper


def _way(*corners: list[float]) -> Tamper:
    """The regrasp's way past other corners."""

    def tamper(draft: Draft) -> None:
        way = draft["steps"][2]["way"]
        draft["steps"][2]["way"] = [way[0], *corners, way[-1]]

    return tamper


def _merge(draft: Draft) -> None:
    first, second = draft["steps"]
    first["arc"] = {"translation": [0.8, 0.0, 0.0]}
    first["pose_to"] = second["pose_to"]
    first["segments"] += second["segments"]
    del draft["steps"][1]
    total(draft)


def _then_total(tamper: Tamper) -> Tamper:
    def both(draft: Draft) -> None:
        tamper(draft)
        total(draft)

    return both


def _pop(number: int) -> Tamper:
    return _then_total(lambda draft: draft["steps"].pop(number))


def _every_segment(number: int, **values: Any) -> Tamper:
    def tamper(draft: Draft) -> None:
        for segment in draft["steps"][number]["segments"]:
            segment.update(copy.deepcopy(values))

    return tamper


STRAIGHT = {"straight": {"from": [0.0, 0.0, 0.0], "to": [1.0, 0.0, 0.0]}}
TURNED = [math.cos(0.01), 0.0, math.sin(0.01), 0.0]

CASES: dict[str, Case] = {
    "start: moved": Case("lean", _begin(0, 1e-3), 0, "start", "0.001 away"),
    "start: a step on": Case("slide", _begin(0, 0.5), 0, "start", "0.5 away"),
    "start: turned": Case("lean", put("steps.0.pose_from.quaternion", TURNED), 0, "start", "deg"),
    "start: first arc missing": Case("lean", _pop(0), 0, "start"),
    "pose: not unit": Case(
        "lean", put("steps.1.pose_from.quaternion", [2.0, 0, 0, 0]), 1, "pose", "length 2"
    ),
    "pose: end": Case("lean", _moved(0, "pose_to", 1e-3), 0, "pose", "where the arc ends"),
    "pose: end, a hair": Case("slide", _moved(1, "pose_to", 1e-6), 1, "pose", "1e-06"),
    "pose: end turned": Case("slide", put("steps.0.pose_to.quaternion", TURNED), 0, "pose"),
    "continuity: a jump": Case("slide", _begin(1, 1e-3), 1, "continuity", "0.001 away"),
    "continuity: arc missing": Case("lean", _pop(1), 2, "continuity"),
    "continuity: arc twice": Case(
        "slide",
        _then_total(lambda d: d["steps"].insert(1, copy.deepcopy(d["steps"][0]))),
        1,
        "continuity",
        "0.5 away",
    ),
    "continuity: regrasp missing": Case("lean", _pop(2), 2, "continuity", "placements"),
    "coordinates: from": Case("lean", put("steps.0.from", [0.0]), 0, "coordinates", "null"),
    "coordinates: to": Case("lean", put("steps.0.to", [0.0, 1.0, 2.0]), 0, "coordinates", "null"),
    "coordinates: at": Case("lean", put("steps.2.at", [0.5]), 2, "coordinates", "null"),
    "turn: too far": Case("lean", _arc(0, angle=50 * DEGREE), 0, "arc", "turns 45 deg"),
    "turn: not far enough": Case("lean", _arc(0, angle=40 * DEGREE), 0, "arc", "turns 45 deg"),
    "turn: a hair more": Case("lean", _arc(0, angle=45 * DEGREE + 1e-6), 0, "arc", "turns 45"),
    "turn: the other way": Case("lean", _arc(0, angle=-45 * DEGREE), 0, "arc", "about -y"),
    "turn: twice": Case("lean", _arc(0, angle=90 * DEGREE), 0, "arc", "turns 45 deg"),
    "turn: another line": Case("lean", _arc(0, point=[0.4, 0, 0]), 0, "arc", "[0.4, 0, 0]"),
    "turn: the middle": Case("lean", _arc(0, point=[0, 0, 0.5]), 0, "arc", "[0, 0, 0.5]"),
    "turn: not a listed direction": Case(
        "lean", _arc(0, point=[0, 0.5, 0], axis=[1.0, 0, 0]), 0, "region", "leaves the region"
    ),
    "turn: in place, not listed": Case(
        "lean", _arc(0, point=[0, 0, 0], axis=[0, 0, 1.0]), 0, "arc", "about +z"
    ),
    "turn: axis not unit": Case("lean", _arc(0, axis=[0, 1.1, 0]), 0, "arc", "length 1.1"),
    "turn: past the wall": Case("lean", _arc(3, angle=20 * DEGREE), 3, "arc", "17.4576"),
    "turn: a whole step": Case("lean", _arc(3, angle=45 * DEGREE), 3, "arc", "17.4576"),
    "turn: short of the wall": Case("lean", _arc(3, angle=15 * DEGREE), 3, "arc", "17.4576"),
    "turn: begun off the grid": Case(
        "tilted", _arc(1, point=[0.0, 0, 0.5]), 1, "arc", "no rotation may begin"
    ),
    "slide: too far": Case("slide", _arc(0, translation=[0.6, 0, 0]), 0, "arc", "slides 0.5"),
    "slide: not far enough": Case("slide", _arc(0, translation=[0.4, 0, 0]), 0, "arc", "0.5"),
    "slide: into the wall": Case("slide", _arc(1, translation=[0.31, 0, 0]), 1, "arc", "0.3 along"),
    "slide: short of the wall": Case("slide", _arc(1, translation=[0.29, 0, 0]), 1, "arc", "0.3"),
    "slide: to the grid": Case("slide", _arc(1, translation=[0.5, 0, 0]), 1, "arc", "0.3"),
    "slide: askew": Case("slide", _arc(0, translation=[0.5, 1e-6, 0]), 0, "arc", "claimed"),
    "slide: out of the region": Case(
        "slide", _arc(0, translation=[0, 0.5, 0]), 0, "region", "leaves the region"
    ),
    "slide: up": Case("slide", _arc(0, translation=[0, 0, 0.5]), 0, "arc", "along +z"),
    "slide: nowhere": Case("slide", _arc(0, translation=[0, 0, 0]), 0, "arc", "slides 0"),
    "slides merged": Case("slide", _merge, 0, "arc", "slides 0.8 along +x"),
    "another kind: straight": Case("slide", put("steps.0.arc", STRAIGHT), 0, "arc", "straight"),
    "another kind: slide for turn": Case(
        "lean", _arc(0, translation=[0.5, 0, 0.5]), 0, "arc", "slides"
    ),
    "segments: one short": Case("lean", _segments(0, 2), 0, "segments", "exactly 3"),
    "segments: one more": Case("slide", _segments(0, 4), 0, "segments", "exactly 3"),
    "segments: of an early end": Case("slide", _segments(1, 3), 1, "segments", "exactly 2"),
    "segments: of an early end, short": Case("lean", _segments(3, 1), 3, "segments", "exactly 2"),
    "segments: none": Case("slide", _segments(0, 0), 0, "segments", "0 segments"),
    "goal: last arc missing": Case("lean", _pop(3), 2, "goal", "from the goal's place"),
    "goal: no steps": Case(
        "slide", _then_total(lambda d: d["steps"].clear()), None, "goal", "no steps"
    ),
    "cost": Case("slide", _then_total(put("steps.1.cost", 0.31)), 1, "cost", "(9)"),
    "z": Case("lean", _every_segment(3, z=20.0), 3, "z", "claimed"),
    "modes": Case(
        "slide", _every_segment(0, modes=["force", "force"], f_com=[1.0, 1.0]), 0, "best modes"
    ),
    "f_com": Case("slide", _every_segment(1, f_com=[-5.0, -5.0]), 1, "f_com"),
    "lifted finger": Case("lean", put("steps.2.finger", 1), 2, "lifted finger", "0 to 0"),
    "way: straight through": Case("lean", _way(), 2, "way", "meets the object"),
    "way: out on the other side": Case(
        "lean", _way([-1.0, 0, 0.5], [-1.0, 0, 3.0]), 2, "way", "meets the object"
    ),
    "way: in from the other side": Case(
        "lean", _way([1.55, 0, 3.0], [-1.0, 0, 3.0], [-1.0, 0, 0.5]), 2, "way", "meets the object"
    ),
    "regrasp: cost": Case("lean", _then_total(put("steps.2.cost", 1.0)), 2, "cost", "(10)"),
    "total": Case("slide", put("cost", 1.0), None, "cost", "add up"),
}


@pytest.mark.parametrize("name", CASES)
def test_tampering_is_refused(name: str) -> None:
    """The report names the step that was tampered with and the reason."""
    case = CASES[name]
    draft = json.loads(json.dumps(solved(case.scene)[1].to_dict()))
    case.tamper(draft)
    report = judged(Plan.model_validate_json(json.dumps(draft)), case.scene)
    assert not report.holds
    found = [v for v in report.violations if (v.step, v.topic) == (case.step, case.topic)]
    assert found, report.table()
    assert any(case.words in violation.message for violation in found), report.table()


def _other(scene: str, **changes: Any) -> Problem:
    """A scene with other values of its motion or its steps."""
    problem = solved(scene)[0]
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    given: dict[str, Any] = {"start": motion.start, "goal": motion.goal, "region": motion.region}
    given |= {key: value for key, value in changes.items() if key in given}
    changed = {key: value for key, value in changes.items() if key not in given}
    made = FreeMotion(**given, steps=replace(motion.steps, **changed))
    return replace(problem, motion=made)


OTHERS: dict[str, tuple[str, dict[str, Any], int, str, str]] = {
    "start": ("lean", {"start": Pose(np.eye(3), np.array([0.1, 0, 0.5]))}, 0, "start", "0.1 away"),
    "region": ("lean", {"region": [[-1, 0, 0], [2, 0, 0.7]]}, 0, "region", "0.7]"),
    "rotation step": ("lean", {"rotation": 30 * DEGREE}, 0, "arc", "turns 30 deg"),
    "translation step": ("slide", {"translation": 0.4}, 0, "arc", "slides 0.4"),
    "rotate": ("lean", {"rotate": np.array([[0, 0, 1.0]])}, 0, "arc", "about +z"),
    "depth": ("lean", {"depth": 2}, 3, "depth", "2 arcs from the start"),
    "shallow": ("slide", {"depth": 1}, 1, "depth", "the lattice's depth is 1"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_a_plan_for_another_motion_is_refused(name: str) -> None:
    """A plan does not hold for other starts, regions, steps and depths than its own."""
    scene, changes, step, topic, words = OTHERS[name]
    report = check_against(solved(scene)[1], Recheck(_other(scene, **changes)))
    found = [v.message for v in report.violations if (v.step, v.topic) == (step, topic)]
    assert any(words in message for message in found), report.table()


def test_a_deep_enough_lattice_holds_the_plan() -> None:
    """A depth of as many arcs as the plan has is enough."""
    assert check_against(solved("lean")[1], Recheck(_other("lean", depth=3))).holds


def test_another_goal_is_refused() -> None:
    """A goal elsewhere, or turned otherwise, is not met; how far off is said."""
    problem, plan = solved("lean")
    assert isinstance(problem.motion, FreeMotion)
    goal, off = problem.motion.goal, np.array([0.1, 0, 0])
    moved = replace(goal, low=goal.low + off, high=goal.high + off)
    report = check_against(plan, Recheck(_other("lean", goal=moved)))
    assert [v.topic for v in report.violations] == ["goal"]
    assert "0.1 from the goal's place" in report.violations[0].message
    report = check_against(plan, Recheck(_other("lean", goal=replace(goal, rotation=np.eye(3)))))
    assert [v.topic for v in report.violations] == ["goal"]
    assert "turned 107.458 deg" in report.violations[0].message
