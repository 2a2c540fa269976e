"""Plans whose arcs are judged from end to end, by exact search and by sampling."""

from __future__ import annotations

import json

import pytest

from gm_ompl import api
from gm_ompl.planfile.model import Plan

CASES = (
    ("paper/slide", ("lattice.segments=3", "motion.path=[{slide: {by: [2, 0, 0]}}]")),
    ("paper/tumble", ("lattice.segments=4",)),
    ("planar/turn", ()),
)


@pytest.mark.parametrize(("name", "changes"), CASES)
def test_plans_hold_that_are_judged_at_their_ends(name: str, changes: tuple[str, ...]) -> None:
    """The check asks where the plan was asked; judged in the middles, it would state other z."""
    common = ("fingers.placements.grid=[3, 3]", "cost.samples_at=ends")
    scenario = api.load(name, [*changes, *common])
    for planner in ("astar", "HybridRRTConnect"):
        plan = api.plan(scenario, planner, seed=1, time_limit=30)
        assert plan.steps
        report = api.check(plan)
        assert report.holds, report.table()
    if name == "paper/tumble":
        draft = plan.to_dict()
        draft["scenario"]["cost"]["samples_at"] = "middles"
        assert not api.check(Plan.model_validate_json(json.dumps(draft))).holds
