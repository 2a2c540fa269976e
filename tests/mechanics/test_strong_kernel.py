"""The kernel's z_strong against the reference's, and modes and commands chosen by it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome, command_steps
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import Instant
from gm_ompl.mechanics.strongest import strong_choices, strongest, strongly_held
from gm_ompl.reference.modes import decide_modes, margin
from gm_ompl.reference.strong import strong_margin
from gm_ompl.reference.strongest import decide_strongly
from gm_ompl.scenario.load import load
from tests.instances import rescaled
from tests.reference.test_strong import small_instant


def points(seed: int) -> Instant:
    """Return a small random instant with point fingertips."""
    return replace(small_instant(seed), soft=np.zeros(0))


def held(instant: Instant) -> tuple[float, float]:
    """Return z_strong of what Sec. 3.4 decides, by the kernel and by the reference."""
    return held_with(instant, decide_modes(instant))


def held_with(instant: Instant, decision: ModeDecision) -> tuple[float, float]:
    """Return z_strong of a decision, by the kernel and by the reference."""
    reference = strong_margin(instant, decision.modes, decision.f_com, decision.z).z
    return strongly_held(instant, decision), reference


@pytest.mark.parametrize("seed", range(8))
def test_the_kernel_finds_what_the_reference_finds(seed: int) -> None:
    """Branch and bound on tableaux, and over HiGHS: the same z_strong."""
    instant = points(seed)
    kernel, reference = held(instant)
    assert kernel == pytest.approx(reference, rel=1e-6, abs=1e-7 * instant.force_scale)


def test_rows_that_nearly_depend_on_others() -> None:
    """A box on its edge, pinched: a way to slide that is all but ruled out is ruled out."""
    problem = load("paper/tumble").problem
    table = problem.fingers.placements
    rows = tuple(table.find(face, (5, 4)) or 0 for face in ("+y", "-y"))
    moment = problem.motion.moment((0.1 + 1.0 / 180.0,), (1.0,))
    contacts = contacts_at(moment, problem.body, problem.environment)
    instant = problem.instant(contacts, (0, 1), rows)
    modes, f_com = (ControlMode.FORCE, ControlMode.POSITION), (10.0, None)
    z = margin(instant, modes, f_com)
    kernel, reference = held_with(instant, ModeDecision(Outcome.STABLE, z, modes, f_com))
    assert kernel == pytest.approx(reference, rel=1e-6)


@pytest.mark.parametrize("seed", [11, 14, 16, 23])
def test_it_chooses_as_well_as_a_plain_trial(seed: int) -> None:
    """All modes and commands, one by one in HiGHS, hold no more than those chosen."""
    instant = points(seed)
    plain, found = decide_strongly(instant), strongest(instant)
    assert found.z == pytest.approx(plain.z, rel=1e-6, abs=1e-7 * instant.force_scale)
    assert found.nominal is not None
    assert found.z <= found.nominal + 1e-9 * instant.force_scale


def test_commands_are_offered_and_units_do_not_matter() -> None:
    """Chosen commands are among those offered; other units change nothing but numbers."""
    for seed in range(40, 46):
        instant = points(seed)
        found = strongest(instant)
        again = strongest(rescaled(instant, length=1e3, force=1e-2))
        assert again.z == pytest.approx(1e-2 * found.z, rel=1e-5, abs=1e-9 * instant.force_scale)
        steps = command_steps(found.modes.count(ControlMode.FORCE))
        shares = [
            f / most
            for f, most in zip(found.f_com, instant.max_normal_force, strict=True)
            if f is not None
        ]
        assert all(min(abs(share - step) for step in steps) < 1e-12 for share in shares)


def test_a_threshold_that_is_missed_leaves_a_bound() -> None:
    """Asked for more than there is, the decision is BELOW, its bound not below the best."""
    bounded = 0
    for seed in range(60, 70):
        instant = points(seed)
        best = strongest(instant).z
        missed = strongest(instant, 1.5 * best + 1e-6 * instant.force_scale)
        assert missed.outcome is Outcome.BELOW
        assert best - 1e-9 * instant.force_scale <= missed.z
        bounded += strongest(instant, 0.9 * best).z == pytest.approx(best)
    assert bounded == 10


def test_each_combination_of_modes_is_told_by_itself() -> None:
    """The best of the combinations is the choice."""
    for seed in range(80, 84):
        instant = points(seed)
        choices, best = strong_choices(instant), strongest(instant)
        assert bool(choices) is (best.outcome is Outcome.STABLE)
        assert max([choice.z for choice in choices] or [best.z]) == pytest.approx(best.z)
        assert len({choice.modes for choice in choices}) == len(choices)
