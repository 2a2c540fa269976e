"""Cuts: what one set of placements proves about others."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.contact.decision import Outcome
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.mechanics.cuts import PER_STATE, CutPool
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.problem import Placements, Problem
from gm_ompl.scenario.load import load

COARSE = ["fingers.placements.grid=[3, 3]"]


def loaded(name: str) -> tuple[Problem, Judge, KernelBackend]:
    problem = load(name, COARSE).problem
    backend = make_backend(problem)
    assert isinstance(backend, KernelBackend)
    return problem, Judge(problem, backend), backend


def sets(rng: np.random.Generator, problem: Problem, count: int) -> list[Placements]:
    P, n = len(problem.fingers.placements), problem.fingers.count
    return [tuple(sorted(int(p) for p in rng.integers(0, P, n))) for _ in range(count)]


@pytest.mark.parametrize(
    "name",
    ["paper/slide", "paper/push", "paper/tumble", "paper/regrasp", "paper/cork"],
)
def test_every_cut_bounds_every_set(name: str) -> None:
    """Cuts left by decisions with thresholds never fall below the exact z of any other set."""
    problem, judge, backend = loaded(name)
    rng = np.random.default_rng(0)
    everyone = tuple(range(problem.fingers.count))
    states = [
        judge.environment(problem.motion.moment((float(s),), (0.1,)))
        for s in rng.uniform(0.05, 0.9, 3)
    ]
    z_min = problem.mechanics.z_min
    for state in states:
        for placements in sets(rng, problem, 25):
            backend.decide(state, everyone, placements, float(rng.choice([0.1, 1.0, 5.0])) * z_min)
    exact = KernelBackend(problem)
    plain = Judge(problem, exact)
    tried = 0
    rng = np.random.default_rng(0)
    for s, state in zip(rng.uniform(0.05, 0.9, 3), states, strict=True):
        there = plain.environment(problem.motion.moment((float(s),), (0.1,)))
        for placements in sets(rng, problem, 40):
            decision = exact.decide(there, everyone, placements)
            if decision.outcome is Outcome.STABLE:
                rows = np.asarray(placements, dtype=np.int64)
                bound = backend.pool.bound(state, rows) * backend.scale
                assert bound >= decision.z * (1.0 - 1e-9) - 1e-9 * backend.scale
                tried += 1
    assert tried > 5


def test_the_pool_forgets_the_oldest() -> None:
    """A contact state keeps its newest PER_STATE cuts; others keep theirs."""
    rng = np.random.default_rng(0)
    tips = rng.normal(size=(2, 5, 6, 6))
    pool = CutPool(tips, np.ones(2), DIRECTIONS)
    q, rows = rng.normal(size=6), np.array([1, 3])
    assert pool.bound(7, rows) == np.inf
    ys = rng.normal(size=(PER_STATE + 3, 6))
    pool.add(0, q, ys[0])
    first = pool.bound(0, rows)
    for y in ys[1:]:
        pool.add(1, q, y)
    pool.add(1, q, ys[0])
    assert pool.tables.counts.tolist()[:2] == [1, PER_STATE]
    assert pool.bound(0, rows) == first
    newest = [
        (q @ y + np.maximum((tips[[0, 1], rows] @ y).max(axis=1), 0.0).sum())
        / (DIRECTIONS @ y).max()
        for y in [*ys[4:], ys[0]]
    ]
    assert pool.bound(1, rows) == pytest.approx(min(newest), rel=1e-12)
    pool.clear()
    assert pool.bound(0, rows) == np.inf
