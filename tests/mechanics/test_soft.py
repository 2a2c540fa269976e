"""Soft fingertips: a moment of up to mu L about the normal, per unit of normal force."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import Outcome
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.mechanics import modes
from gm_ompl.mechanics.alternatives import margin
from gm_ompl.mechanics.instant import decide_instant, instant_program, prove_instant
from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.proof import proven_decision
from gm_ompl.reference.statics import force_unit, statics
from tests.certified import mistake
from tests.instances import random_instance, softened
from tests.mechanics.agreement import borderline, compare, compared, z_error


def soft_instance(seed: int) -> Instant:
    """Return a random instant whose fingertips are soft, or some of them."""
    rng = np.random.default_rng(seed)
    return softened(rng, random_instance(rng))


def with_length(instant: Instant, length: float) -> Instant:
    """Return the instant with the same L for all fingers."""
    return dataclasses.replace(instant, soft=np.full(len(instant.points), length))


def squeezed(L: float, lift: float = 0.0) -> Instant:
    """A cube of mass 1 and side 2 in the air, between two fingertips at its sides."""
    none = np.zeros((0, 3))
    return Instant(
        contacts=ContactState(none, none, none, np.eye(3)),
        points=np.array([[1.0, 0.0, lift], [-1.0, 0.0, lift]]),
        normals=np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        friction=np.full(2, 0.5), max_normal_force=np.full(2, 40.0), environment_friction=0.0,
        mass=1.0, inertia=np.eye(3) * 2.0 / 3.0, gravity=9.8, cone_edges=4, soft=np.full(2, L),
    )  # fmt: skip


@pytest.mark.parametrize("part", range(5))
def test_decides_like_the_reference(part: int) -> None:
    """50 random instants: the same verdict and tie-broken modes, z to 1e-6 of max(z, 1e-3 M g)."""
    for seed in range(10 * part, 10 * part + 10):
        instant = soft_instance(seed)
        found = compare(instant)
        assert found.holds or borderline(instant), f"seed {seed}: {found.note}"


def test_every_decision_is_proven() -> None:
    """What the kernel writes down proves its answer to other code."""
    for seed in range(100, 140):
        instant = soft_instance(seed)
        decision, record = prove_instant(instant)
        assert not mistake(instant, decision, record), f"seed {seed}"


def test_exact_arithmetic_knows_soft_fingers() -> None:
    """What stands in where the kernel proves nothing decides as the kernel does."""
    for seed in range(200, 207):
        instant = soft_instance(seed)
        proven = proven_decision(instant)
        assert proven is not None
        found = compared(decide_instant(instant), proven, force_unit(instant))
        assert found.holds or borderline(instant), f"seed {seed}: {found.note}"


def test_a_length_of_zero_is_a_point() -> None:
    """With L = 0 nothing is added, not even in rounding; a vanishing L leaves z."""
    for seed in range(300, 340):
        instant = random_instance(np.random.default_rng(seed))
        point, none = decide_instant(instant), decide_instant(with_length(instant, 0.0))
        assert point == none
        size = float(np.linalg.norm(instant.points, axis=1).max(initial=1e-9))
        nearly = decide_instant(with_length(instant, 1e-9 * size))
        close = z_error(nearly.z, point.z, force_unit(instant)) if np.isfinite(point.z) else 0.0
        same = nearly.outcome is point.outcome and close <= 1e-6
        assert same or borderline(instant), f"seed {seed}: {point}, {nearly}"


def test_a_point_beside_soft_fingers_stays_one() -> None:
    """A finger that is soft but cannot press makes room for two columns per finger, no more."""
    for seed in range(400, 420):
        rng = np.random.default_rng(seed)
        instant = random_instance(rng, 3)
        limits = np.append(instant.max_normal_force[:2], 0.0)
        point = dataclasses.replace(instant, max_normal_force=limits)
        beside = dataclasses.replace(point, soft=np.array([0.0, 0.0, 0.1]))
        if borderline(point) or borderline(beside):
            continue
        one, other = _best_under_force_control(point), _best_under_force_control(beside)
        assert one[0] == other[0]
        assert one[1] == pytest.approx(other[1], rel=1e-6, abs=1e-9)


def _best_under_force_control(instant: Instant) -> tuple[int, float]:
    """Return how the set of no position-controlled finger ends, and z over the unit of force."""
    program = instant_program(instant)
    end, z, _ = margin(program, 0, 0.0, np.zeros(len(program.f_max)))
    return end, z if end == modes.STABLE else 0.0


def test_stability_grows_with_the_length() -> None:
    """For given modes z never falls as L grows, and does grow at times."""
    grew = 0
    for seed in range(500, 540):
        instant = random_instance(np.random.default_rng(seed))
        size, before = float(np.linalg.norm(instant.points, axis=1).max(initial=1.0)), 0.0
        for length in (0.0, 0.01, 0.1, 1.0):
            end, z = _best_under_force_control(with_length(instant, length * size))
            if end == modes.UNPROVEN:
                break
            assert z >= before - 2e-6 * max(before, 1e-3)
            grew += z > 1.01 * before > 0.0
            before = z
    assert grew > 5


def test_two_soft_fingers_hold_an_object_in_the_air() -> None:
    """Points leave it free to turn about their line: z = 0. Soft ones resist 2 mu L f there.

    By hand, at L = 0.1 and f_max = 40: under the normal force f each finger carries 4.9 N of
    weight, which uses 4.9 / (mu f) of its |f_t| / mu + |m| / (mu L) <= f. What is left of both
    resists a moment of 2 L (mu f - 4.9) about the line; in norm (7) it counts sqrt(3/2) times.
    """
    assert decide_instant(squeezed(0.0)).z == pytest.approx(0.0, abs=1e-9)
    soft = decide_instant(squeezed(0.1))
    assert soft.outcome is Outcome.STABLE
    k = 2.0 * np.sqrt(3.0 - np.sqrt(6.0))
    assert 0.1 < soft.z * k <= np.sqrt(1.5) * 2.0 * 0.1 * (0.5 * 40.0 - 4.9) * (1 + 1e-6)
    assert compare(squeezed(0.1)).holds


def test_soft_fingers_hold_an_object_below_its_centre_of_mass() -> None:
    """Held 0.1 off the line through the centre of mass sideways, points let it swing: no balance.

    The moment M g d = 0.98 about their line needs L (mu f - 4.9) >= 0.49 on each side, which
    40 N give for L >= 0.0325 and not for less.
    """

    def aside(L: float) -> Instant:
        held = squeezed(L)
        return dataclasses.replace(held, points=held.points + np.array([0.0, 0.1, 0.0]))

    assert decide_instant(aside(0.0)).outcome is Outcome.NO_EQUILIBRIUM
    assert decide_instant(aside(0.032)).outcome is Outcome.NO_EQUILIBRIUM
    assert decide_instant(aside(0.033)).outcome is Outcome.STABLE


def test_columns_are_the_definition() -> None:
    """Beside s edges: unit normal force with a moment of +-mu L about the normal; by hand."""
    instant = soft_instance(11)
    instant = dataclasses.replace(instant, soft=np.full(len(instant.points), 0.25))
    tips = instant_program(instant).tips
    model = statics(instant)
    assert len(tips) > 0
    for i, (p, n) in enumerate(zip(instant.points, instant.normals, strict=True)):
        for sign, column in ((1.0, tips[i, -2]), (-1.0, tips[i, -1])):
            moment = np.cross(p, n) + sign * instant.friction[i] * 0.25 * n
            wrench: Array = model.R_sqrt @ np.concatenate([n, moment])
            assert column == pytest.approx(wrench, rel=1e-12, abs=1e-12 * np.abs(wrench).max())
        own = model.rob_wrenches[:, model.columns[i]]
        assert own.shape[1] == instant.cone_edges + 2
        assert pytest.approx(tips[i, -2:], rel=1e-9, abs=1e-9 * np.abs(own).max()) == own[:, -2:].T
    assert decide_modes(instant).outcome is decide_instant(instant).outcome
