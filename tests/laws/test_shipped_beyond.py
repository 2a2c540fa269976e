"""The scenarios beyond the paper: planned as expected, and confirmed by the check."""

from __future__ import annotations

import pytest

import gm_ompl


@pytest.mark.parametrize(
    "name", ["planar/corner", "planar/turn", "shapes/hexagon", "shapes/l-bracket",
             "fingers/three"]
)  # fmt: skip
def test_plans_as_expected_and_the_check_agrees(name: str) -> None:
    """astar proves the optimum with the regrasps that the scenario expects; every step holds."""
    scenario = gm_ompl.load(name)
    plan = gm_ompl.plan(scenario, "astar")
    assert plan.optimal
    assert plan.status == scenario.model.expect.status
    assert plan.regrasps == scenario.model.expect.regrasps
    assert gm_ompl.check(plan).holds
