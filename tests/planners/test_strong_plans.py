"""Plans whose margin is z_strong."""

from __future__ import annotations

from typing import Any

import pytest

import gm_ompl
from gm_ompl.errors import InputError

SMALL = [
    "lattice.segments=3", "cost.samples_per_arc=1", "mechanics.cone_edges=4",
    "fingers.placements={grid: [2, 2], faces: [+y, -y]}",
]  # fmt: skip
STRONG = {"mechanics.margin": "strong"}


@pytest.fixture(scope="module")
def plans() -> tuple[gm_ompl.Plan, gm_ompl.Plan]:
    """The best plans of a tumble by z and by z_strong."""
    nominal = gm_ompl.load("paper/tumble", SMALL)
    return gm_ompl.plan(nominal), gm_ompl.plan(nominal.with_(STRONG))


def test_a_strong_plan_is_proven_and_holds(plans: tuple[gm_ompl.Plan, gm_ompl.Plan]) -> None:
    """Optimal, not cheaper than by z, and the check agrees with its z_strong."""
    nominal, strong = plans
    assert nominal.cost is not None and strong.cost is not None
    assert strong.optimal and strong.cost >= nominal.cost
    least = min(part.z_strong or 0.0 for part in strong.segments)
    assert least >= 0.5
    assert gm_ompl.strong(strong).least.z_strong == pytest.approx(least, rel=1e-6)
    assert gm_ompl.check(strong).holds
    assert not any("z_strong" in part for part in nominal.to_dict()["steps"][0]["segments"])


@pytest.mark.parametrize(
    ("key", "change"), [("z_strong", 1.01), ("z_strong", 0.99), ("f_com", 0.9), ("z_strong", None)]
)
def test_a_tampered_one_does_not(
    plans: tuple[gm_ompl.Plan, gm_ompl.Plan], key: str, change: float | None
) -> None:
    """Overstated, understated, withheld; or other commands than those whose margins are stated."""
    data = plans[1].to_dict()
    part: dict[str, Any] = data["steps"][1]["segments"][0]
    if key == "f_com":
        part["f_com"] = [None if f is None else change * f for f in part["f_com"]]
    elif change is None:
        del part["z_strong"]
    else:
        part["z_strong"] *= change
    report = gm_ompl.check(gm_ompl.Plan.model_validate(data, strict=False))
    assert {violation.topic for violation in report.violations} & {"z", "z_strong"}


def test_a_nominal_plan_states_no_strong_margin(plans: tuple[gm_ompl.Plan, gm_ompl.Plan]) -> None:
    """What the scenario does not plan with is not taken on trust."""
    data = plans[0].to_dict()
    data["steps"][0]["segments"][0]["z_strong"] = 0.1
    report = gm_ompl.check(gm_ompl.Plan.model_validate(data, strict=False))
    assert "z_strong" in {violation.topic for violation in report.violations}


@pytest.mark.parametrize("planner", ["dijkstra", "HybridRRTConnect", "RRTConnect"])
def test_all_planners_plan_with_it(plans: tuple[gm_ompl.Plan, gm_ompl.Plan], planner: str) -> None:
    """An exact one finds the same optimum, random ones what is strongly held as well."""
    scenario, best = gm_ompl.load("paper/tumble", SMALL).with_(STRONG), plans[1].cost
    plan = gm_ompl.plan(scenario, planner=planner, seed=1, time_limit=60.0)
    assert plan.cost is not None and best is not None
    assert plan.cost >= best * (1.0 - 1e-6)
    assert plan.cost == pytest.approx(best, rel=1e-6) or planner != "dijkstra"
    assert all(part.z_strong is not None and part.z_strong >= 0.5 for part in plan.segments)


@pytest.mark.parametrize(
    ("other", "told"),
    [
        ({"uncertainty": {"mass": "5 %"}}, "remove uncertainty"),
        ({"fingers.soft": 0.5}, "remove fingers.soft"),
        ({"fingers.placements.continuous": {"margin": 0.1}}, "mechanics.margin: nominal"),
    ],
)
def test_what_it_cannot_be_had_with_is_told(other: dict[str, Any], told: str) -> None:
    """One clear message."""
    with pytest.raises(InputError, match=told):
        gm_ompl.load("paper/slide").with_({**STRONG, **other})
