"""``gm-ompl new``: what it writes can be planned as it is, and follows the object."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.completing import MOTIONS
from gm_ompl.app.main import app

BRACKET = Path(__file__).resolve().parents[2] / "scenarios" / "shapes" / "l-bracket.obj"
COARSE = ["fingers.placements.grid=[2, 2]", "lattice.steps.yaw=45 deg"]


def new(*arguments: str | Path) -> str:
    """Return what ``gm-ompl new`` writes to stdout."""
    result = CliRunner().invoke(app, ["new", *map(str, arguments)])
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.mark.parametrize("motion", MOTIONS)
def test_every_kind_of_motion_is_solved_as_it_is_written(motion: str, tmp_path: Path) -> None:
    """A box, each motion: a plan is found, and it holds."""
    file = tmp_path / "new.yaml"
    file.write_text(new("--motion", motion))
    plan = gm_ompl.plan(gm_ompl.load(file, COARSE[: 2 if motion == "planar" else 1]))
    assert plan.has_plan
    assert gm_ompl.check(plan).holds


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_values_go_with_size_and_weight(scale: float, tmp_path: Path) -> None:
    """The same box in other units, with another mass, has the same plan at the same scale."""
    costs = []
    for size, mass in ((1.0, 1.0), (scale, scale)):
        file = tmp_path / "new.yaml"
        sides = ",".join(f"{side * size:.12g}" for side in (4, 5, 6))
        file.write_text(new("--size", sides, "--mass", str(mass)))
        costs.append(gm_ompl.plan(gm_ompl.load(file, COARSE[:1])).cost)
    assert costs[0] is not None
    assert costs[1] == pytest.approx(scale * costs[0], rel=0.02)  # values are rounded


def test_a_mesh_lies_on_its_steadiest_face(tmp_path: Path) -> None:
    """The part is named relative to the scenario, keys beside it are kept, and it is planned."""
    (tmp_path / "in").mkdir()
    file = tmp_path / "in" / "part.yaml"
    new(BRACKET, "--set", "scale=2", "--mass", "0.2", "-o", file)
    shape = yaml.safe_load(file.read_text())["object"]["shape"]
    assert (file.parent / shape["mesh"]).samefile(BRACKET)
    assert shape["scale"] == 2
    scenario = gm_ompl.load(file, COARSE[:1])
    assert scenario.warnings == ()
    assert gm_ompl.plan(scenario).has_plan


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--size", "1,2"], "three numbers"),
        (["--size", "1,2,-3"], "positive"),
        (["--motion", "slid"], "slide"),
        (["part.txt"], ".stl"),
        (["missing.stl"], "no such file"),
        ([str(BRACKET), "--size", "1,2,3"], "size of its own"),
    ],
)
def test_what_is_wrong_is_said(arguments: list[str], said: str) -> None:
    """Exit code 2, one message, nothing on stdout."""
    result = CliRunner().invoke(app, ["new", *arguments])
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stdout == ""
