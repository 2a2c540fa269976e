"""Equilibrium under given commands: what the reference says of a junction's ends."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.reference.equilibrium import in_equilibrium
from gm_ompl.reference.junction import equilibrium
from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.statics import statics
from tests.reference.conftest import MakeBox

P, F = ControlMode.POSITION, ControlMode.FORCE


def pushed(box: MakeBox, slip: float, mu_finger: float) -> Instant:
    return box([[-2.5, 0.0, -2.5]], [[1.0, 0.0, 0.0]], slip=[slip, 0.0, 0.0], mu_finger=mu_finger)


@pytest.mark.parametrize("f", [0.0, 2.0, 4.899, 4.901, 9.0])
def test_a_box_at_rest_bears_a_push_up_to_friction(box: MakeBox, f: float) -> None:
    """Coulomb: mu M g = 4.9, at the floor's height and without friction at the finger."""
    assert equilibrium(pushed(box, 0.0, 0.0), [F], [f]) == (f <= 4.9)


def test_a_sliding_box_needs_friction_to_be_met(box: MakeBox) -> None:
    """In motion the push is mu M g, no less and no more; a position-controlled finger finds it."""
    sliding = pushed(box, 1.0, 0.0)
    assert [equilibrium(sliding, [F], [f]) for f in (4.8, 4.9, 5.0)] == [False, True, False]
    assert equilibrium(sliding, [P], [None])


def _random(instances: ModuleType, seed: int) -> tuple[Instant, np.random.Generator]:
    rng = np.random.default_rng([seed, 9])
    return instances.random_instance(rng, 1 + seed % 3), rng


def test_where_both_ends_balance_the_ramp_does(instances: ModuleType) -> None:
    """Commands that can be balanced form a convex set: no point between need be tried."""
    tried = 0
    for seed in range(60):
        instant, rng = _random(instances, seed)
        n = len(instant.points)
        modes = [F if i == 0 or rng.random() < 0.5 else P for i in range(n)]
        ends = rng.uniform(0.0, 1.0, size=(2, n)) * instant.max_normal_force
        if all(_held(instant, modes, end) for end in ends):
            tried += 1
            for share in (0.2, 0.5, 0.7):
                assert _held(instant, modes, ends[0] + share * (ends[1] - ends[0]))
    assert tried >= 10


def _held(instant: Instant, modes: list[ControlMode], f: Array) -> bool:
    return equilibrium(
        instant, modes, [x if m is F else None for m, x in zip(modes, f, strict=True)]
    )


def test_a_decision_with_a_margin_is_its_own_junction(instances: ModuleType) -> None:
    """Equal modes, commands and contacts need no test: z > 0 has forces that balance."""
    tried = 0
    for seed in range(30):
        instant, _ = _random(instances, seed)
        decision = decide_modes(instant)
        if decision.outcome is Outcome.STABLE and decision.z > 0.0:
            assert equilibrium(instant, decision.modes, decision.f_com)
            tried += 1
    assert tried >= 5


def test_least_squares_and_the_solver_agree(instances: ModuleType) -> None:
    """Against HiGHS alone, commands drawn and fingers under position control."""
    answers = []
    for seed in range(100):
        instant, rng = _random(instances, seed)
        model, n = statics(instant), len(instant.points)
        modes = [F if rng.random() < 0.5 else P for _ in range(n)]
        f = rng.uniform(size=n) * instant.max_normal_force
        force = np.array([mode is F for mode in modes])
        limits = np.where(force, f / model.scale, model.f_max)
        answers.append(_held(instant, modes, f))
        assert answers[-1] == in_equilibrium(model, limits, force)
    assert 20 <= sum(answers) <= 80
