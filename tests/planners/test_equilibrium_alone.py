"""``z_min: 0``: whatever equilibrium holds; and what soft fingertips hold."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.contact.decision import Outcome
from gm_ompl.contact.environment import contacts_at
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.plain.search import SearchStatus, plain_search
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.planner import Budget, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from tests.mechanics.equilibrium_alone import balanced

pytestmark = pytest.mark.filterwarnings("ignore:.*at the goal the object touches nothing")


def pusher(**changes: Any) -> dict[str, Any]:
    """A box on the floor and one finger."""
    return {
        "format": "gm-ompl-scenario/1",
        "name": "pusher",
        "object": {"shape": {"box": [2, 2, 2]}, "mass": 1},
        "friction": {"environment": 0.5, "finger": 0.7},
        "fingers": {
            "count": 1, "radius": 0.3, "max_normal_force": 20, "placements": {"grid": [3, 3]},
        },
        "motion": {"start": {"position": [0, 0, 1]}, "path": [{"slide": {"by": [3, 0, 0]}}]},
        "lattice": {"segments": 3},
        "mechanics": {"z_min": 0},
        **changes,
    }  # fmt: skip


def card(soft: float, z_min: float, f_max: float = 30) -> dict[str, Any]:
    """A card standing on the floor that two fingers lift by its broad sides."""
    return {
        "format": "gm-ompl-scenario/1",
        "name": "card",
        "object": {"shape": {"box": [0.2, 3, 2]}, "mass": 1},
        "friction": {"environment": 0.5, "finger": 0.7},
        "fingers": {
            "count": 2, "radius": 0.3, "max_normal_force": f_max, "soft": soft,
            "placements": {"grid": [3, 3], "faces": ["+x", "-x"]},
        },
        "motion": {"start": {"position": [0, 0, 1]}, "path": [{"slide": {"by": [0, 0, 1]}}]},
        "lattice": {"segments": 2},
        "mechanics": {"z_min": z_min},
    }  # fmt: skip


def test_a_single_finger_pushes_straight_ahead() -> None:
    """Behind the middle, with z = 0; any z_min > 0 refuses it. The cost counts z as 0.01 M g."""
    plan = gm_ompl.plan(pusher())
    assert plan.status == "solved"
    assert gm_ompl.check(plan).holds
    assert plan.cost == pytest.approx(3.0 * (1.0 + 0.01 / (0.01 * 9.8)), rel=1e-9)
    assert [segment.z for segment in plan.segments] == [0.0] * 9
    for step in plan.steps:
        assert step.placements[0].face == "-x"
        assert step.placements[0].point[1] == pytest.approx(0.0, abs=1e-12)
    refused = gm_ompl.plan(pusher(mechanics={"z_min": 1e-6}))
    assert refused.status == "infeasible"


def test_the_floor_of_z_weighs() -> None:
    """(9) takes 1 + X_stab / max(z, z_floor), and a check holds the plan to it."""
    plan = gm_ompl.plan(pusher(cost={"stability": 0.5, "z_floor": 0.25}))
    assert plan.cost == pytest.approx(3.0 * (1.0 + 0.5 / 0.25), rel=1e-9)
    assert gm_ompl.check(plan).holds


def test_a_sampler_asks_for_equilibrium_alone_as_well() -> None:
    """HybridRRTConnect finds the push, too."""
    plan = gm_ompl.plan(pusher(), "HybridRRTConnect", max_iterations=500)
    assert plan.status == "solved"
    assert gm_ompl.check(plan).holds


def test_two_soft_fingers_lift_a_card_and_two_points_do_not() -> None:
    """Points leave the card free to swing about their line; soft ones hold it with a margin."""
    points, soft = gm_ompl.plan(card(0.0, 0.05)), gm_ompl.plan(card(0.2, 0.05))
    assert points.status == "infeasible"
    assert soft.status == "solved"
    assert gm_ompl.check(soft).holds
    assert soft.scenario["fingers"]["soft"] == [0.2, 0.2]
    for claimed in (0.0, 0.1):  # more would hold as well: there the pinch itself is the limit
        tree = soft.to_dict()
        tree["scenario"]["fingers"]["soft"] = [claimed, claimed]
        topics = {
            v.topic for v in gm_ompl.check(Plan.model_validate(tree, strict=False)).violations
        }
        assert "z" in topics, claimed


def test_two_points_lift_by_pinching_where_equilibrium_is_enough() -> None:
    """Through the centre of mass, one position- and one force-controlled, between both limits.

    Two fingers of friction 0.7 carry 9.8 N with 7 N each: 7 to 30, half way 18.5. The pyramid
    reaches as far as the cone along its own edges, and cos(30 deg) as far between them.
    """
    plan = gm_ompl.plan(card(0.0, 0.0))
    assert plan.status == "solved"
    assert gm_ompl.check(plan).holds
    for segment in plan.segments:
        assert sorted(segment.modes) == ["force", "position"]
        (command,) = [f for f in segment.f_com if f is not None]
        assert 18.5 <= command <= (7.0 / np.cos(np.pi / 6.0) + 30.0) / 2.0 + 1e-6


def test_a_command_off_equilibrium_fails_the_check() -> None:
    """A pinch commanded too little to carry the card: there is no balance, and check says so."""
    plan = gm_ompl.plan(card(0.0, 0.0))
    tree = plan.to_dict()
    segment = tree["steps"][0]["segments"][0]
    segment["f_com"] = [None if f is None else 5.0 for f in segment["f_com"]]
    assert not gm_ompl.check(Plan.model_validate_json(json.dumps(tree))).holds


TWO_WAYS = {"start": {"position": [0, 0, 1]},
            "path": [{"slide": {"by": [2, 0, 0]}}, {"slide": {"by": [0, 1, 0]}}]}  # fmt: skip

COMPARED = {
    "soft": load("random/small/0", ["mechanics.z_min=0", "fingers.soft=0.05"]),
    "points, infeasible": load("random/small/1", ["mechanics.z_min=0"]),
    "a regrasp of one finger": Scenario.from_resolved(
        pusher(
            motion=TWO_WAYS,
            lattice={"segments": [2, 1]},
            fingers={**pusher()["fingers"], "placements": {"grid": [1, 1]}},
        )
    ),
}


@pytest.mark.parametrize("name", COMPARED)
def test_the_plain_search_finds_the_same_cost(name: str) -> None:
    """With z_min = 0 A* and the reference's search agree, on small scenarios."""
    problem = COMPARED[name].problem
    judge = Judge(problem, make_backend(problem))
    found = make_planner("astar").solve(problem, judge, Budget(), np.random.default_rng(0))
    plain = plain_search(problem)
    assert (found.status is Status.SOLVED) == (plain.status is SearchStatus.SOLVED)
    if found.status is Status.SOLVED:
        assert sum(move.cost for move in found.moves) == pytest.approx(plain.cost, rel=1e-6)


def test_what_cuts_refute_has_no_equilibrium() -> None:
    """A bound below 0 is only given to sets that nothing balances, and is given to some."""
    problem = load("paper/tumble", ["mechanics.z_min=0"]).problem
    backend = make_backend(problem)
    judge, rng = Judge(problem, backend), np.random.default_rng(0)
    refuted = 0
    for s in (0.2, 0.5, 0.8):
        moment = problem.motion.moment((s,), (1.0,))
        state = judge.environment(moment)
        contacts = contacts_at(moment, problem.body, problem.environment)
        for _ in range(60):
            rows = tuple(int(r) for r in rng.integers(len(problem.fingers.placements), size=2))
            bound = backend.bound(state, (0, 1), rows)
            known = balanced(problem.instant(contacts, (0, 1), rows))
            if bound < 0.0:
                refuted += 1
                assert not known
            decision = backend.decide(state, (0, 1), rows, 0.0)
            if known is not None and decision.outcome is not Outcome.INTERNAL_FORCE:
                assert (decision.outcome is Outcome.STABLE) == known
    assert refuted > 20
