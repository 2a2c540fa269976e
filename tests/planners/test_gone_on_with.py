"""Exact searches of free motion that a limit breaks off can be gone on with."""

from __future__ import annotations

import math
from unittest import mock

import numpy as np
import pytest

from gm_ompl import limits
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.kept_graph import KeptGraph
from gm_ompl.graph.kept_states import ahead
from gm_ompl.graph.regrasp_graph import RegraspGraph
from gm_ompl.planners import kept_search
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.kept import kept

STAIRS = (
    "fingers.placements.grid=[2, 1]", "friction.finger=0.65", "cost.regrasp=20",
    "mechanics.z_min=0", "motion.goal.rotation={axis: [0, 1, 0], angle: 90 deg}",
)  # fmt: skip


def stairs() -> Problem:
    """The best plan regrasps once."""
    return load("free/stairs", STAIRS).problem


def begun(problem: Problem) -> KeptSearch:
    judge = Judge(problem, KernelBackend(problem))
    search = KeptSearch.of(judge, Log(Budget().start(), judge))
    assert search is not None
    return search


def finish(search: KeptSearch) -> None:
    while not search.done:
        search.step(math.inf)


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_what_limits_broke_off_ends_the_same(share: float) -> None:
    """Nothing that was followed is lost, wherever a limit was reached; no bound is too high."""
    whole, rng, times = kept(stairs()), np.random.default_rng(0), 0

    def check() -> None:
        if rng.random() < share:
            raise LimitError

    search = begun(stairs())
    with mock.patch.object(limits, "check", check):
        while not search.done:
            try:
                search.step(math.inf)
            except LimitError:
                times += 1
            assert search.bound <= whole.cost * (1.0 + 1e-9)
    assert times > 20
    assert whole.cost < math.inf
    assert search.cost == pytest.approx(whole.cost, rel=1e-9)
    assert search.bound == pytest.approx(whole.bound, rel=1e-9)


def test_a_limit_while_sets_are_made_ready_leaves_plans_that_regrasp() -> None:
    """They are looked for when the search is gone on with."""
    search = begun(stairs())
    broken = mock.patch.object(kept_search, "RegraspGraph", side_effect=LimitError)
    with broken, pytest.raises(LimitError):
        finish(search)
    finish(search)
    assert search.cost == pytest.approx(kept(stairs()).cost, rel=1e-9)


def test_bounds_do_not_fall_where_plans_that_regrasp_come_in() -> None:
    """What they cost at least is known before they are looked for."""
    search, bounds = begun(stairs()), [0.0]
    while not search.done:
        search.step(math.inf)
        bounds.append(search.bound)
    assert bounds == sorted(bounds)


def test_of_states_that_were_met_since_nothing_is_known() -> None:
    """Where a limit came before what follows them was found, none is read from elsewhere."""
    problem = stairs()
    judge = Judge(problem, KernelBackend(problem))
    graph = KeptGraph(judge)
    assert graph.planar is not None
    tables = RegraspGraph(judge, graph, graph.planar).tables
    hand = int(tables.book.hand[0])
    for count, left in ((0, math.inf), (1000, 7.0 + problem.cost.regrasp)):
        relaxed = tables.relaxed._replace(after=np.full(1000, 7.0)[:count])
        assert ahead(0, hand, tables._replace(relaxed=relaxed)) == left
