"""What holds in all cases holds in every world of the ranges; wider ranges leave less."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.errors import SolverError
from gm_ompl.mechanics.case_alternatives import decide_in_cases
from gm_ompl.mechanics.instant import decide_instant
from gm_ompl.reference.internal_force import excessive_internal_force
from gm_ompl.reference.modes import margin
from gm_ompl.reference.robust import margin_in
from gm_ompl.reference.statics import statics
from gm_ompl.uncertainty.ranges import Uncertainty
from gm_ompl.uncertainty.worlds import NOMINAL, cases_of, corner_count, corners, draw, in_world
from tests.instances import rescaled
from tests.uncertain import uncertain_instance


@functools.cache
def found(seed: int) -> tuple[Instant, ModeDecision]:
    """Return an uncertain instant with a decision that has a margin."""
    rng = np.random.default_rng([seed, 4])
    while True:
        instant = uncertain_instance(rng)
        try:
            decision = decide_in_cases(instant)
        except SolverError:
            continue
        if decision.outcome is Outcome.STABLE and 0.0 < decision.z < np.inf:
            return instant, decision


def stable(seed: int) -> tuple[Instant, ModeDecision, np.random.Generator]:
    """Return an uncertain instant with its decision, and random numbers."""
    return *found(seed), np.random.default_rng([seed, 5])


def sliding(instant: Instant) -> int:
    """Return how many contacts slide with friction that is not known exactly."""
    uncertain = any(instant.uncertainty.environment_friction)
    return int(np.any(instant.contacts.slip, axis=1).sum()) * uncertain


@pytest.mark.parametrize("seed", range(6))
def test_what_holds_in_all_cases_holds_in_all_worlds(seed: int) -> None:
    """For load, commands, static friction and one sliding contact the corners suffice.

    Where several contacts slide with one coefficient, or fingertips shift, worlds between may hold
    a little less: here at most a fiftieth.
    """
    instant, decision, rng = stable(seed)
    exact = sliding(instant) <= 1 and not instant.uncertainty.position
    short = 1e-6 if exact else 0.02
    allowed = short * max(decision.z, 1e-3 * instant.force_scale)
    n = len(instant.points)
    for _ in range(8):
        world = draw(instant.uncertainty, n, rng)
        z = margin_in(instant, decision.modes, decision.f_com, world)
        assert z >= decision.z - allowed, (seed, world)
        position = [i for i, mode in enumerate(decision.modes) if mode is ControlMode.POSITION]
        there = statics(in_world(instant, world))
        assert not excessive_internal_force(there, position).excessive


@pytest.mark.parametrize("seed", range(6))
def test_the_margin_is_reached_in_some_case(seed: int) -> None:
    """z is the least of the cases, each of them solved anew, no less."""
    instant, decision, _ = stable(seed)
    worlds = [world for _, world in cases_of(instant)]
    z = [margin_in(instant, decision.modes, decision.f_com, world) for world in worlds]
    assert min(z) == pytest.approx(decision.z, rel=1e-6, abs=1e-9 * instant.force_scale)


@pytest.mark.parametrize("seed", range(6))
def test_the_margin_falls_as_ranges_grow(seed: int) -> None:
    """Half the ranges hold at least as much, none at all at least as much as that."""
    instant, decision, _ = stable(seed)
    half = dataclasses.replace(instant, uncertainty=instant.uncertainty.scaled(0.5))
    none = dataclasses.replace(instant, uncertainty=Uncertainty())
    allowed = 1e-6 * max(decision.z, 1e-3 * instant.force_scale)
    try:
        z = decide_in_cases(half).z
        assert decision.z - allowed <= z <= decide_instant(none).z + allowed
    except SolverError:
        pytest.skip("the kernel leaves one to the reference")


@pytest.mark.parametrize("seed", range(6))
def test_no_range_is_the_nominal_world(seed: int) -> None:
    """Ranges of no width are none; what the cases' code makes of them is the nominal decision."""
    instant, _, _ = stable(seed)
    bare = dataclasses.replace(instant, uncertainty=Uncertainty())
    assert not instant.uncertainty.scaled(0.0)
    assert cases_of(bare) == ((bare, NOMINAL),)
    one, other = decide_in_cases(bare), decide_instant(bare)
    assert (one.outcome, one.modes) == (other.outcome, other.modes)
    assert one.z == pytest.approx(other.z, rel=1e-9)
    if one.modes:
        still = in_world(bare, NOMINAL)
        assert margin(still, one.modes, one.f_com) == margin(bare, one.modes, one.f_com)


def mirrored(instant: Instant) -> Instant:
    """Return the instant behind a mirror in the plane y = 0 of the object."""
    c, flip = instant.contacts, np.array([1.0, -1.0, 1.0])
    contacts = ContactState(
        c.points * flip, c.normals * flip, c.slip * flip, flip[:, None] * c.rotation * flip
    )
    return dataclasses.replace(
        instant, contacts=contacts, points=instant.points * flip, normals=instant.normals * flip,
        inertia=flip[:, None] * instant.inertia * flip,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_neither_units_nor_mirrors_matter(seed: int) -> None:
    """Lengths times 7 and forces times 0.3, ranges with them; left and right exchanged."""
    instant, decision, _ = stable(seed)
    ranges = instant.uncertainty
    x, y, z = ranges.centre_of_mass
    scaled = dataclasses.replace(
        ranges, centre_of_mass=(7.0 * x, 7.0 * y, 7.0 * z), position=7.0 * ranges.position
    )
    other = dataclasses.replace(rescaled(instant, 7.0, 0.3), uncertainty=scaled)
    assert decide_in_cases(other).z == pytest.approx(0.3 * decision.z, rel=1e-6)
    if instant.cone_edges % 2 == 0:
        seen = decide_in_cases(mirrored(instant))
        assert seen.z == pytest.approx(decision.z, rel=1e-6)


def test_a_box_between_two_fingers_is_lifted_with_what_the_mass_leaves() -> None:
    """By hand: more mass, less is left.

    Two fingers press on a box from both sides and carry it by friction: the most they can lift is
    2 mu f_com, so what a downward force may add is 2 mu f_com - M g.
    """
    none = np.zeros((0, 3))
    instant = Instant(
        contacts=ContactState(none, none, none, np.eye(3)),
        points=np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]),
        normals=np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        friction=np.full(2, 0.5), max_normal_force=np.full(2, 40.0), environment_friction=0.0,
        mass=1.0, inertia=np.eye(3), gravity=10.0, cone_edges=4, soft=np.full(2, 0.5),
        uncertainty=Uncertainty(finger_friction=(0.05, 0.05), mass=0.2),
    )  # fmt: skip
    modes, f_com = (ControlMode.POSITION, ControlMode.FORCE), (None, 20.0)
    worlds = corners(instant.uncertainty, 2, 1.0)
    assert len(worlds) == corner_count(instant.uncertainty, 2) == 2
    assert [world.mass for world in worlds] == pytest.approx([-0.2, 0.2])
    # l_i along -z has length k = 1.484; the load leaves 2 * 0.45 * 20 - 12 = 6 of friction.
    k = 2.0 * np.sqrt(3.0 - np.sqrt(6.0))
    heavy = margin_in(instant, modes, f_com, worlds[1])
    assert 0.0 < heavy <= 6.0 / k + 1e-6
    assert heavy < margin_in(instant, modes, f_com, NOMINAL)
