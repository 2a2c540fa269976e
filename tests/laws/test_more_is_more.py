"""More force, more friction, more facets: what z does."""

from __future__ import annotations

import dataclasses
from types import ModuleType

import numpy as np
import pytest

from gm_ompl.contact.environment import Environment, contact_state, environment_contacts
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.geometry.solids import Body, hull, mass_properties
from gm_ompl.mechanics import modes
from gm_ompl.mechanics.alternatives import margin
from gm_ompl.mechanics.instant import instant_program
from gm_ompl.reference.exact import Effort
from gm_ompl.reference.exact_command import exact_best
from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.statics import statics


def z_of(instant: Instant, mask: int) -> float:
    """z with the best f_com for a fixed set of position-controlled fingers; Problem (5) unasked.

    The kernel proves nothing for sets that fail (5): exact arithmetic decides those.
    """
    program = instant_program(instant)
    end, z, _ = margin(program, mask, 0.0, np.zeros(len(program.f_max)))
    if end == modes.UNPROVEN:
        force = np.array([not mask >> i & 1 for i in range(len(program.f_max))], dtype=bool)
        z = min(exact_best(statics(instant), force, Effort()).least, 1e9)
    return float(z) * instant.force_scale


@pytest.mark.parametrize("seed", range(25))
def test_z_never_falls_when_limits_or_friction_grow(seed: int, instances: ModuleType) -> None:
    """For fixed modes: a finger's limit, a finger's friction, the static contacts' friction."""
    rng = np.random.default_rng(seed)
    instant = instances.random_instance(rng, int(rng.integers(1, 4)))
    mask = int(rng.integers(1 << len(instant.points)))
    i = int(rng.integers(len(instant.points)))
    limits, friction = instant.max_normal_force.copy(), instant.friction.copy()
    limits[i] *= rng.uniform(1.0, 3.0)
    friction[i] *= rng.uniform(1.0, 2.0)
    grown = [
        dataclasses.replace(instant, max_normal_force=limits),
        dataclasses.replace(instant, friction=friction),
    ]
    if not instant.contacts.slip.any():
        more = instant.environment_friction * rng.uniform(1.0, 2.0)
        grown.append(dataclasses.replace(instant, environment_friction=more))
    z = z_of(instant, mask)
    for other in grown:
        assert other.force_scale == pytest.approx(instant.force_scale) or instant.gravity == 0
        assert z_of(other, mask) >= z - 1e-7 * max(abs(z), 1e-3 * instant.force_scale)


@pytest.mark.parametrize("seed", range(15))
def test_z_never_falls_when_more_is_touched(seed: int, instances: ModuleType) -> None:
    """For fixed modes: a contact more, sliding or not, can only help to resist."""
    rng = np.random.default_rng(1000 + seed)
    instant = instances.random_instance(rng, int(rng.integers(1, 4)))
    contacts = instant.contacts
    kept = rng.random(len(contacts.points)) < 0.7
    fewer = ContactState(
        contacts.points[kept], contacts.normals[kept], contacts.slip[kept], contacts.rotation
    )
    mask = int(rng.integers(1 << len(instant.points)))
    less = z_of(dataclasses.replace(instant, contacts=fewer), mask)
    assert z_of(instant, mask) >= less - 1e-7 * max(abs(less), 1e-3 * instant.force_scale)


def cylinder(facets: int) -> Body:
    """A cylinder of radius 1 and height 2 about z; a corner at angle 0."""
    angle = 2 * np.pi * np.arange(facets) / facets
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Body((hull([[x, y, z] for z in (-1.0, 1.0) for x, y in ring]),))


TWISTS = {
    "at rest": None,
    "sliding": Twist(np.array([1.0, 0.3, 0.0]), np.zeros(3)),
    "turning": Twist(np.zeros(3), np.array([0.0, 0.0, 1.0])),
    "both": Twist(np.array([0.4, -0.1, 0.0]), np.array([0.0, 0.0, 0.5])),
}


@pytest.mark.parametrize("name", TWISTS)
def test_a_cylinder_of_many_facets_converges(name: str) -> None:
    """z at fixed fingertip points, 12, 24, 48, 96 facets: within 8 / n^2 of that with 192."""
    pose, found = Pose(np.eye(3), np.array([0.0, 0.0, 1.0])), []
    many = np.array([12, 24, 48, 96, 192])
    for facets in many:
        body = cylinder(int(facets))
        contacts = environment_contacts(body, Environment(True, (), 0.4), pose)
        assert len(contacts.points) == facets
        instant = Instant(
            contacts=contact_state(contacts, pose, TWISTS[name], body),
            points=np.array([[1.0, 0.0, -0.5], [-1.0, 0.0, -0.4]]),
            normals=np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
            friction=np.full(2, 0.8), max_normal_force=np.full(2, 12.0), environment_friction=0.4,
            mass=1.0, inertia=mass_properties(body, 1.0).inertia, gravity=9.8,
        )  # fmt: skip
        found.append(decide_modes(instant).z)
    errors = np.abs(np.array(found[:-1]) - found[-1]) / found[-1]
    assert found[-1] > 0.1
    assert (errors <= 8.0 / many[:-1] ** 2).all()
