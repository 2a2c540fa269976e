"""A tree of lanes: what its branches promise, and how they hang together."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.sampling.lane_store import LaneStore, SetDraw
from gm_ompl.sampling.lines import polyline
from gm_ompl.sampling.route import Route
from gm_ompl.sampling.settings import ExploringSettings
from gm_ompl.sampling.tree import ROOT, Tree
from gm_ompl.scenario.load import load


@pytest.mark.parametrize("ahead", [True, False])
def test_branches_hold_and_hang_together(ahead: bool) -> None:
    """A branch holds over its stretch, begins where its parent still holds, and moves a finger."""
    changes = ["fingers.placements.grid=[3, 3]", "lattice.segments=10"]
    problem = load("paper/regrasp", changes).problem
    judge = Judge(problem, make_backend(problem))
    route = Route(judge, polyline(problem, [problem.start, (1.0,)]))
    sets = PlacementSets(problem.fingers.groups())
    store, rng = LaneStore(judge, sets, route), np.random.default_rng(0)
    tree = Tree(
        problem, store, SetDraw(problem, judge, 1.0, 0.2), ahead, ExploringSettings(batch=16), rng
    )
    for _ in range(30):
        number = tree.grow(lambda: False)
        assert number is None or number == len(tree.branches) - 1
    assert tree.steps == 30
    assert any(branch.parent != ROOT for branch in tree.branches)
    other = Judge(problem, make_backend(problem))
    again = Route(other, polyline(problem, [problem.start, (1.0,)]))
    fresh = LaneStore(other, sets, again)
    for number, branch in enumerate(tree.branches):
        assert fresh.probe(branch.lane, branch.enter, branch.reach) == branch.reach
        assert number in tree.by_lane[branch.lane]
        if branch.parent == ROOT:
            assert tree.progress(branch.enter) == 0
            continue
        parent = tree.branches[branch.parent]
        assert branch.parent < number
        assert tree.progress(parent.enter) <= tree.progress(branch.enter)
        assert tree.progress(branch.enter) <= tree.progress(parent.reach)
        hubs = [
            {store.lifted(lane, slot) for slot in range(len(lane))}
            for lane in (branch.lane, parent.lane)
        ]
        assert hubs[0] & hubs[1]
    furthest = max(tree.progress(branch.reach) for branch in tree.branches)
    assert tree.best == furthest / route.strides
