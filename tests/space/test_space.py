"""The hybrid state space: what OMPL demands of a space, and what its states mean."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.planners.ompl.motions import waypoints
from gm_ompl.planners.ompl.setup import HybridSetup
from gm_ompl.sampling.lines import same
from gm_ompl.sampling.motions import UNPLACED, HybridState

MakeHybrid = Callable[..., HybridSetup]
NAMES = ("paper/slide", "planar/turn")

ALL_BUT_INTERPOLATION = 0b1_1111_0111
"""OMPL's sanity checks; interpolation of a discrete part is rounded, so halves do not add up."""


@pytest.mark.parametrize("name", NAMES)
def test_ompls_own_laws_hold(name: str, make_hybrid: MakeHybrid) -> None:
    """OMPL's sanity checks: a metric, within bounds, copied and written faithfully."""
    setup = make_hybrid(name)
    setup.setup()
    space = setup.getStateSpace()
    space.sanityChecks(1e-9, 1e-9, ALL_BUT_INTERPOLATION)
    assert space.isCompound() and space.isHybrid() and space.isMetricSpace()


@pytest.mark.parametrize("name", NAMES)
def test_states_mean_what_was_written(name: str, make_hybrid: MakeHybrid) -> None:
    """A state reads back as written, circular coordinates up to whole turns."""
    setup = make_hybrid(name)
    motion, rng = setup.judge.problem.motion, np.random.default_rng(3)
    rows = len(setup.judge.problem.fingers.placements)
    state = setup.getSpaceInformation().allocState()
    for _ in range(200):
        q = tuple(rng.uniform(motion.low, motion.high).tolist())
        meaning = HybridState(q, tuple(rng.integers(UNPLACED, rows, size=2).tolist()))
        setup.codec.write(state, meaning)
        read = setup.codec.read(state)
        assert same(setup.judge.problem, read.q, meaning.q)
        assert read.placements == meaning.placements
        setup.codec.write(state, read)
        assert setup.codec.read(state) == read


@pytest.mark.parametrize("name", NAMES)
def test_unplaced_fingers_are_valid_at_the_start_alone(name: str, make_hybrid: MakeHybrid) -> None:
    """The virtual start is valid; the same hand elsewhere, or placed by half, is not."""
    setup = make_hybrid(name)
    si, codec = setup.getSpaceInformation(), setup.codec
    state = si.allocState()
    away = tuple((a + b) / 2 + 0.1 for a, b in zip(codec.start.q, codec.nowhere.q, strict=True))
    for meaning, valid in (
        (codec.start, True),
        (HybridState(away, codec.start.placements), False),
        (HybridState(codec.start.q, (0, UNPLACED)), False),
        (codec.nowhere, False),
    ):
        codec.write(state, meaning)
        assert si.isValid(state) is valid, meaning


def test_leaving_the_virtual_start_is_free(make_hybrid: MakeHybrid) -> None:
    """From the start to valid placements without a move of the object costs nothing."""
    setup = make_hybrid("paper/slide")
    start = setup.codec.start
    placed = HybridState(start.q, setup.draws.hand(start.q) or ())
    assert setup.motions.expand(start, placed) == ()
    assert setup.motions.expand(placed, start) is None


def test_goal_states_are_goals_and_valid(make_hybrid: MakeHybrid) -> None:
    """What the region draws is valid and at distance 0; the start is not."""
    setup = make_hybrid("planar/turn")
    goal, si = setup.getGoal(), setup.getSpaceInformation()
    state = si.allocState()
    for _ in range(20):
        goal.sampleGoal(state)
        assert si.isValid(state)
        assert goal.distanceGoal(state) == 0.0
    setup.codec.write(state, setup.codec.start)
    assert goal.distanceGoal(state) > 0.0


def test_motions_are_directed(make_hybrid: MakeHybrid) -> None:
    """Some motion of the slide is valid one way only, and OMPL is told so."""
    setup = make_hybrid("paper/slide")
    si = setup.getSpaceInformation()
    setup.setup()
    a, b = si.allocState(), si.allocState()
    one_way = 0
    for _ in range(60):
        rows = setup.draws.hand((0.0,))
        assert rows is not None
        setup.codec.write(a, HybridState((0.25,), rows))
        setup.codec.write(b, HybridState((0.75,), rows))
        there, back = si.checkMotion(a, b), si.checkMotion(b, a)
        one_way += there != back
        cost = setup.getOptimizationObjective().motionCost(a, b).value()
        assert math.isfinite(cost) is there
    assert one_way > 0


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("over", [False, True])
def test_every_state_is_nearest_to_itself(name: str, over: bool, make_hybrid: MakeHybrid) -> None:
    """Valid or not, and also when the run is over: FMT frees a state twice where it is not."""
    setup = make_hybrid(name)
    objective, codec, si = (
        setup.getOptimizationObjective(),
        setup.codec,
        setup.getSpaceInformation(),
    )
    setup.guard.watch(lambda: over)
    state, other = si.allocState(), si.allocState()
    outside = HybridState(tuple(10.0 * value + 7.0 for value in codec.start.q), (0, 0))
    for meaning in (codec.start, codec.nowhere, outside, setup.draws.goal()):
        assert meaning is not None
        codec.write(state, meaning)
        codec.write(other, meaning)
        assert objective.motionCost(state, other).value() == 0.0
    codec.write(other, codec.start)
    assert objective.motionCost(state, other).value() == math.inf


@pytest.mark.parametrize("name", NAMES)
def test_heuristic_is_admissible(name: str, make_hybrid: MakeHybrid) -> None:
    """No way from one state to another, straight or through a third, is below the bound."""
    setup = make_hybrid(name)
    motions, draws = setup.motions, setup.draws
    states = [state for _ in range(25) if (state := draws.anywhere()) is not None]
    states += [HybridState(states[0].q, state.placements) for state in states[:5]]
    costs = {(a, b): motions.cost(a, b) for a in states for b in states}
    reached = 0
    for (a, b), cost in costs.items():
        through = min(costs[a, c] + costs[c, b] for c in states)
        bound = motions.model.least_cost(a, b)
        assert bound <= min(cost, through) * (1.0 + 1e-12) + 1e-12
        reached += math.isfinite(cost)
    assert reached > len(states)


def test_long_motions_are_divided_at_lattice_nodes(make_hybrid: MakeHybrid) -> None:
    """Arcs end at nodes, in order, both ways; a motion within a step is one arc."""
    problem = make_hybrid("paper/slide").judge.problem
    assert waypoints(problem, (0.1,), (0.9,)) == [(0.1,), (1 / 3,), (2 / 3,), (0.9,)]
    assert waypoints(problem, (1.0,), (0.0,)) == [(1.0,), (2 / 3,), (1 / 3,), (0.0,)]
    assert waypoints(problem, (0.4,), (0.5,)) == [(0.4,), (0.5,)]
