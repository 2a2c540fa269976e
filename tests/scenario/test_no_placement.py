"""No placement left on the object: the key that removed all is named, for everyone who loads."""

from __future__ import annotations

import re
from typing import Any

import pytest
import trimesh
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.main import app
from gm_ompl.errors import ScenarioError
from gm_ompl.planners.registry import PLANNERS
from gm_ompl.scenario.scenario import Scenario

FRAME = [
    {"box": {"min": [-3, -3, 0], "max": [3, -1, 1]}},
    {"box": {"min": [-3, 1, 0], "max": [3, 3, 1]}},
    {"box": {"min": [-3, -1, 0], "max": [-1, 1, 1]}},
    {"box": {"min": [1, -1, 0], "max": [3, 1, 1]}},
]
"""A square frame of four bars."""


def scenario(shape: dict[str, Any], placements: dict[str, Any], fingers: int = 1) -> Scenario:
    """Return an object that is pushed over the floor."""
    tree = {
        "format": "gm-ompl-scenario/1",
        "name": "test/bare",
        "object": {"shape": shape, "mass": 1},
        "friction": {"environment": 0.4, "finger": 0.8},
        "environment": {"floor": False},
        "fingers": {
            "count": fingers, "radius": 0.1, "max_normal_force": 50, "placements": placements,
        },
        "motion": {
            "start": {"position": [0, 0, 9]}, "path": [{"slide": {"by": [1, 0, 0]}}],
        },
        "lattice": {"segments": 1},
    }  # fmt: skip
    return Scenario.from_resolved(tree)


def mesh(solid: trimesh.Trimesh) -> dict[str, Any]:
    return {"mesh": {"vertices": solid.vertices.tolist(), "faces": solid.faces.tolist()}}


def refusal(shape: dict[str, Any], placements: dict[str, Any]) -> str:
    with pytest.raises(ScenarioError) as caught:
        scenario(shape, placements)
    (problem,) = caught.value.problems
    return problem


def test_a_covered_face_alone_leaves_none() -> None:
    """The inner side of a bar's middle is covered by no piece; where two bars meet it is."""
    whole = scenario({"pieces": FRAME}, {"grid": [3, 1]}).problem.fingers.placements
    sides = {label for label, k in zip(whole.labels, range(24), strict=True) if k in whole.face}
    (covered,) = (
        label
        for label in sorted(set(whole.labels) - sides, key=int)
        if int(label) // 6 == 2 and abs(_normal(label, "y")) == 1.0 and _normal(label, "y") < 0
    )
    text = refusal({"pieces": FRAME}, {"grid": [3, 1], "faces": [covered]})
    assert "fingers.placements.grid: value [3, 1]" in text
    assert "off its face, in a hole or under another piece" in text


def _normal(label: str, axis: str) -> float:
    problem = scenario({"pieces": FRAME}, {"grid": [1, 1]}).problem
    piece, face = divmod(int(label), 6)
    return float(problem.body.pieces[piece].face_normals[face]["xyz".index(axis)])


def test_a_ring_offers_no_centre() -> None:
    """One cell on each flat face of a ring lies in the hole."""
    ring = trimesh.creation.annulus(r_min=1.0, r_max=2.0, height=1.0, sections=8)
    whole = scenario(mesh(ring), {"grid": [5, 5]}).problem
    table = whole.fingers.placements
    flat = [table.labels[k] for k in sorted(set(table.face[table.normals[:, 2] < -0.9].tolist()))]
    text = refusal(mesh(ring), {"grid": [1, 1], "faces": flat})
    assert "fingers.placements.grid: value [1, 1]: leaves the fingers no placement" in text


def test_a_thin_mesh_meets_the_default() -> None:
    """A rod is thinner than twice the margin that a mesh has by default: the default is named."""
    rod = mesh(trimesh.creation.box((1.0, 0.0019, 0.0019)))
    text = refusal(rod, {"grid": [1, 1]})
    assert "fingers.placements.margin: the default for a mesh, 0.001, leaves the fingers" in text
    assert "at most 0.00095" in text
    assert len(scenario(rod, {"grid": [1, 1], "margin": 0.00095}).problem.fingers.placements) == 6


@pytest.mark.parametrize(
    ("key", "value", "others"),
    [
        ("margin", 4.0, {"grid": [3, 3]}),
        ("margin", 1.9, {"grid": [2, 4], "faces": ["+x", "-x"]}),
        ("margin", 0.95, {"grid": [8, 8], "faces": ["+z"]}),
        ("smallest_face", 0.6, {"grid": [1, 1]}),
    ],
)
def test_the_value_that_is_named_works(key: str, value: float, others: dict[str, Any]) -> None:
    """What the message calls the most leaves a placement; a hundredth more leaves none."""
    shape = {"box": [2.0, 3.0, 1.3]}
    text = refusal(shape, {**others, key: value})
    most = float(re.findall(r"[\d.]+(?:e-\d+)?", text.replace("; must", " must"))[-1])
    assert scenario(shape, {**others, key: most}).problem.fingers.count == 1
    assert f"fingers.placements.{key}" in refusal(shape, {**others, key: most * 1.01})


def test_every_planner_and_setup_hear_it() -> None:
    """Planning, setting up, judging and explaining refuse at once."""
    with pytest.raises(ScenarioError, match=r"smallest_face|margin"):
        gm_ompl.load("paper/slide", ["fingers.placements.margin=10"])
    for planner in ("astar", "dijkstra", "RRT", "HybridRRTConnect"):
        arguments = ["plan", "paper/slide", "--set", "fingers.placements.margin=10"]
        result = CliRunner().invoke(app, [*arguments, "--planner", planner])
        assert result.exit_code == 2, planner
        assert "leaves the fingers no placement" in result.stderr
    for verb in ("explain", "compare", "tune"):
        names = {"compare": ["--planners", "astar", "--seeds", "1"],
                 "tune": ["--planner", "RRT", "--trials", "1"]}  # fmt: skip
        arguments = [verb, "paper/slide", *names.get(verb, [])]
        result = CliRunner().invoke(app, [*arguments, "--set", "fingers.placements.margin=10"])
        assert result.exit_code == 2, (verb, result.output)


def test_no_fingers_need_no_placement() -> None:
    """An empty hand plans without a table: nothing holds the object, and that is no bad input."""
    for key, value in (("margin", 10), ("smallest_face", 0.9)):
        bare = scenario({"box": [2, 2, 2]}, {key: value}, fingers=0)
        assert len(bare.problem.fingers.placements) == 0
        with pytest.warns(gm_ompl.ScenarioWarning, match="touches nothing"):
            assert gm_ompl.plan(bare).status == "infeasible"


@pytest.mark.parametrize("planner", sorted(PLANNERS))
def test_placements_that_geometry_blocks_are_no_mistake(planner: str) -> None:
    """Every tip on the under side penetrates the floor: proven, by every planner."""
    blocked = gm_ompl.load("paper/slide", ["fingers.placements.faces=[-z]"])
    assert gm_ompl.plan(blocked, planner, time_limit=5.0).status == "infeasible"
