"""The kernel for several cases at once, against the reference."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.mechanics.case_alternatives import CaseAlternatives
from gm_ompl.mechanics.family import worst_loads
from gm_ompl.reference.modes import margin
from tests.uncertain import uncertain_instance
from tests.verify.count_robust_agreement import robust_agreement


@pytest.mark.parametrize("part", range(5))
def test_decides_like_the_reference(part: int) -> None:
    """20 random instants of 1 to 3 fingers and 1 to 32 cases: same verdict, z and f_com to 1e-6.

    Hardly any is left to the reference: those at z = 0, where one f_com must balance all cases.
    """
    results = [robust_agreement(instance) for instance in range(4 * part, 4 * part + 4)]
    for result in results:
        assert result.holds, result.note
    assert sum(result.outcome.startswith("left") for result in results) <= 1


@pytest.mark.parametrize("seed", range(5))
def test_other_choices_are_what_they_are_said_to_be(seed: int) -> None:
    """z of each, and at other f_com, is the reference's; the cut there bounds z elsewhere."""
    rng = np.random.default_rng([seed, 5])
    instant = uncertain_instance(rng, 1 + seed % 2)
    choices = CaseAlternatives.of(instant)
    unit = instant.force_scale
    for decision in choices.modes(1e-6 * unit)[:2]:
        assert np.isfinite(decision.z)
        z = margin(instant, decision.modes, decision.f_com)
        assert z == pytest.approx(decision.z, rel=1e-6, abs=1e-9 * unit)
        best = np.array([f for f in decision.f_com if f is not None])
        if not len(best):
            continue
        found = choices.at(decision.modes, 0.7 * best)
        assert found is not None
        less, c, slopes = found
        there = [None if f is None else 0.7 * f for f in decision.f_com]
        wanted = margin(instant, decision.modes, there)
        assert less == pytest.approx(wanted, rel=1e-6, abs=1e-9 * unit)
        assert less <= decision.z * (1.0 + 1e-6) <= (c + slopes @ best) * (1.0 + 3e-6)


def test_loads_that_cannot_be_the_worst_are_left_out() -> None:
    """A mean of others, and what a floor carries over into one; not what it does not carry."""
    up = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    light, heavy, aside = -up, -1.1 * up, -up + 0.1 * np.eye(6)[0]
    floor = up[None, None]
    assert len(worst_loads(np.array([light, heavy]), floor)) == 1
    assert worst_loads(np.array([light, heavy]), floor)[0] @ up == pytest.approx(-1.0)
    assert len(worst_loads(np.array([light, heavy]), np.zeros((1, 0, 6)))) == 2
    assert len(worst_loads(np.array([light, heavy, 0.5 * (light + heavy)]), floor)) == 1
    assert len(worst_loads(np.array([light, aside]), floor)) == 2
