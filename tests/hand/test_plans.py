"""Plans by a robot hand: they check, tampering is found, fingertips alone are too optimistic."""

from __future__ import annotations

import copy
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.app.planning import summary
from gm_ompl.arrays import Array
from gm_ompl.checking.second_hand import SecondHand
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.errors import PathError, ScenarioError
from gm_ompl.feasibility.judge import hand_reach
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, box
from gm_ompl.hand.files import read_hand
from gm_ompl.hand.model import HandModel
from gm_ompl.hand.packing import packed
from gm_ompl.hand.parsing import parsed
from gm_ompl.hand.paths import JointRefusal
from gm_ompl.hand.reach import HandReach
from gm_ompl.hand.shipped import shipped_hand
from gm_ompl.hand.spec import HandSpec
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.joint_paths import JointPlanner
from gm_ompl.planners.joint_regrasp import ArmRegrasps
from gm_ompl.planners.joint_transit import Transits
from gm_ompl.problem import Regrasp
from gm_ompl.scenario.document import dump
from gm_ompl.scenario.scenario import Scenario


def test_a_plan_with_joint_paths_holds(pushed: Plan) -> None:
    """Joint paths: limits, continuity, fingertips on their placements and clear links check."""
    assert pushed.status == "solved" and pushed.hand is not None
    assert len(pushed.hand.steps) == len(pushed.steps)
    report = gm_ompl.check(pushed)
    assert report.holds, report.table()
    assert {"joints", "limits", "fingertips", "links"} <= set(report.steps[0].checked)


def test_the_file_keeps_joint_paths(pushed: Plan, tmp_path: Any) -> None:
    """A plan that is saved and loaded has the same joint paths."""
    pushed.save(tmp_path / "plan.json")
    assert Plan.load(tmp_path / "plan.json").hand == pushed.hand


def test_claims_are_of_what_was_reached(pushed: Plan) -> None:
    """Optimal and infeasible are said over what inverse kinematics reached."""
    proven = pushed.model_copy(update={"optimal": True})
    none = pushed.model_copy(update={"status": "infeasible", "cost": None, "steps": ()})
    problem = problem_of(pushed)
    for plan in (proven, none):
        assert "over what inverse kinematics reached" in next(summary(plan, problem))
    unproven = pushed.model_copy(update={"optimal": False})
    assert "kinematics" not in next(summary(unproven, problem))


def turned(hand: dict[str, Any]) -> None:
    hand["steps"][1][1][0] += 0.05


def broken_off(hand: dict[str, Any]) -> None:
    hand["steps"][1][0] = hand["steps"][0][0]


def beyond(hand: dict[str, Any]) -> None:
    hand["approach"][1][2] = 0.1


def elsewhere(hand: dict[str, Any]) -> None:
    hand["approach"][0][0] += 0.1


def renamed(hand: dict[str, Any]) -> None:
    hand["joints"][0] = "thumb"


def shorter(hand: dict[str, Any]) -> None:
    hand["steps"].pop()


def never_home(hand: dict[str, Any]) -> None:
    hand["retreat"].pop()


@pytest.mark.parametrize(
    ("wrong", "topic"),
    [
        (turned, "fingertips"), (broken_off, "joints"), (beyond, "limits"), (elsewhere, "joints"),
        (renamed, "joints"), (shorter, "joints"), (never_home, "joints"),
    ],
)  # fmt: skip
def test_tampered_joint_paths_are_found(
    pushed: Plan, wrong: Callable[[dict[str, Any]], None], topic: str
) -> None:
    """Whatever is changed in joint paths is a violation of the right kind."""
    document = copy.deepcopy(pushed.to_dict())
    wrong(document["hand"])
    plan = Plan.model_validate(document, strict=False, by_alias=True, by_name=False)
    assert topic in {violation.topic for violation in gm_ompl.check(plan).violations}


def test_without_joint_paths_it_does_not_hold(pushed: Plan) -> None:
    """A scenario with a hand needs joint paths; one without has none."""
    assert not gm_ompl.check(pushed.model_copy(update={"hand": None})).holds
    scenario = {key: value for key, value in pushed.scenario.items() if key != "hand"}
    assert not gm_ompl.check(pushed.model_copy(update={"scenario": scenario})).holds


def test_fingertips_alone_plan_what_the_robot_cannot(push: Scenario, tree: dict[str, Any]) -> None:
    """Planned without ``hand``, a finger is put where the TriFinger's does not get to."""
    del tree["hand"]
    free = gm_ompl.plan(tree, "astar")
    problem = push.problem
    assert free.status == "solved" and problem.hand is not None
    reach, table = hand_reach(problem, problem.hand), problem.fingers.placements
    pose, first = problem.motion.pose(problem.start), free.steps[0].placements
    rows = [record.row(table) for record in first]
    found = [reach.configuration(pose, i, row) for i, row in enumerate(rows) if row is not None]
    assert any(q is None for q in found)


def test_a_library_user_gets_joint_paths(push: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """A plan from OMPL's own planner has joint paths that check, or is refused by name."""
    setup = gm_ompl.setup(push, "HybridRRTConnect", seed=1)
    setup.solve(20.0)
    plan = gm_ompl.plan_from(setup)
    assert plan.hand is not None and gm_ompl.check(plan).holds
    refusal = JointRefusal(0, 0.5, 1, "is out of reach")
    monkeypatch.setattr(JointPlanner, "paths", lambda *_: refusal)
    with pytest.raises(PathError, match="finger 1 is out of reach, in step 0"):
        gm_ompl.plan_from(setup)


ROBOTS = ["trifinger-push", "trifinger-flip", "trifinger-clutter", "arm-tumble"]


@pytest.mark.parametrize("name", ROBOTS)
def test_each_robot_plans(name: str) -> None:
    """HybridRRTConnect finds a plan whose joint paths check, whichever the robot."""
    plan = gm_ompl.plan(f"robot/{name}", "HybridRRTConnect", seed=1)
    assert plan.status == "solved" and plan.hand is not None
    report = gm_ompl.check(plan)
    assert report.holds, report.table()


def test_what_joints_refuse_is_told() -> None:
    """A plan found after others were refused says how many, and is not called optimal."""
    plan = gm_ompl.plan("robot/trifinger-flip", "HybridRRTConnect", seed=0)
    told = plan.statistics.model_extra or {}
    if told.get("joint_refusals"):
        assert "finger" in str(told["last_refusal"]) and not plan.optimal


def test_pages_show_the_links(pushed: Plan) -> None:
    """The viewer has a node per solid link, and where each is in every joint row."""
    pytest.importorskip("meshcat")
    from gm_ompl.viz.animation import animate
    from gm_ompl.viz.scene import scene_messages
    from gm_ompl.viz.score import score

    animation = animate(pushed)
    told = score(animation, scene_messages(animation))["links"]
    assert pushed.hand is not None and len(told) == len(pushed.steps)
    assert [len(rows) for rows in told] == [len(rows) for rows in pushed.hand.steps]
    assert {len(row) for rows in told for row in rows} == {len(animation.links)} == {12}


def test_the_same_seed_gives_the_same_joints(push: Scenario, pushed: Plan) -> None:
    """Joint paths are repeatable."""
    again = gm_ompl.plan(push, "HybridRRTConnect", seed=1)
    assert again.hand is not None and pushed.hand is not None
    rows = [row for step in again.hand.steps for row in step]
    assert np.array(rows).shape[1] == 9
    assert again.hand == pushed.hand


def own_hand(folder: Path, kind: str) -> dict[str, Any]:
    """A hand of one's own in ``folder``: the TriFinger's URDF, or an MJCF in three files."""
    shipped = shipped_hand("trifinger")
    if kind == "urdf":
        text = shipped.path().read_text(encoding="utf-8")
        (folder / "my hand.urdf").write_text(text, encoding="utf-8")
        name = "my hand.urdf"
    else:
        (folder / "parts").mkdir()
        model = parsed(shipped.path(), read_hand(shipped.path(), {}).text)
        whole = model.to_xml().replace("<compiler ", '<compiler meshdir="parts" ', 1)
        for mesh in model.meshes:
            (folder / "parts" / Path(mesh.file).name).write_bytes(Path(mesh.file).read_bytes())
            whole = whole.replace(mesh.file, Path(mesh.file).name)
        assets = whole[whole.index("<asset>") : whole.index("</asset>") + len("</asset>")]
        (folder / "assets.xml").write_text(f"<mujoco>{assets}</mujoco>", encoding="utf-8")
        text = whole.replace(assets, '<include file="assets.xml"/>')
        (folder / "hand.xml").write_text(text, encoding="utf-8")
        name = "hand.xml"
    tips = [{"link": link} for link in shipped.tips]
    assert isinstance(shipped.torque, float)
    return {"file": name, "tips": tips, "torque": shipped.torque, "speed": 2.0}


@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_a_plan_needs_no_file_of_its_hand(
    kind: str, push: Scenario, tree: dict[str, Any], tmp_path: Path
) -> None:
    """The hand's file is gone, and the plan's scenario is the same; so is what it says again."""
    hand = own_hand(tmp_path, kind)
    assert push.problem.hand is not None
    names, angles = push.problem.hand.joints, push.problem.hand.home.tolist()
    hand["home"] = {n: f"{a} rad" for n, a in zip(names, angles, strict=True)}
    tree["hand"] = hand
    file = tmp_path / "own.yaml"
    file.write_text(dump(tree), encoding="utf-8")
    scenario = gm_ompl.load(str(file))
    resolved = scenario.resolved()
    shutil.rmtree(tmp_path)
    again = Scenario.from_resolved(resolved)
    assert again.resolved() == resolved
    assert str(tmp_path) not in str(resolved)
    first, second = push.problem.hand, again.problem.hand
    assert second is not None and second.joints == first.joints
    for one, other in zip((first, second), (HandModel, SecondHand), strict=True):
        model = other(one, push.problem.body, [], True)
        model.place(one.home)
        assert model.tips() == pytest.approx(reference_tips(first), abs=1e-6)


def reference_tips(spec: HandSpec) -> Any:
    """The fingertips at home."""
    model = HandModel(spec, box_body(), [], True)
    model.place(spec.home)
    return model.tips()


def box_body() -> Body:
    """Any object."""
    return Body((box([-0.03] * 3, [0.03] * 3),))


def test_a_damaged_hand_is_refused(tree: dict[str, Any]) -> None:
    """What a plan keeps of a hand is text that anyone may change."""
    files = packed(shipped_hand("arm-hand").path(), {})
    for name, content in (("arm-hand.xml", "AAAA"), ("../arm-hand.xml", files["arm-hand.xml"])):
        tree["hand"] = {"file": name, "files": {name: content}, "torque": 1, "speed": 1}
        with pytest.raises(ScenarioError, match="damaged"):
            gm_ompl.load(tree)


def together(reach: HandReach, targets: Array, pose: Pose) -> Array:
    """A configuration with both fingertips where they are asked for, nothing hit."""
    every, home = np.ones(11, dtype=bool), reach.model.spec.home
    for i in (0, 1):
        for q in reach.kinematics.solutions(i, targets[i], home):
            whole = reach.kinematics.follow(q, (0, 1), targets, every)
            if whole is not None:
                reach.model.place(whole, pose)
                if reach.model.hit(reach.touch) is None:
                    return whole
    pytest.fail("there is none")


def test_an_arm_moves_while_the_other_finger_holds() -> None:
    """In a regrasp with the arm it moves, who holds stays within a micrometre, nothing is hit."""
    few = ["fingers.placements.margin=0", "fingers.placements.grid=[5, 5]"]
    problem = gm_ompl.load("robot/arm-tumble", few).problem
    table, pose = problem.fingers.placements, problem.motion.pose(problem.start)
    cells = ("+y", (2, 2)), ("-y", (2, 2)), ("-y", (2, 3))
    first, before, after = (row for row in (table.find(*c) for c in cells) if row is not None)
    decision = ModeDecision(Outcome.STABLE, 1.0, (ControlMode.POSITION,), (None,))
    move = Regrasp(pose, (), 1, after, (first, before), decision, 1.0)
    assert problem.hand is not None
    reach = hand_reach(problem, problem.hand)
    model, rng = reach.model, np.random.default_rng(0)
    start = together(reach, pose.apply(problem.fingers.centres((first, before))), pose)
    arm = ArmRegrasps(reach, Transits(reach, problem.fingers, rng), rng)
    rows = next(arm.ways(move, start))
    assert np.ptp(rows[:, :5], axis=0).max() > 0.1
    tips = []
    for q in rows:
        model.place(q, pose)
        assert model.hit(reach.touch) is None
        tips.append(model.tips())
    held = np.array(tips)[:, 0]
    assert np.abs(held - held[0]).max() <= 1e-6
    ends = pose.apply(problem.fingers.centres((before, after)))
    assert np.array(tips)[[0, -1], 1] == pytest.approx(ends, abs=1e-6)


def test_a_plan_with_an_arm_s_regrasps_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no finger regrasps by its own hinges, the arm's move, and the plan checks."""
    monkeypatch.setattr(JointPlanner, "_alone", lambda *_: iter(()))
    here, there = ({"face": "-y", "cell": [k, k]} for k in (1, 2))
    change = {
        "fingers.start": [{"face": "+y", "cell": [1, 1]}, here],
        "fingers.goal": ["any", there],
        "lattice.segments": 6,
    }
    plan = gm_ompl.plan(gm_ompl.load("robot/arm-tumble").with_(change), "HybridRRTConnect", seed=1)
    assert plan.hand is not None and plan.regrasps
    moved = [
        np.ptp(np.array(rows)[:, :5], axis=0).max()
        for step, rows in zip(plan.steps, plan.hand.steps, strict=True)
        if step.kind == "regrasp"
    ]
    assert min(moved) > 0.01
    report = gm_ompl.check(plan)
    assert report.holds, report.table()
