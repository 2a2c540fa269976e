"""Laws that the kernel's decisions obey whatever the instant."""

from __future__ import annotations

import dataclasses
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.pose import rotation_about
from gm_ompl.mechanics.instant import decide_instant
from gm_ompl.reference.statics import force_unit

SEEDS = st.integers(min_value=0, max_value=10**6)


def same(a: ModeDecision, b: ModeDecision, unit: float, factor: float = 1.0) -> bool:
    """Whether b is a with forces times ``factor``, f_com left aside: it need not be unique."""
    if a.outcome is not b.outcome:
        return False
    if a.outcome is not Outcome.STABLE:
        return True
    return abs(b.z - factor * a.z) <= 1e-6 * factor * max(a.z, 1e-3 * unit)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, length=st.floats(-3, 3), force=st.floats(-3, 4))
def test_units_do_not_matter(
    seed: int, length: float, force: float, instances: ModuleType, agreement: ModuleType
) -> None:
    """Lengths times 1e-3 to 1e3 leave z, forces times 1e-3 to 1e4 scale it."""
    instant = instances.random_instance(np.random.default_rng(seed))
    scaled = instances.rescaled(instant, 10.0**length, 10.0**force)
    before, after = decide_instant(instant), decide_instant(scaled)
    agrees = same(before, after, force_unit(instant), 10.0**force)
    assert agrees or agreement.borderline(instant), (before, after)


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, turns=st.integers(1, 5))
def test_turning_the_world_by_the_pyramids_symmetry(
    seed: int, turns: int, instances: ModuleType, agreement: ModuleType
) -> None:
    """Sliding nowhere, on horizontal contacts: z is the same under a turn of 2 pi / s."""
    rng = np.random.default_rng(seed)
    instant = instances.random_instance(rng)
    up = instant.contacts.rotation[2]
    level = np.abs(instant.contacts.normals @ up - 1.0).max(initial=0.0) < 1e-9
    if not level:
        return
    turn = rotation_about([0, 0, 1], 2.0 * np.pi * turns / instant.cone_edges)
    c = instant.contacts
    turned = dataclasses.replace(
        instant, contacts=ContactState(c.points, c.normals, c.slip, turn @ c.rotation)
    )
    before, after = decide_instant(instant), decide_instant(turned)
    assert same(before, after, force_unit(instant)) or agreement.borderline(instant)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS)
def test_order_does_not_matter(seed: int, instances: ModuleType, agreement: ModuleType) -> None:
    """Contacts and fingers in another order: the same z."""
    rng = np.random.default_rng(seed)
    instant = instances.random_instance(rng)
    c, contacts = instant.contacts, rng.permutation(len(instant.contacts.points))
    fingers = rng.permutation(len(instant.points))
    other = dataclasses.replace(
        instant,
        contacts=ContactState(
            c.points[contacts], c.normals[contacts], c.slip[contacts], c.rotation
        ),
        points=instant.points[fingers],
        normals=instant.normals[fingers],
        friction=instant.friction[fingers],
        max_normal_force=instant.max_normal_force[fingers],
    )
    before, after = decide_instant(instant), decide_instant(other)
    assert same(before, after, force_unit(instant)) or agreement.borderline(instant)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, slack=st.sampled_from([0.0, 1e-9, 1e-6, 1e-3]))
def test_thin_ranges_of_f_com(seed: int, slack: float, agreement: ModuleType) -> None:
    """A block that hangs between two fingers just strong enough for it: as the reference."""
    rng = np.random.default_rng(seed)
    mu = float(rng.uniform(0.2, 1.2))
    weight = float(10.0 ** rng.uniform(-2, 3))
    height = float(rng.uniform(-0.8, 0.8))
    # Friction mu f per finger along the vertical edge of the pyramid.
    limit = weight / (2.0 * mu) * (1.0 + slack)
    none = np.zeros((0, 3))
    instant = Instant(
        contacts=ContactState(none, none, none, np.eye(3)),
        points=np.array([[0.0, 1.0, height], [0.0, -1.0, height]]),
        normals=np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]),
        friction=np.full(2, mu),
        max_normal_force=np.full(2, limit),
        environment_friction=0.5,
        mass=1.0,
        inertia=np.eye(3),
        gravity=weight,
        cone_edges=8,
    )
    found = agreement.compare(instant)
    assert found.holds, found.note


@pytest.mark.parametrize("seed", range(40))
def test_more_force_to_a_passing_hand(seed: int, instances: ModuleType) -> None:
    """Larger limits never lower z: (5) does not depend on them."""
    rng = np.random.default_rng(seed)
    instant = instances.random_instance(rng, int(rng.integers(1, 4)))
    if instant.gravity == 0.0:
        return
    stronger = dataclasses.replace(
        instant, max_normal_force=instant.max_normal_force * rng.uniform(1.0, 3.0)
    )
    before, after = decide_instant(instant), decide_instant(stronger)
    assert after.z >= before.z - 1e-7 * max(abs(before.z), 1e-3 * force_unit(instant)) or (
        before.z == -np.inf
    )


@pytest.mark.parametrize("seed", range(40))
def test_a_decision_keeps_its_own_rules(seed: int, instances: ModuleType) -> None:
    """f_com is within [0, f_max] where force-controlled and None else; z is never negative."""
    instant = instances.random_instance(np.random.default_rng(seed + 500))
    decision = decide_instant(instant)
    if decision.outcome is not Outcome.STABLE:
        assert decision.z == -np.inf
        assert decision.modes == ()
        assert decision.f_com == ()
        return
    assert decision.z >= 0.0
    for mode, f, limit in zip(
        decision.modes, decision.f_com, instant.max_normal_force, strict=True
    ):
        assert (f is None) == (mode is ControlMode.POSITION)
        assert f is None or 0.0 <= f <= limit * (1.0 + 1e-12)
