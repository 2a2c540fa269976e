"""Plans without regrasping, all sets of placements at once: against the search over lanes."""

from __future__ import annotations

import math

import pytest

from gm_ompl.scenario.load import load
from tests.kept import kept, lanes

SMALL = (
    ("tasks/reorient", ("fingers.placements.grid=[2, 2]",)),
    ("tasks/placedown", ("fingers.placements.grid=[2, 3]",)),
    ("tasks/reorient", ("fingers.placements.grid=[3, 3]", "cost.samples_at=ends")),
    ("tasks/pick-card-soft", ("motion.goal.position=[0.75, 0, 0.25]", "motion.goal.rotation=any")),
    ("free/out-of-the-corner", ()),
    ("free/l-bracket", ()),
    ("random/free/3", ()),
    ("random/free-clutter/3", ()),
)


@pytest.mark.parametrize(("name", "changes"), SMALL)
def test_the_lanes_find_the_same(name: str, changes: tuple[str, ...]) -> None:
    """It has the optimum where plans that regrasp cannot be cheaper, and never bounds too high."""
    problem = load(name, changes).problem
    other = lanes(problem)
    assert other.cost is not None
    optimum, search = other.cost, kept(problem, other.cost * 1.0001)
    assert other.optimal
    assert search.bound <= optimum * (1.0 + 1e-9)
    assert search.cost >= optimum * (1.0 - 1e-9)
    if search.proves(optimum):
        assert search.cost == pytest.approx(optimum, rel=1e-9)
    moves = search.moves()
    assert math.fsum(move.cost for move in moves) == pytest.approx(search.cost) or not moves


def test_what_is_enough_ends_it() -> None:
    """No plan is cheaper than the bound that it ends with."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    whole = kept(problem)
    search = kept(problem, 0.9 * whole.cost)
    assert search.cost == math.inf
    assert search.bound == pytest.approx(0.9 * whole.cost)
    assert search.expanded < whole.expanded
