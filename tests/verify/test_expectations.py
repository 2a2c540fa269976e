"""The paper's problems come out as Sec. 5 says in words."""

from __future__ import annotations

from functools import cache

import pytest

import gm_ompl
from gm_ompl.planfile.model import DisplacementStep, Plan, RegraspStep
from gm_ompl.scenario.load import load
from tests.verify.expectations import disagreements

PAPER = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp", "paper/cork")


@cache
def planned(name: str) -> Plan:
    return gm_ompl.plan(name)


@pytest.mark.parametrize("name", PAPER)
def test_plans_are_as_expected_and_proven_optimal(name: str) -> None:
    """Status, regrasps, faces and modes are those of the scenario's ``expect``."""
    plan = planned(name)
    assert list(disagreements(plan, load(name).model.expect)) == []
    assert plan.optimal
    assert plan.lower_bound == pytest.approx(plan.cost, rel=1e-6)


def test_disagreements_are_noticed() -> None:
    """Another scenario's expectations are not met."""
    assert list(disagreements(planned("paper/push"), load("paper/slide").model.expect))
    assert list(disagreements(planned("paper/tumble"), load("paper/regrasp").model.expect))


def test_weak_fingers_push_at_opposite_ends() -> None:
    """Both are behind the box, one at each end in y (Sec. 5.1, Fig. 8)."""
    steps = planned("paper/push").steps
    for step in steps:
        assert [place.face for place in step.placements] == ["-x", "-x"]
        points = sorted(place.point[1] for place in step.placements)
        most = 10 / 2 * (1 - 1 / 7)  # the outermost cells' centres
        assert points == pytest.approx([-most, most])


def test_regrasping_follows_the_figure() -> None:
    """Force control on top to about 33 degrees, position control to the regrasp, then one each."""
    modes_at = []
    regrasped = None
    for step in planned("paper/regrasp").steps:
        if isinstance(step, RegraspStep):
            regrasped = 90 * step.at[0]
        else:
            assert isinstance(step, DisplacementStep)
            P = len(step.segments)
            for j, segment in enumerate(step.segments):
                s = step.from_[0] + (j + 0.5) / P * (step.to[0] - step.from_[0])
                modes_at.append((90 * s, sorted(segment.modes)))
    assert regrasped is not None and 30 <= regrasped <= 48
    for angle, modes in modes_at:
        if angle < 31:
            assert modes == ["force", "force"]
        elif 35 < angle < regrasped:
            assert modes == ["position", "position"]
        elif angle > regrasped:
            assert modes == ["force", "position"]
