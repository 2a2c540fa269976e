"""Assembly: what moves become in a plan."""

from __future__ import annotations

import math
from typing import Any

import pytest

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import DisplacementStep, Plan, RegraspStep
from gm_ompl.problem import Displacement, Move, Regrasp
from gm_ompl.scenario.scenario import Scenario

SCENARIO = {
    "format": "gm-ompl-scenario/1",
    "name": "test/tumble",
    "object": {"shape": {"box": [5, 5, 10]}, "mass": 1},
    "friction": {"environment": 0.5, "finger": 0.7},
    "fingers": {"count": 2, "radius": 1, "max_normal_force": [10, 4]},
    "motion": {
        "start": {"position": [0, 0, 5]},
        "path": [{"tumble": {"towards": "+x", "angle": "90 deg"}}],
    },
    "lattice": {"segments": 2},
}
STATISTICS = {"time_s": 1, "expanded": 2, "mode_decisions": 3, "history": []}
FORCE, POSITION = ControlMode.FORCE, ControlMode.POSITION


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    """A box tumbles; the second finger is weaker."""
    return Scenario.from_resolved(SCENARIO)


def _held(f_com: float) -> ModeDecision:
    return ModeDecision(Outcome.STABLE, 1.5, (POSITION, FORCE), (None, f_com))


def _plan(scenario: Scenario, f_com: float = 4.0, **changes: Any) -> Plan:
    rest = ModeDecision(Outcome.STABLE, 2.0, (FORCE,), (3.0,))
    arc = scenario.problem.motion.arc((0.0,), (0.5,))
    moves: list[Move] = [
        Displacement(arc, (0.0,), (0.5,), (7, 60), (_held(f_com),) * 3, 8.25),
        Regrasp(arc.end, (0.5,), 0, 100, (7, 60), rest, 100.0),
    ]
    given: dict[str, Any] = {"status": "solved", "planner": "astar", "statistics": STATISTICS}
    return assemble(scenario.problem, scenario.resolved(), moves, **{**given, **changes})


def test_steps_say_what_the_moves_are(scenario: Scenario) -> None:
    """Each move becomes one step; cost and regrasps follow from the moves."""
    plan = _plan(scenario)
    arc, change = plan.steps
    assert isinstance(arc, DisplacementStep)
    assert isinstance(change, RegraspStep)
    assert (plan.cost, plan.regrasps, plan.optimal) == (108.25, 1, False)
    assert (arc.from_, arc.to, arc.cost, len(arc.segments)) == ((0.0,), (0.5,), 8.25, 3)
    assert arc.segments[0].modes == ("position", "force")
    assert arc.segments[0].f_com == (None, 4.0)
    assert (change.modes, change.f_com, change.z) == ((None, "force"), (None, 3.0), 2.0)
    assert change.from_ == change.placements[0] == arc.placements[0]


def test_poses_are_the_motion_s(scenario: Scenario) -> None:
    """After 45 degrees about the edge x = 2.5 the pose is that of plane geometry."""
    arc = _plan(scenario).steps[0]
    assert isinstance(arc, DisplacementStep)
    half, diagonal, tilt = math.pi / 8, math.hypot(2.5, 5), math.atan2(5, -2.5) - math.pi / 4
    want = (2.5 + diagonal * math.cos(tilt), 0.0, diagonal * math.sin(tilt))
    assert arc.pose_to.position == pytest.approx(want, abs=1e-12)
    assert arc.pose_to.quaternion == pytest.approx((math.cos(half), 0, math.sin(half), 0))
    assert arc.pose_from.quaternion == pytest.approx((1, 0, 0, 0))


def test_placements_are_the_table_s(scenario: Scenario) -> None:
    """Rows 7 and 60 of a 7 x 7 grid: +x, cell (1, 0), and -x, cell (1, 4)."""
    first, second = _plan(scenario).steps[0].placements
    assert (first.face, first.cell, second.face, second.cell) == ("+x", (1, 0), "-x", (1, 4))
    assert first.point == pytest.approx((2.5, 2.5 * (3 / 7 - 1), 5 * (1 / 7 - 1)))
    assert second.normal == pytest.approx((1, 0, 0))


@pytest.mark.parametrize(("given", "want"), [(-1e-12, 0.0), (4 + 1e-12, 4.0), (3.9, 3.9)])
def test_rounding_of_f_com_is_taken_away(scenario: Scenario, given: float, want: float) -> None:
    """A solver's rounding at the bounds 0 and f_max does not reach the plan."""
    arc = _plan(scenario, f_com=given).steps[0]
    assert isinstance(arc, DisplacementStep)
    assert arc.segments[0].f_com[1] == want


def test_a_wrong_f_com_is_not_hidden(scenario: Scenario) -> None:
    """More than rounding stays in the plan, for the check to find."""
    arc = _plan(scenario, f_com=4.1).steps[0]
    assert isinstance(arc, DisplacementStep)
    assert arc.segments[0].f_com[1] == 4.1


@pytest.mark.parametrize("status", ["infeasible", "budget", "interrupted"])
def test_no_plan_has_no_totals(scenario: Scenario, status: str) -> None:
    """Without a plan cost and regrasps are null; infinite numbers become null."""
    statistics = {**STATISTICS, "history": [(0.5, math.inf, math.inf)], "peak": math.nan}
    plan = assemble(
        scenario.problem,
        scenario.resolved(),
        status=status,  # type: ignore[arg-type]
        planner="astar",
        statistics=statistics,
        lower_bound=math.inf,
    )
    assert (plan.cost, plan.regrasps, plan.lower_bound, plan.steps) == (None, None, None, ())
    assert plan.statistics.history == ((0.5, None, None),)


def test_the_scenario_in_the_plan_gives_the_same_plan(scenario: Scenario) -> None:
    """The scenario that a plan carries resolves to the same problem."""
    plan = _plan(scenario)
    again = Scenario.from_resolved(plan.scenario)
    moves_again = _plan(again)
    assert moves_again == plan
