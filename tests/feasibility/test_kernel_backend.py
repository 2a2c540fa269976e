"""The kernel's back end: memo, keys, batches."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gm_ompl.contact.decision import Outcome
from gm_ompl.contact.state import ContactState
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load


@pytest.fixture(scope="module")
def tumble() -> Problem:
    return load("paper/tumble", ["fingers.placements.grid=[3, 3]"]).problem


@pytest.mark.parametrize("below", [0.0, 0.5])
def test_batches_answer_like_single_decisions(tumble: Problem, below: float) -> None:
    """``decide_many`` on both cores: the very answers of ``decide``, each computed once."""
    rng = np.random.default_rng(1)
    one, many = KernelBackend(tumble), KernelBackend(tumble)
    judges = [Judge(tumble, backend) for backend in (one, many)]
    states = [
        [judge.environment(tumble.motion.moment((s,), (0.1,))) for s in (0.1, 0.45, 0.8)]
        for judge in judges
    ]
    assert states[0] == states[1]
    which = np.array([states[0][k] for k in rng.integers(0, 3, 120)])
    sets = np.sort(rng.integers(0, len(tumble.fingers.placements), (120, 2)), axis=1)
    expected = [
        one.decide(int(state), (0, 1), tuple(rows), below)
        for state, rows in zip(which, sets.tolist(), strict=True)
    ]
    assert many.decide_many(which, sets, below) == expected
    assert many.decisions == one.decisions == len(one.decided())
    assert sorted(many.decided()) == sorted(one.decided())
    again = many.decide_many(which, sets, below)
    assert again == expected
    assert many.decisions == one.decisions
    assert {d.outcome for d in expected} >= {Outcome.STABLE}


def test_an_empty_batch(tumble: Problem) -> None:
    """Nothing asked, nothing answered."""
    none = np.zeros((0, 2), dtype=np.int64)
    assert KernelBackend(tumble).decide_many(np.zeros(0, dtype=np.int64), none) == []


def test_contact_states_are_known_whatever_their_order(tumble: Problem) -> None:
    """The same contacts in another order are the same state; other contacts are not."""
    backend = KernelBackend(tumble)
    floor = np.array([[x, y, -5.0] for x in (-2.5, 2.5) for y in (-2.5, 2.5)])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    state = ContactState(floor, up, np.zeros((4, 3)), np.eye(3))
    number = backend.environment(state)
    for order in ([1, 3, 2, 0], [3, 2, 1, 0], [1, 2, 3, 0]):
        turned = dataclasses.replace(state, points=floor[order])
        assert backend.environment(turned) == number
    moved = dataclasses.replace(state, points=floor + np.array([0.01, 0.0, 0.0]))
    sliding = dataclasses.replace(state, slip=np.tile([1.0, 0.0, 0.0], (4, 1)))
    assert len({number, backend.environment(moved), backend.environment(sliding)}) == 3


def test_a_bound_becomes_exact_when_asked(tumble: Problem) -> None:
    """A decision with a threshold is decided anew only where its bound does not answer."""
    backend = KernelBackend(tumble)
    judge = Judge(tumble, backend)
    state = judge.environment(tumble.motion.moment((0.3,), (0.1,)))
    rng = np.random.default_rng(0)
    for placements in np.sort(rng.integers(0, 54, (60, 2)), axis=1).tolist():
        rough = backend.decide(state, (0, 1), tuple(placements), 20.0)
        before = backend.decisions
        assert backend.decide(state, (0, 1), tuple(placements), 30.0) == rough
        assert backend.decisions == before
        exact = backend.decide(state, (0, 1), tuple(placements))
        assert exact.outcome is not Outcome.BELOW
        assert exact.z <= rough.z * (1.0 + 1e-9)
        backend.forget()
