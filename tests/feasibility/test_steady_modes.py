"""The choice of modes along a plan."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import pytest

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.feasibility.steady_modes import fewest_switches, spread, switches

P, F = ControlMode.POSITION, ControlMode.FORCE


def decision(*modes: ControlMode) -> ModeDecision:
    f_com = tuple(1.0 if mode is F else None for mode in modes)
    return ModeDecision(Outcome.STABLE, 1.0, modes, f_com)


def total(chosen: list[ModeDecision], fingers: list[tuple[int, ...]], count: int) -> int:
    modes = [spread(d, touching, count) for d, touching in zip(chosen, fingers, strict=True)]
    return sum(switches(a, b) for a, b in itertools.pairwise(modes))


@pytest.mark.parametrize("seed", range(30))
def test_no_other_choice_switches_less(seed: int) -> None:
    """Against every combination of choices, with fingers lifted now and then."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    options: list[list[ModeDecision]] = []
    fingers: list[tuple[int, ...]] = []
    for _ in range(6):
        lifted = int(rng.integers(-4, count))
        touching = tuple(i for i in range(count) if i != lifted)
        every = list(itertools.product((P, F), repeat=len(touching)))
        picked = rng.permutation(len(every))[: int(rng.integers(1, 4))]
        options.append([decision(*every[k]) for k in picked])
        fingers.append(touching)
    chosen = fewest_switches(options, fingers, count)
    assert all(d in choices for d, choices in zip(chosen, options, strict=True))
    best = min(total(list(way), fingers, count) for way in itertools.product(*options))
    assert total(chosen, fingers, count) == best


@pytest.mark.parametrize("seed", range(15))
def test_what_is_broken_is_passed_least_then_switches_count(seed: int) -> None:
    """Against every combination of choices, some pairs of neighbours forbidden."""
    rng = np.random.default_rng(seed)
    every = list(itertools.product((P, F), repeat=2))
    options = [[decision(*every[k]) for k in rng.permutation(4)[:3]] for _ in range(5)]
    fingers: list[tuple[int, ...]] = [(0, 1)] * 5
    broken = {
        (k, a.modes, b.modes)
        for k in range(4)
        for a, b in itertools.product(options[k], options[k + 1])
        if rng.random() < 0.7
    }

    def price(way: Sequence[ModeDecision]) -> tuple[int, int]:
        steps = [(k, a.modes, b.modes) for k, (a, b) in enumerate(itertools.pairwise(way))]
        return len(broken.intersection(steps)), total(list(way), fingers, 2)

    chosen = fewest_switches(options, fingers, 2, broken)
    assert price(chosen) == min(price(way) for way in itertools.product(*options))


def test_a_lifted_finger_may_come_back_in_the_other_mode() -> None:
    """Only the finger that stays in contact is counted, through the rest as well."""
    before, after = (P, F), (F, P)
    rest = spread(decision(F), (1,), 2)
    assert switches(before, rest) == 0
    assert switches(rest, after) == 1


def test_among_equal_choices_position_control_is_preferred() -> None:
    """Two ways without a switch: the one with more position control, then the first fingers."""
    options = [[decision(F, F), decision(F, P), decision(P, F)]] * 3
    chosen = fewest_switches(options, [(0, 1)] * 3, 2)
    assert [d.modes for d in chosen] == [(P, F)] * 3
