"""Exports: what a controller reads is what the plan says."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from gm_ompl.errors import InputError
from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.export import table


def test_export_holds_poses_modes_and_forces(cork_plan: Plan) -> None:
    """Every row has every column; time runs evenly; forces and poses are the plan's."""
    text = table(cork_plan, rate=50.0)
    header = [line for line in text.splitlines() if line.startswith("#")]
    assert any("world frame" in line for line in header)
    assert any("units" in line for line in header)
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    assert np.allclose(np.diff([float(row["time"]) for row in rows]), 0.02, atol=2e-6)
    assert {row["finger0_mode"] for row in rows} == {"free", "position"}
    assert {row["finger1_mode"] for row in rows} == {"free", "switch", "force"}
    last, step = rows[-1], cork_plan.steps[-1]
    assert step.kind == "displacement"
    assert [float(last[f"object_{c}"]) for c in "xyz"] == pytest.approx(step.pose_to.position)
    assert float(last["finger1_f_com"]) == pytest.approx(step.segments[-1].f_com[1])
    assert last["finger0_f_com"] == ""
    # Each fingertip's centre is one radius outside the object's side, at y = 30 mm + 12 mm.
    assert abs(float(last["finger0_y"])) == pytest.approx(0.042)


def test_a_rate_must_make_sense(cork_plan: Plan) -> None:
    """Bad input is said to be so."""
    with pytest.raises(InputError, match="rate"):
        table(cork_plan, rate=0.0)
