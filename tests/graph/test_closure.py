"""The part of an object graph that plans up to a cost can use."""

from __future__ import annotations

import contextlib
import math
from unittest import mock

import numpy as np
import pytest

from gm_ompl import limits
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph.closure import Closure
from gm_ompl.problem import Displacement
from gm_ompl.scenario.load import load
from tests.verify.count_searches import solve

SOLVED = ("random/free/2", "random/free-clutter/3", "random/free/3", "free/l-bracket")


def same(a: Pose, b: Pose) -> bool:
    """Whether two poses are one up to rounding."""
    off = np.abs(a.rotation - b.rotation).max() + np.abs(a.position - b.position).max()
    return bool(off < 1e-6)


@pytest.mark.parametrize("name", SOLVED)
def test_what_the_best_plan_passes_is_in_it(name: str) -> None:
    """Grown to the plan's cost, with what dearer plans pass left aside, it has the plan's poses."""
    problem = load(name).problem
    best = solve(problem, "astar")
    assert best.optimal and best.cost is not None
    closure = Closure(Judge(problem, KernelBackend(problem)))
    closure.grow(best.cost * (1.0 + 1e-9))
    graph, inside = problem.object_graph, closure.leaving(best.cost * (1.0 + 1e-9))
    poses = [graph.pose(node) for node in inside]
    passed = [move.arc.end for move in best.moves if isinstance(move, Displacement)]
    assert passed and all(any(same(pose, other) for other in poses) for pose in passed)


def test_bounds_rise_and_fewer_nodes_serve_cheaper_plans() -> None:
    """What is taken in next is never cheaper than before; what is left aside grows."""
    problem = load("free/l-bracket").problem
    closure = Closure(Judge(problem, KernelBackend(problem)))
    bound, bounds = closure.to_goal(), list[float]()
    assert bound is not None
    while closure.next < math.inf and len(bounds) < 20:
        bounds.append(closure.next)
        closure.grow(closure.next)
    assert bounds == sorted(bounds) and bounds[0] >= bound * (1.0 - 1e-12)
    kept = [len(closure.leaving(factor * bound)) for factor in (0.5, 1.0, 2.0, math.inf)]
    assert kept == sorted(kept) and kept[0] == 1 < kept[-1]


@pytest.mark.parametrize("end", [LimitError, KeyboardInterrupt])
def test_what_is_broken_off_is_not_in_it(end: type[BaseException]) -> None:
    """Wherever a limit or Ctrl-C ends it, all plans that are left cost what they did before."""
    problem = load("free/l-bracket").problem
    for checks in range(1, 12):
        closure = Closure(Judge(problem, KernelBackend(problem)))
        before = closure.next
        with (
            mock.patch.object(limits, "check", side_effect=[None] * checks + [end]),
            contextlib.suppress(end),
        ):
            while True:
                before = closure.next
                closure.grow(before, len(closure) + 1)
        assert closure.next == before


@pytest.mark.parametrize("every", [2, 3, 10])
def test_growth_that_pauses_is_gone_on_with(every: int) -> None:
    """Broken off after every few nodes, a part has the same nodes as one grown at once."""
    problem = load("free/l-bracket").problem
    whole, paused = (Closure(Judge(problem, KernelBackend(problem))) for _ in range(2))
    asked = iter(range(10_000))

    def pause() -> bool:
        return next(asked) % every == every - 1

    for closure in (whole, paused):
        assert closure.to_goal() is not None
    for _ in range(2):
        assert whole.double()
        pauses = 0
        while not paused.double(pause):
            pauses += 1
        assert pauses > 0
        assert len(paused) == len(whole) and paused.next == whole.next
    most = whole.next * 1.2
    assert whole.grow(most)
    while not paused.grow(most, pause=pause):
        pass
    assert paused.leaving().keys() == whole.leaving().keys()
