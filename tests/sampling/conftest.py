"""Small problems with their judges."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Move, Problem
from gm_ompl.scenario.load import load
from tests.airborne import airborne

SMALL = {
    "slide": ("paper/slide", ["fingers.placements.grid=[2, 2]", "lattice.segments=4"]),
    "tumble": ("paper/tumble", ["fingers.placements.grid=[3, 3]", "lattice.segments=6"]),
    "regrasp": ("paper/regrasp", ["fingers.placements.grid=[3, 3]", "lattice.segments=10"]),
    "chain": ("random/chain/0", []),
    "turn": ("planar/turn", []),
}


@pytest.fixture(scope="session")
def small() -> Callable[[str], Problem]:
    """``small(name)``: a scenario on a coarse grid."""
    return lambda name: load(*SMALL[name]).problem


@pytest.fixture(scope="session")
def new_judge() -> Callable[[Problem], Judge]:
    """A judge that knows nothing yet."""
    return lambda problem: Judge(problem, make_backend(problem))


@pytest.fixture(scope="session")
def as_plan() -> Callable[[str, Sequence[Move]], Plan]:
    """``as_plan(name, moves)``: the moves as a plan that ``check`` can judge."""

    def make(name: str, moves: Sequence[Move]) -> Plan:
        scenario = load(*SMALL[name])
        statistics = {"time_s": 0.0, "expanded": 0, "mode_decisions": 0, "history": []}
        return assemble(
            scenario.problem, scenario.resolved(), airborne(scenario.problem, moves),
            status="solved", planner="test", statistics=statistics,
        )  # fmt: skip

    return make
