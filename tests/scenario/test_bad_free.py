"""Bad free scenarios: every mistake is one line with file, line, key and remedy; exit code 2."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gm_ompl.app.main import app
from gm_ompl.errors import ScenarioError
from tests.scenario.bad import Bad, LoadChanged

PLACE = "    position: [5, 0, 1.5]\n"
TURN = "    rotation: {axis: [0, 1, 0], angle: 90 deg}\n"
WITHIN = "    within: {position: 0.1, rotation: 1 deg}\n"
GOAL = "  goal:\n" + PLACE + TURN + WITHIN
STEPS = "{translation: 0.5, rotation: 15 deg}"
Z, WR, SR = "motion.goal.position.2", "motion.goal.within.rotation", "motion.start.rotation"
LST, LSR = "lattice.steps.translation", "lattice.steps.rotation"

CASES = [
    # Exactly one kind of motion.
    Bad("  free:", "  path: [{slide: {by: [1, 0, 0]}}]\n  free:", 11, "motion",
        "given: path and free"),
    Bad("  free:", "  planar: {x: [0, 1], y: [0, 1], yaw: [0 deg, 9 deg]}\n  free:", 11, "motion",
        "given: planar and free"),
    Bad("  free:", "  fre:", 12, "motion.fre", "did you mean 'free'?"),
    # What it may do.
    Bad("translate:", "translat:", 12, "motion.free.translat", "did you mean 'translate'?"),
    Bad("[x, z]", "[x, x]", 12, "motion.free.translate.1", "given twice"),
    Bad("[x, z]", "[]", 12, "motion.free.translate", "at least 1 entry"),
    Bad("[x, z]", "any", 12, "motion.free.translate", "list in square brackets"),
    Bad("[x, z]", "[x, yaw]", 12, "motion.free.translate.1", "must be 'x', 'y' or 'z'"),
    Bad("[y]", "[y, y]", 12, "motion.free.rotate.1", "given twice"),
    Bad("[y]", "y", 12, "motion.free.rotate", "must be any, or a list of axes, for example [y]"),
    Bad("[y]", "[-y]", 12, "motion.free.rotate.0", "did you mean 'y'?"),
    Bad("[y]", "[[0, 1, 0]]", 12, "motion.free.rotate.0", "must be 'x', 'y' or 'z'"),
    Bad("rotate: [y]", "steps: " + STEPS, 12, "motion.free.steps", "keys here: region"),
    Bad("region: {x: [-4, 8], y: [0, 0], z: [0, 4]}, ", "", 12, "motion.free.region",
        "for example region: {x: [-2, 20]"),
    Bad(", z: [0, 4]", "", 12, "motion.free.region.z", "for example z: [0, 10]"),
    Bad("x: [-4, 8]", "x: [8, -4]", 12, "motion.free.region.x", "first must not exceed the second"),
    Bad("x: [-4, 8]", "x: 3", 12, "motion.free.region.x", "list in square brackets"),
    Bad("x: [-4, 8]", "x: [-4, 8], yaw: [0 deg, 9 deg]", 12, "motion.free.region.yaw",
        "keys here: x, y, z"),
    # Start and goal against the region and what stands there.
    Bad("x: [-4, 8]", "x: [1, 8]", 13, "motion.start.position.0", "outside motion.free.region.x"),
    Bad("z: [0, 4]", "z: [1, 4]", 13, "motion.start.position.2", "outside motion.free.region.z"),
    Bad("[0, 0, rest]", "[0, 0, 0.1]", 13, "motion.start", "penetrates the floor"),
    Bad("[0, 0, rest]", "[0, 0, rest], within: {position: 1}", 13, "motion.start.within",
        "keys here: position, yaw, rotation"),
    Bad("[0, 0, rest]", "[0, 0, rest], rotation: any", 13, SR, "mapping of keys"),
    Bad("x: [-4, 8]", "x: [-4, 3]", 15, "motion.goal.position.0", "outside motion.free.region.x"),
    Bad("[5, 0, 1.5]", "[5, 0.2, 1.5]", 15, "motion.goal.position.1",
        "by more than the goal's within.position, 0.1"),
    Bad("[5, 0, 1.5]", "[5, 0, 1]", 14, "motion.goal", "penetrates obstacle 'step'"),
    # The goal.
    Bad(GOAL, "", 11, "motion.goal", "for example goal: {position: [1, 0, rest]}"),
    Bad(GOAL, "  goal: {}\n", 14, "motion.goal.position", "missing; add it"),
    Bad(GOAL, "  goal: {within: {position: 1}}\n", 14, "motion.goal", "neither a place nor"),
    Bad(GOAL, "  goal: {rotation: any}\n", 14, "motion.goal", "neither a place nor"),
    Bad("    position", "    positon", 15, "motion.goal.positon", "did you mean 'position'?"),
    Bad("[5, 0, 1.5]", "[rest, 0, 1]", 15, "motion.goal.position.0", "only the third"),
    Bad(TURN, "    rotation: 90 deg\n", 16, "motion.goal.rotation", "must be any, or one of {axis"),
    Bad("{axis: [0, 1, 0], angle: 90 deg}", "{axis: [0, 1, 0]}", 16, "motion.goal.rotation",
        "must be one of {axis"),
    Bad("{axis: [0, 1, 0]", "{axis: [0, 0, 0]", 16, "motion.goal.rotation", "not be all zeros"),
    Bad(TURN, TURN + "    up: z\n", 17, "motion.goal.up", "give only one of rotation, yaw, up"),
    Bad(TURN, TURN + "    yaw: 0 deg\n", 17, "motion.goal.yaw", "given: rotation and yaw"),
    Bad(TURN, "    up: w\n", 16, "motion.goal.up", "must be 'x'"),
    Bad(PLACE + TURN, "    position: [5, 0, rest]\n    up: z\n", 15, Z,
        "which up leaves open"),
    Bad(PLACE + TURN, "    position: [5, 0, rest]\n    rotation: any\n", 15, Z,
        "which rotation leaves open"),
    Bad(PLACE, "    x: [6, 5]\n", 15, "motion.goal.x", "the first must not exceed the second"),
    Bad(PLACE, "    x: [9, 10]\n", 15, "motion.goal.x", "outside motion.free.region.x"),
    Bad(PLACE, PLACE + "    x: [5, 6]\n", 16, "motion.goal.x", "does not go with the other keys"),
    Bad(PLACE + TURN, "    x: [5, 6]\n    yaw: any\n", 16, "motion.goal.yaw", "write up: +z"),
    Bad(PLACE + TURN, "    x: [5, 6]\n    yaw: [0 deg, 9 deg]\n", 16, "motion.goal.yaw", "one"),
    Bad("{position: 0.1,", "{position: 0,", 17, "motion.goal.within.position", "must be > 0"),
    Bad("rotation: 1 deg}", "rotation: 0 deg}", 17, WR, "must be > 0 deg"),
    Bad("rotation: 1 deg}", "rotation: 200 deg}", 17, WR, "rotation: any"),
    Bad("rotation: 1 deg}", "rotation: 1}", 17, WR, "with its unit"),
    Bad("{position: 0.1, rotation: 1 deg}", "0.1", 17, "motion.goal.within", "mapping of keys"),
    # The lattice.
    Bad("{steps: " + STEPS + "}", "{segments: 30}", 18, "lattice.segments", "use steps: {"),
    Bad("{steps: " + STEPS + "}", "{depth: 3}", 18, "lattice.steps", "example steps: {"),
    Bad(STEPS, "{x: 0.5, y: 0.5, yaw: 5 deg}", 18, "lattice.steps.x", "x, y, yaw are for planar"),
    Bad(STEPS, "{translation: 0.5}", 18, LSR, "for example rotation: 15 deg"),
    Bad("translation: 0.5", "translation: 0", 18, LST, "must be > 0"),
    Bad("translation: 0.5", "translation: 1e-8", 18, LST, "make it larger"),
    Bad("translation: 0.5", "translation: 1e-4", 18, LST, "at least 0.0003"),
    Bad("rotation: 15 deg", "rotation: 7 deg", 18, LSR, "must divide a full turn"),
    Bad("rotation: 15 deg", "rotation: -15 deg", 18, LSR, "must be > 0 deg"),
    Bad("rotation: 15 deg", "rotation: 270 deg", 18, LSR, "at most 180 deg"),
    Bad("rotation: 15 deg", "rotation: 0.001 deg", 18, LSR, "at least 0.00573 deg"),
    Bad("rotation: 15 deg", "rotation: 15", 18, LSR, "with its unit"),
    Bad(STEPS, STEPS + ", depth: 0", 18, "lattice.depth", "must be >= 1"),
    Bad(STEPS, STEPS + ", depth: 1.5", 18, "lattice.depth", "whole number"),
    Bad(STEPS, STEPS + ", dept: 3", 18, "lattice.dept", "did you mean 'depth'?"),
]  # fmt: skip

POSE = "{position: [12, 6, 2.5], yaw: 90 deg}"

ELSEWHERE = [
    ("path", "{segments: 30}", "{segments: 30, depth: 3}", "value 3: only for free motion"),
    ("path", "{segments: 30}", "{steps: " + STEPS + "}", "free motion; use segments"),
    ("planar", "yaw: 5 deg}}", "yaw: 5 deg}, depth: 4}", "value 4: only for free motion"),
    ("planar", "{x: 0.5, y: 0.5, yaw: 5 deg}", STEPS, "translation, rotation are for free motion"),
    ("planar", "{x: 0.5, y: 0.5, yaw: 5 deg}", "{x: 0.5, y: 0.5}", "lattice.steps.yaw: missing"),
    ("planar", "yaw: 90 deg}", "yaw: 90 deg, within: {position: 1}}", "goal.within: only for free"),
    ("planar", "yaw: 90 deg}", "up: z}", "motion.goal.up: only for free motion"),
    ("planar", "yaw: 90 deg}", "rotation: any}", "a planar goal region has yaw: any"),
    ("planar", POSE, "{x: [1, 2], y: [1, 2], z: [0, 3]}", "planar motion keeps its height"),
    ("planar", POSE, "{x: [1, 2], y: [1, 2], yaw: 30 deg}", "must be 'any' or a range"),
    ("planar", POSE, "{x: [1, 2], y: [1, 2], rotation: {yaw: 9 deg}}",
        "a planar goal region has yaw, a range"),
    ("planar", POSE, "{x: [1, 2]}", "motion.goal.y: missing"),
    ("planar", POSE, "{yaw: 30 deg}", "motion.goal.position: missing"),
]  # fmt: skip


@pytest.mark.parametrize("bad", CASES, ids=lambda bad: f"{bad.key}-{bad.new.strip()[:25]}")
def test_a_mistake_is_named_with_line_key_and_remedy(bad: Bad, load_changed: LoadChanged) -> None:
    """Each of these changes to a valid free scenario gives one line that says how to mend it."""
    with pytest.raises(ScenarioError) as caught:
        load_changed("free", bad.old, bad.new)
    (problem,) = caught.value.problems
    assert re.match(rf"\S*scenario\.yaml:{bad.line}:\d+: {re.escape(bad.key)}: ", problem), problem
    assert bad.remedy in problem
    assert "\n" not in problem


@pytest.mark.parametrize(("which", "old", "new", "text"), ELSEWHERE, ids=lambda part: part[:30])
def test_keys_of_free_motion_elsewhere(
    which: str, old: str, new: str, text: str, load_changed: LoadChanged
) -> None:
    """With a path or planar motion they are named, with what that motion has instead."""
    with pytest.raises(ScenarioError) as caught:
        load_changed(which, old, new)
    assert text in caught.value.problems[0]
    assert len(caught.value.problems) <= 2


def test_the_command_ends_with_2(texts: dict[str, str], tmp_path: Path) -> None:
    """On the command line such a mistake is bad input."""
    file = tmp_path / "scenario.yaml"
    file.write_text(texts["free"].replace("[x, z]", "[x, x]"), encoding="utf-8")
    ended = CliRunner().invoke(app, ["plan", str(file)])
    assert ended.exit_code == 2
    assert "motion.free.translate.1" in ended.stderr
