"""``gm-ompl inspect``: a shape in numbers, against what is known of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from gm_ompl.app.main import app
from gm_ompl.geometry.hulls import resting_poses
from gm_ompl.geometry.solids import Body, at_centre_of_mass, hull
from gm_ompl.scenario.inspection import inspect
from gm_ompl.scenario.scenario import Scenario
from tests.moved import parts


def test_a_box_in_numbers(tmp_path: Path) -> None:
    """Size, volume, inertia, six ways to lie with their heights and tilts, one piece, six faces."""
    file, page = tmp_path / "box.glb", tmp_path / "box.html"
    mesh = trimesh.creation.box([2.0, 4.0, 6.0])
    mesh.apply_translation([1.0, 2.0, 3.0])
    mesh.export(file)
    ended = CliRunner().invoke(app, ["inspect", str(file), "--json", "--html", str(page)])
    assert ended.exit_code == 0, ended.stderr
    found = json.loads(ended.stdout)
    np.testing.assert_allclose(found["size"], [2, 4, 6])
    np.testing.assert_allclose(found["centre_of_mass"], [1, 2, 3])
    np.testing.assert_allclose(np.diag(found["inertia"]), np.array([52, 40, 20]) / 12)
    lying = [(pose["height"], pose["tilt_deg"]) for pose in found["resting_poses"]]
    want = [(1, np.rad2deg(np.arctan2(2, 1)))] * 2 + [(2, np.rad2deg(np.arctan2(1, 2)))] * 2
    want += [(3, np.rad2deg(np.arctan2(1, 3)))] * 2
    np.testing.assert_allclose(lying, want)
    assert [len(found["pieces"]), len(found["faces"])] == [1, 6]
    text = page.read_text(encoding="utf-8")
    assert "resting poses" in text and "MeshCat" in text and "default-src 'none'" in text


def test_a_scenario_and_keys() -> None:
    """A scenario's object is shown as well, in words; --set changes it."""
    ended = CliRunner().invoke(app, ["inspect", "shapes/l-bracket", "--set", "object.mass=2"])
    assert ended.exit_code == 0
    assert "at mass 2" in ended.stdout and "convex pieces   2" in ended.stdout


def test_the_ways_to_lie_are_trimeshs() -> None:
    """Second opinion: trimesh's stable poses of random hulls have the same heights; all stand."""
    for seed in range(5):
        points = np.random.default_rng(seed).normal(size=(12, 3))
        body, _ = at_centre_of_mass(Body((hull(points),)))
        mesh = trimesh.convex.convex_hull(body.vertices)
        turns, _ = trimesh.poses.compute_stable_poses(mesh, center_mass=np.zeros(3))
        ours = sorted(pose.height for pose in resting_poses(body))
        np.testing.assert_allclose(ours, sorted(turn[2, 3] for turn in turns), atol=1e-9)


def test_what_is_used_is_kept(tmp_path: Path) -> None:
    """The resolved scenario carries the shape as used, its deviation, and loads identically."""
    parts()["octagon"].export(tmp_path / "part.stl")
    for keys in ((), ("convex=hull", "frame={rotation: {axis: [1, 2, 3], angle: 40 deg}}")):
        scenario = inspect(str(tmp_path / "part.stl"), keys).scenario
        tree = json.loads(json.dumps(scenario.resolved()))
        shape = tree["object"]["shape"]
        assert set(shape) == {"mesh", "deviation"}
        again = Scenario.from_resolved(tree)
        assert again.resolved() == scenario.resolved()
        ours, theirs = scenario.problem.body.pieces[0], again.problem.body.pieces[0]
        np.testing.assert_array_equal(ours.vertices, theirs.vertices)
        assert ours.faces == theirs.faces


def test_an_obstacle_takes_the_same_keys(tmp_path: Path) -> None:
    """A mesh as an obstacle is welded, turned and made convex like the object."""
    parts()["L"].export(tmp_path / "part.stl")
    obstacle = "{mesh: part.stl, convex: hull, frame: {rotation: {yaw: 90 deg}}}"
    (tmp_path / "s.yaml").write_text(
        "format: gm-ompl-scenario/1\nname: obstacle\nobject: {shape: {box: [1, 1, 1]}, mass: 1}\n"
        "friction: {environment: 0.5, finger: 0.5}\n"
        "fingers: {count: 1, radius: 0.1, max_normal_force: 5}\n"
        f"environment: {{obstacles: {{part: {obstacle}}}}}\n"
        "motion: {start: {position: [3, 0, 0.5]}, path: [{slide: {by: [1, 0, 0]}}]}\n"
        "lattice: {segments: 1}\n"
    )
    found = inspect(str(tmp_path / "s.yaml")).scenario
    (piece,) = found.problem.environment.obstacles[0].body.pieces
    assert np.ptp(piece.vertices, axis=0) == pytest.approx([0.045, 0.06, 0.045], rel=1e-6)
    assert (found.model.environment.obstacles["part"].deviation or 0.0) > 0.005
