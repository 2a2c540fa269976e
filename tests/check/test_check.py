"""``check`` confirms what is right, says what it judged, and stands apart from the planners."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from gm_ompl.checking import check
from gm_ompl.checking.coordinates import crossed, gap, in_goal, lattice_steps, outside
from gm_ompl.checking.remembered import mechanics
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario

Draft = dict[str, Any]


def test_a_right_plan_holds(hand_plan: Plan) -> None:
    """A plan whose every claim is right has no violation, and each step says what was judged."""
    report = check(hand_plan)
    assert report.holds, report.table()
    assert [step.kind for step in report.steps] == [step.kind for step in hand_plan.steps]
    for step in report.steps:
        assert {"placements", "geometry", "modes", "f_com", "z", "z_min", "cost"} <= set(
            step.checked
        )
        assert step.holds
        assert step.z is not None
    assert "start" in report.steps[0].checked
    assert "goal" in report.steps[-1].checked
    assert "the plan holds" in report.table()


def test_a_saved_plan_holds(hand_plan: Plan, tmp_path: Path) -> None:
    """A plan holds from its file as it does from memory."""
    file = tmp_path / "plan.json"
    hand_plan.save(file)
    assert check(file) == check(hand_plan)


def test_the_documented_example_holds() -> None:
    """The worked example of the plan file's page is a plan that holds."""
    page = Path(__file__).parents[2] / "docs" / "reference" / "plan.md"
    blocks = re.findall(r"```json\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    top, *steps = (json.loads(block) for block in blocks)
    report = check(Plan.model_validate_json(json.dumps({**top, "steps": steps})))
    assert report.holds, report.table()


def test_recomputed_numbers_are_the_plan_s(hand_plan: Plan) -> None:
    """The report's cost and least z are those that the plan states, found another way."""
    for step, judged in zip(hand_plan.steps, check(hand_plan).steps, strict=True):
        least = step.z if step.kind == "regrasp" else min(part.z for part in step.segments)
        assert judged.z == pytest.approx(least, rel=1e-6)
        assert judged.cost == pytest.approx(step.cost, rel=1e-9)


def test_the_report_is_plain_data(hand_plan: Plan) -> None:
    """The report can be written as JSON without loss."""
    report = check(hand_plan).to_dict()
    assert json.loads(json.dumps(report, allow_nan=False)) == report
    assert report["holds"] is True


@pytest.mark.parametrize("status", ["infeasible", "budget", "interrupted"])
def test_no_plan_is_consistent(draft: Draft, status: str) -> None:
    """A file that says why there is no plan holds, and the report says what that means."""
    draft.update(status=status, steps=[], cost=None, regrasps=None)
    report = check(Plan.model_validate_json(json.dumps(draft)))
    assert report.holds
    assert "not proven" in report.notes[0]


@pytest.mark.parametrize("status", ["infeasible", "budget"])
def test_no_plan_with_totals_is_refused(draft: Draft, status: str) -> None:
    """Without a plan there is no cost, no regrasps and nothing optimal."""
    draft.update(status=status, steps=[], optimal=True)
    messages = [v.message for v in check(Plan.model_validate_json(json.dumps(draft))).violations]
    assert len(messages) == 3
    assert all("status is" in message for message in messages)


def test_arcs_over_half_a_lattice_step_hold(author: Any, draft: Draft) -> None:
    """An arc over a part of a lattice step has the segments of a whole one."""
    problem = author.problem
    first = draft["steps"][0]
    half = json.loads(json.dumps(first))
    middle = problem.motion.pose((0.125,))
    pose = {"position": middle.position.tolist(), "quaternion": middle.quaternion().tolist()}
    half.update({"from": [0.125], "pose_from": pose})
    first.update(to=[0.125], pose_to=pose)
    for step in (first, half):
        step["cost"] /= 2
        step["arc"] = {"translation": [1.0, 0.0, 0.0]}
    draft["steps"][0:1] = [first, half]
    report = check(Plan.model_validate_json(json.dumps(draft)))
    assert report.holds, report.table()


def test_an_arc_over_several_lattice_steps_holds(draft: Draft) -> None:
    """One arc over two lattice steps, with the segments of both, is as good as two arcs."""
    first, second = draft["steps"][0], draft["steps"].pop(1)
    first.update(to=second["to"], pose_to=second["pose_to"], cost=first["cost"] + second["cost"])
    first["segments"] += second["segments"]
    first["arc"] = {"translation": [4.0, 0.0, 0.0]}
    report = check(Plan.model_validate_json(json.dumps(draft)))
    assert report.holds, report.table()


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_verdicts_do_not_depend_on_units(draft: Draft, scale: float) -> None:
    """The same plan in other units of force holds, and the same relative lie is found."""
    scenario = draft["scenario"]
    scenario["object"]["mass"] *= scale
    scenario["mechanics"]["z_min"] *= scale
    scenario["cost"]["stability"] *= scale
    limits = scenario["fingers"]["max_normal_force"]
    scenario["fingers"]["max_normal_force"] = [value * scale for value in limits]
    for part in [s for step in draft["steps"] for s in step.get("segments", [step])]:
        part["z"] *= scale
        part["f_com"] = [None if f is None else f * scale for f in part["f_com"]]
    report = check(Plan.model_validate_json(json.dumps(draft)))
    assert report.holds, report.table()
    draft["steps"][0]["segments"][0]["z"] *= 1 + 1e-5
    report = check(Plan.model_validate_json(json.dumps(draft)))
    assert {(v.step, v.segment, v.topic) for v in report.violations} == {(0, 0, "z")}


def test_equal_states_are_decided_once(hand_plan: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    """For nine segments along two slides matrices are made once per slide and hand."""
    calls: list[object] = []

    def counting(instant: Any) -> Any:
        calls.append(instant)
        return mechanics(instant)

    # By module object: gm_ompl.check, as an attribute, is the public function.
    recheck = importlib.import_module("gm_ompl.checking.recheck")
    monkeypatch.setattr(recheck, "mechanics", counting)
    assert check(hand_plan).holds
    # Along x and along y; at rest without the finger that is lifted.
    assert len(calls) == 3


FORBIDDEN = ("mechanics", "feasibility", "graph", "planners", "app", "api")


def test_the_check_imports_no_planner() -> None:
    """No file of the check imports the planning kernel, the graph or a planner."""
    folder = Path(inspect.getfile(check)).parent
    for file in folder.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0
                names = [node.module or ""]
            for name in names:
                assert not name.startswith(tuple(f"gm_ompl.{part}" for part in FORBIDDEN)), file


def test_checking_loads_no_kernel(hand_plan: Plan, tmp_path: Path) -> None:
    """A whole check runs without the planning kernel, the planners or numba in the process."""
    file = tmp_path / "plan.json"
    hand_plan.save(file)
    program = (
        "import sys; from gm_ompl.checking import check; "
        f"assert check({str(file)!r}).holds; "
        "bad = [m for m in sys.modules if m.split('.')[0] in ('numba', 'ompl') or "
        "m.startswith(tuple('gm_ompl.' + p for p in ('mechanics', 'feasibility', 'graph', "
        "'planners')))]; assert not bad, bad"
    )
    ended = subprocess.run(
        [sys.executable, "-P", "-c", program], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr


def test_coordinates_on_a_path(problem: Problem) -> None:
    """Lattice steps, bounds and piece boundaries of two pieces with 2 and 1 segments."""
    assert lattice_steps(problem, (0.0,), (0.25,)) == pytest.approx(1.0)
    assert lattice_steps(problem, (0.25,), (1.0,)) == pytest.approx(2.0)
    assert lattice_steps(problem, (0.75,), (0.5,)) == pytest.approx(0.5)
    assert crossed(problem, (0.25,), (0.5,), 1e-9) is None
    assert crossed(problem, (0.6,), (0.4,), 1e-9) == 0.5
    assert outside(problem, (1.25,)) == pytest.approx(0.25)
    assert outside(problem, (0.5,)) <= 0.0
    assert gap(problem, (0.5,), (0.5, 0.0)) == math.inf


PLANAR = {
    "format": "gm-ompl-scenario/1",
    "name": "test/planar",
    "object": {"shape": {"box": [5, 10, 5]}, "mass": 1},
    "friction": {"environment": 0.5, "finger": 0.7},
    "gravity": 9.8,
    "fingers": {"count": 1, "radius": 1, "max_normal_force": 10},
    "motion": {
        "start": {"position": [0, 0, 2.5], "yaw": "0 deg"},
        "planar": {"x": [-2, 20], "y": [-10, 10], "yaw": ["-180 deg", "180 deg"]},
        "goal": {"x": [11, 13], "y": [5, 7], "yaw": ["170 deg", "200 deg"]},
    },
    "lattice": {"steps": {"x": 0.5, "y": 0.5, "yaw": "5 deg"}},
}


def test_coordinates_that_wrap() -> None:
    """Yaw is compared up to whole turns, has no bounds, and steps are counted across the seam."""
    problem = Scenario.from_resolved(PLANAR).problem
    turn, degree = 2 * math.pi, math.pi / 180
    assert gap(problem, (1.0, 2.0, 3.0), (1.0, 2.0, 3.0 - turn)) == pytest.approx(0.0, abs=1e-15)
    assert gap(problem, (1.0, 2.0, 3.0), (1.0, 2.0, 3.1)) == pytest.approx(0.1 / turn)
    assert outside(problem, (0.0, 0.0, 7.0)) <= 0.0
    assert outside(problem, (0.0, 0.0, 1e300)) > 0.0
    assert outside(problem, (-3.0, 0.0, 0.0)) == pytest.approx(1 / 22)
    start, end = (0.0, 0.0, 175 * degree), (0.0, 0.0, 190 * degree)
    assert lattice_steps(problem, start, end) == pytest.approx(3.0)
    assert lattice_steps(problem, (0.0, 0.0, 0.0), (1.0, 2.0, 5 * degree)) == pytest.approx(4.0)
    assert in_goal(problem, (12.0, 6.0, -175 * degree), 1e-9)
    assert not in_goal(problem, (12.0, 6.0, -155 * degree), 1e-9)
    assert not in_goal(problem, (13.1, 6.0, 175 * degree), 1e-9)
