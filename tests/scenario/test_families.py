"""Random families: the same everywhere, valid, and as various as they claim."""

from __future__ import annotations

import hashlib
import math

import numpy as np
import pytest

from gm_ompl.contact.environment import environment_contacts
from gm_ompl.motion.free import FreeMotion, angle_between
from gm_ompl.scenario.families import FAMILIES, family_yaml
from gm_ompl.scenario.load import load

SEEDS = range(25)


def test_the_same_everywhere() -> None:
    """The texts of the first seeds hash to recorded values (PCG64 raw bits, rounded decimals).

    Changing a family changes every study that names it: do so only with a CHANGELOG entry.
    """
    found = {
        family: hashlib.sha256(
            "".join(family_yaml(family, seed) for seed in (0, 1, 17, 2**40)).encode()
        ).hexdigest()[:16]
        for family in FAMILIES
    }
    assert found == RECORDED


RECORDED = {
    "slide": "6aedcebf3cca0d77",
    "push": "0e268a70e3a937c4",
    "tumble": "72ff43ac69a0b3b9",
    "regrasp": "a0cf63ad237470c1",
    "chain": "5764d0b6ad5f20e9",
    "planar": "19c6b695c1f6befe",
    "small": "db50cb4508a2d305",
    "free": "ab2cf854d1268522",
    "free-clutter": "b0974dffd0aac332",
}


@pytest.mark.parametrize("family", FAMILIES)
def test_every_seed_is_valid(family: str) -> None:
    """Scenarios load without mistakes and are named after their seed."""
    for seed in SEEDS:
        scenario = load(f"random/{family}/{seed}")
        assert scenario.name == f"random/{family}/{seed}"
        assert load(scenario.name).resolved() == scenario.resolved()


FREE = ("free", "free-clutter")


@pytest.mark.parametrize("family", [family for family in FAMILIES if family not in FREE])
def test_start_and_goal_are_lattice_nodes(family: str) -> None:
    """The exact planner can start and end."""
    for seed in SEEDS:
        problem = load(f"random/{family}/{seed}").problem
        assert problem.lattice.find(problem.start) is not None
        assert problem.lattice.find([value or 0.0 for value in problem.goal.low]) is not None


def test_families_are_various() -> None:
    """Among 60 tumbles: one to three fingers, unequal ones, other units, walls, grids."""
    problems = [load(f"random/tumble/{seed}").problem for seed in range(60)]
    assert {p.fingers.count for p in problems} == {1, 2, 3}
    assert any(len(p.fingers.groups()) > 1 for p in problems)
    assert any(p.body.diagonal < 1 for p in problems)
    assert any(p.body.diagonal > 100 for p in problems)
    assert {len(p.environment.obstacles) for p in problems} >= {0, 1, 2}
    assert len({len(p.fingers.placements) for p in problems}) > 15
    assert all(10 <= p.lattice.size - 1 <= 61 for p in problems)


def test_units_do_not_leak() -> None:
    """Relative to weight and size, scaled scenarios look like the others."""
    for family in ("slide", "tumble"):
        for seed in SEEDS:
            problem = load(f"random/{family}/{seed}").problem
            weight = problem.mass * problem.mechanics.gravity
            assert 0.005 < problem.mechanics.z_min / weight < 0.1
            assert 0.1 < problem.fingers.max_normal_force.max() / weight < 5
            assert problem.fingers.radius.max() < problem.body.diagonal


def test_small_is_small() -> None:
    """The plain search can judge every arc: few hands, few segments; yet one to three fingers."""
    counts, given, unequal = set(), 0, 0
    for seed in range(120):
        problem = load(f"random/small/{seed}").problem
        fingers = problem.fingers
        hands = math.comb(len(fingers.placements), fingers.count)
        assert hands <= 30
        assert hands * (problem.lattice.size - 1) * problem.cost.samples_per_arc <= 360
        counts.add(fingers.count)
        given += any(v is not None for v in (*fingers.start, *fingers.goal))
        unequal += len(fingers.groups()) > 1
    assert counts == {1, 2, 3}
    assert given > 5
    assert unequal > 5


@pytest.mark.parametrize("family", FREE)
def test_free_goals_are_within_reach_of_the_steps(family: str) -> None:
    """One place is a whole number of steps away; a range holds where the quarter turns end."""
    for seed in range(30):
        problem = load(f"random/{family}/{seed}").problem
        motion = problem.motion
        assert isinstance(motion, FreeMotion)
        assert not motion.goal.contains(motion.start)
        goal, steps, start = motion.goal, motion.steps, motion.start
        assert goal.rotation is not None
        turns = angle_between(start.rotation, goal.rotation) / steps.rotation
        assert turns == pytest.approx(round(turns), abs=1e-9)
        if (goal.low == goal.high).all():
            ways = (goal.low - start.position) / steps.translation
            assert ways == pytest.approx(ways.round(), abs=1e-6)
        else:
            a, _, c = np.ptp(problem.body.vertices, axis=0)
            quarters = 2 if angle_between(start.rotation, goal.rotation) > 2 else 1
            assert goal.low[0] < quarters * (a + c) / 2 < goal.high[0] or (
                goal.low[0] < -quarters * (a + c) / 2 < goal.high[0]
            )


def test_free_families_are_small_and_various() -> None:
    """At most 66 hands; rolls, turns and lifts by three fingers; one box or two, some touching."""
    kinds, counts, touching = set(), set(), 0
    for seed in range(30):
        problem = load(f"random/free-clutter/{seed}").problem
        motion = problem.motion
        assert isinstance(motion, FreeMotion)
        assert problem.fingers.count == (3 if 2 in motion.steps.translate else 2)
        assert math.comb(len(problem.fingers.placements), problem.fingers.count) <= 66
        assert motion.steps.rotate is not None
        kinds.add((motion.steps.translate, motion.steps.rotate.tobytes()))
        counts.add(len(problem.environment.obstacles))
        found = environment_contacts(problem.body, problem.environment, motion.start)
        touching += bool((found.normals[:, 2] < 0.5).any())
    assert len(kinds) == 3
    assert counts == {1, 2}
    assert touching > 10


@pytest.mark.parametrize("family", FREE)
def test_free_lattices_end(family: str) -> None:
    """Few poses, some of them the goal; the plain search can judge every arc."""
    for seed in range(5):
        graph = load(f"random/{family}/{seed}").problem.object_graph
        seen, waiting = {graph.start}, [graph.start]
        while waiting:
            heads = {arc.head for arc in graph.arcs_from(waiting.pop())} - seen
            seen |= heads
            waiting += heads
            assert len(seen) < 500
        assert family != "free" or any(graph.in_goal(node) for node in seen)
