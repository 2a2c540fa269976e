"""z_strong against every mode of every contact, its laws, and cases known by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from gm_ompl.contact.decision import ControlMode, Outcome
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.reference.modes import decide_modes, margin
from gm_ompl.reference.stability import DIRECTIONS
from gm_ompl.reference.statics import scaling_root
from gm_ompl.reference.strong import StrongMargin, only_zero, strong_margin
from tests.instances import random_instance, rescaled
from tests.reference.brute_strong import brute_strong


def small_instant(seed: int) -> Instant:
    """Return a random instant with few contacts and coarse cones, stable as it is decided."""
    rng = np.random.default_rng(seed)
    while True:
        instant = random_instance(rng, int(rng.integers(0, 3)))
        instant = replace(instant, cone_edges=3)
        static = sum(not slip.any() for slip in instant.contacts.slip) + len(instant.points)
        if static > 2 or len(instant.contacts.points) > 4:
            continue
        if static == 1:
            instant = replace(instant, soft=np.full(len(instant.points), 0.3))
        decision = decide_modes(instant)
        if decision.outcome is Outcome.STABLE and 0.0 < decision.z < np.inf:
            return instant


def held(instant: Instant) -> StrongMargin:
    """Return what is strongly held with the modes of Sec. 3.4."""
    decision = decide_modes(instant)
    return strong_margin(instant, decision.modes, decision.f_com, decision.z)


@pytest.mark.parametrize("seed", range(6))
def test_every_mode_tried_gives_the_same(seed: int) -> None:
    """Branch and bound finds what trying all combinations of modes finds."""
    instant = small_instant(seed)
    decision = decide_modes(instant)
    strong = held(instant)
    brute = brute_strong(instant, decision.modes, decision.f_com, decision.z)
    assert strong.z == pytest.approx(brute, rel=1e-6, abs=1e-7 * instant.force_scale)


@pytest.mark.parametrize("seed", range(6))
def test_the_disturbance_told_is_of_that_size(seed: int) -> None:
    """The wrench under which contacts give way lies on the hull of z_strong l_i, not inside."""
    instant = small_instant(seed + 100)
    strong = held(instant)
    if not strong.modes:
        assert not strong.wrench.any()
        return
    wrench = scaling_root(instant.mass, instant.inertia) @ strong.wrench
    gauge = linprog(np.ones(len(DIRECTIONS)), A_eq=DIRECTIONS.T, b_eq=wrench)
    assert gauge.fun == pytest.approx(strong.z, rel=1e-6, abs=1e-9 * instant.force_scale)


@pytest.mark.parametrize("seed", range(6))
def test_units_do_not_matter(seed: int) -> None:
    """In other units of length and force z_strong is the same force."""
    instant = small_instant(seed + 200)
    strong = held(instant)
    again = held(rescaled(instant, length=1e3, force=1e-2))
    assert again.z == pytest.approx(1e-2 * strong.z, rel=1e-5, abs=1e-9 * instant.force_scale)


def block(friction: float, half: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Instant:
    """Return a block of weight 1 that rests on the floor on its four corners, untouched."""
    a, b, c = half
    corners = np.array([(x, y, -c) for x in (-a, a) for y in (-b, b)])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    contacts = ContactState(corners, up, np.zeros((4, 3)), np.eye(3))
    none = np.zeros((0, 3))
    squares = np.array(half) ** 2
    return Instant(
        contacts, none, none, np.zeros(0), np.zeros(0), friction, mass=1.0,
        inertia=np.diag(squares.sum() - squares) / 3.0, gravity=1.0,
    )  # fmt: skip


def test_a_block_on_a_slippery_floor_slides() -> None:
    """With friction 0 nothing holds it, whatever is asked."""
    strong = strong_margin(block(0.0), (), (), 1.0)
    assert strong.z == 0.0
    assert all("slides" in what or "open" in what for what in strong.modes)


@pytest.mark.parametrize(("friction", "opens"), [(0.5, 0), (2.0, 2)])
def test_a_block_turns_on_a_slippery_floor_and_tips_on_a_rough_one(
    friction: float, opens: int
) -> None:
    """It gives way before z: how its corners share the load is not known."""
    instant = replace(block(friction), cone_edges=4)
    z = margin(instant, (), ())
    strong = strong_margin(instant, (), (), z)
    assert 0.75 * z < strong.z < z
    assert sum("open" in what for what in strong.modes) >= opens


def test_a_hinge_held_by_a_commanded_force_gives_way() -> None:
    """A block on its edge, balanced over it, pressed from above with a commanded force.

    The fingertip follows along its normal, straight over the edge: no load that turns the block
    about the edge is answered by more than friction at the fingertip, and none if that has none.
    """
    edge = np.array([[0.0, -1.0, -1.0], [0.0, 1.0, -1.0]])
    contacts = ContactState(edge, np.tile([0.0, 0.0, 1.0], (2, 1)), np.zeros((2, 3)), np.eye(3))
    instant = Instant(
        contacts, np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, -1.0]]), np.zeros(1),
        np.ones(1), 0.5, mass=1.0, inertia=np.eye(3), gravity=1.0,
    )  # fmt: skip
    assert strong_margin(instant, (ControlMode.FORCE,), (0.5,), 1.0).z == pytest.approx(0.0)


def test_which_cones_hold_nothing_but_zero() -> None:
    """Stiemke's theorem, on cones known by hand."""
    ones, none = np.eye(6), np.zeros((0, 6))
    assert only_zero(none, ones)
    assert only_zero(np.vstack([ones, -ones.sum(axis=0)]), none)
    assert not only_zero(ones, none)
    assert not only_zero(np.vstack([ones[:5], -ones[:5].sum(axis=0)]), none)
    assert not only_zero(none, ones[:5])
    assert only_zero(np.vstack([ones[0], -ones[0]]), ones[1:])
