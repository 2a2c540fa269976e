"""Thirty kinds of bad mesh, rotation and mapping, typed on the command line: 2, and what to do."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from gm_ompl.app.main import app

CORNERS = "[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]"
OUTWARD = "[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]"
TURN = "motion.start.rotation"
WALL = "{box: {min: [9, 9, 0], max: [10, 10, 1]}"


def mesh(vertices: str = CORNERS, faces: str = OUTWARD) -> str:
    """The change that puts a mesh in the place of the shape; a tetrahedron as it stands."""
    return f"object.shape={{mesh: {{vertices: [{vertices}], faces: [{faces}]}}}}"


def file(keys: str) -> str:
    """The change that puts a mesh file with some keys there."""
    return f"object.shape={{mesh: {keys}}}"


KINDS: dict[str, tuple[str, str]] = {
    # Meshes.
    "open": (mesh(faces="[0, 2, 1], [0, 1, 3], [1, 2, 3]"), "at least 4"),
    "inside out": (mesh(faces="[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]"), "turn"),
    "a vertex that is not there": (
        mesh(faces="[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 9]"), "numbered from 0"),
    "a corner of two numbers": (
        mesh("[0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]"), "at least 3 entries"),
    "a triangle of four": (mesh(faces="[0, 2, 1, 3], [0, 1, 3], [1, 2, 3], [0, 3, 2]"), "3 "),
    "half a corner": (mesh(faces="[0, 2, 0.5], [0, 1, 3], [1, 2, 3], [0, 3, 2]"), "whole number"),
    "words for numbers": (mesh("[a, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]"), "number"),
    "no faces": (file(f"{{vertices: [{CORNERS}]}}"), "faces"),
    "flat": (mesh("[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]"), "give it a thickness"),
    "no such file": (file("nowhere.stl"), "no such file"),
    "another format": (file("part.step"), "ends in .stl"),
    "two shapes": (file("nowhere.stl, box: [1, 1, 1]"), "exactly one of"),
    "a scale of nothing": (file("nowhere.stl, scale: 0"), "> 0"),
    "a word for convex": (file("nowhere.stl, convex: hulls"), "did you mean 'hull'"),
    # Rotations.
    "no axis": (f"{TURN}={{axis: [0, 0, 0], angle: 90 deg}}", "zeros"),
    "an axis alone": (f"{TURN}={{axis: [0, 0, 1]}}", "angle: 90 deg"),
    "an angle without unit": (f"{TURN}={{axis: [0, 0, 1], angle: 90}}", "unit"),
    "an angle alone": (f"{TURN}={{angle: 90 deg}}", "axis"),
    "a quaternion of three": (f"{TURN}={{quaternion: [1, 0, 0]}}", "4"),
    "a quaternion of nothing": (f"{TURN}={{quaternion: [0, 0, 0, 0]}}", "zeros"),
    "two ways at once": (f"{TURN}={{yaw: 30 deg, quaternion: [1, 0, 0, 0]}}", "one of"),
    "no way at all": (f"{TURN}={{}}", "yaw"),
    "a number": (f"{TURN}=30", "mapping"),
    "an unknown way": (f"{TURN}={{roll: 30 deg}}", "roll"),
    "an obstacle's": (f"environment.obstacles.wall={WALL}, rotation: {{yaw: 30}}}}", "unit"),
    "beside yaw": (
        "motion.start={position: [0, 0, rest], yaw: 10 deg, rotation: {yaw: 30 deg}}", "either"),
    # Mappings.
    "a list for a mapping": ("friction=[0.5, 0.7]", "mapping"),
    "a mapping for a number": ("object.mass={kg: 1}", "number"),
    "a mapping for a list": ("fingers.placements.grid={x: 3, y: 3}", "list"),
    "a key misspelt": ("friction.fingre=0.5", "did you mean"),
    "a key of another place": ("mechanics.gravity=9.8", "gravity"),
    "a key that is missing": ("object={mass: 1}", "shape"),
    "a list's item that is not there": ("motion.path.7.slide.by=[1, 0, 0]", "7"),
    "a list for names": (f"environment.obstacles=[{WALL}}}]", "mapping"),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_bad_value_ends_with_2_and_a_remedy(kind: str) -> None:
    """Nothing is planned; the message names the key and says what would be right."""
    change, remedy = KINDS[kind]
    command = ["plan", "paper/slide", "--set", change, "--max-iterations", "1"]
    ended = CliRunner().invoke(app, command)
    assert ended.exit_code == 2, ended.output
    assert ended.stdout == ""
    key = change.partition("=")[0].split(".")[-1]
    assert key in ended.stderr
    assert remedy in ended.stderr
    assert "internal error" not in ended.stderr


def test_the_same_in_json() -> None:
    """A program that reads the answer finds message and exit code there."""
    change = KINDS["inside out"][0]
    ended = CliRunner().invoke(app, ["plan", "paper/slide", "--set", change, "--json"])
    told = json.loads(ended.stdout)
    assert told["exit_code"] == ended.exit_code == 2
    assert "turn its triangles around" in told["error"]


def test_there_are_thirty_kinds() -> None:
    """And none of them twice."""
    assert len(KINDS) >= 30
    assert len({change for change, _ in KINDS.values()}) == len(KINDS)
