"""The compiled kernel, against the reference's linear programs and at its edges."""

from __future__ import annotations

import dataclasses
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from gm_ompl.contact.decision import ControlMode, Outcome
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.errors import ShapeError
from gm_ompl.mechanics import modes
from gm_ompl.mechanics.alternatives import margin
from gm_ompl.mechanics.certificate import NO_RECORD
from gm_ompl.mechanics.instant import DIRECTIONS, decide_instant, instant_program, touching
from gm_ompl.mechanics.internal_force import FAILS, separate
from gm_ompl.reference.modes import all_mode_sets, decide_modes
from gm_ompl.reference.stability import DIRECTIONS as PAPERS_DIRECTIONS
from gm_ompl.reference.statics import force_unit

NOBODY = np.zeros((0, 3))


@pytest.mark.parametrize("part", range(10))
def test_decides_like_the_reference(
    part: int, instances: ModuleType, agreement: ModuleType
) -> None:
    """300 random instants: the same verdict and tie-broken modes, z to 1e-6 of max(z, 1e-3 M g)."""
    for seed in range(30 * part, 30 * part + 30):
        instant = instances.random_instance(np.random.default_rng(seed))
        found = agreement.compare(instant)
        assert found.holds or agreement.borderline(instant), f"seed {seed}: {found.note}"


@pytest.mark.parametrize("seed", range(1000, 1024))
def test_every_mode_set_agrees(seed: int, instances: ModuleType, agreement: ModuleType) -> None:
    """Each combination of modes by itself: the verdict of (5), and z of (6) where it passes."""
    instant = instances.random_instance(np.random.default_rng(seed), 1 + seed % 3)
    program = instant_program(instant)
    env, _, tips, f_max, _ = program
    P = np.empty((len(env) + len(f_max) * instant.cone_edges, 6))
    for judged in all_mode_sets(instant):
        force = np.array([mode is ControlMode.FORCE for mode in judged.modes])
        mask = int(sum(1 << i for i in range(len(force)) if not force[i]))
        mine = separate(P, modes.unit_columns(env, tips, mask, P), np.zeros(6))[0] == FAILS
        verdict = judged.internal_force
        if verdict.marginal or 1e-10 < verdict.residual < 1e-8 or 1e-9 < verdict.margin < 1e-8:
            continue
        assert mine == verdict.excessive
        if judged.stability is not None:
            f = np.zeros(len(force))
            _, z, _ = margin(program, mask, 0.0, f)
            assert agreement.z_error(z, max(judged.stability.z, 0.0), 1.0) <= agreement.AGREE
            assert (f[force] <= f_max[force]).all()
            assert (f >= 0.0).all()


@pytest.mark.parametrize("seed", range(2000, 2060))
def test_a_threshold_changes_no_answer_above_it(seed: int, instances: ModuleType) -> None:
    """Asked with ``below``, z is the same where it reaches it; else a valid upper bound comes."""
    rng = np.random.default_rng(seed)
    instant = instances.random_instance(rng, int(rng.integers(1, 4)))
    program, y = instant_program(instant), np.zeros(6)
    f, g = np.zeros(len(program.f_max)), np.zeros(len(program.f_max))
    end, z, _, mask = modes.decide(touching(program), 0.0, -1, -1, NO_RECORD, f, y)
    for below in (1e-3, 0.1, 0.999 * abs(z) if np.isfinite(z) else 0.5, 1.001 * abs(z) + 1e-3, 3.0):
        if not np.isfinite(below):
            continue
        how, bound, _, other = modes.decide(touching(program), below, -1, -1, NO_RECORD, g, y)
        if end == modes.STABLE and z >= below:
            assert (how, other) == (end, mask)
            assert bound == pytest.approx(z, rel=1e-8)
        elif how == modes.UNDER:
            assert bound < below
            assert bound >= max(z, 0.0) - 1e-9
        else:
            # (5) failed for every set, which needs no bound.
            assert how == end == modes.INTERNAL_FORCE


def test_directions_are_the_papers() -> None:
    """The kernel numbers the 76 directions as the reference does."""
    np.testing.assert_allclose(DIRECTIONS, PAPERS_DIRECTIONS, rtol=1e-15)


def test_previous_modes_win_ties_among_equals() -> None:
    """On a symmetric layout the previous segment's modes are kept, else position comes first."""
    instant = pressed_block()
    alone = decide_instant(instant)
    assert sorted(mode.value for mode in alone.modes) == ["force", "position"]
    assert alone.modes[0] is ControlMode.POSITION
    swapped = alone.modes[::-1]
    again = decide_instant(instant, swapped)
    assert again.modes == swapped
    assert again.z == pytest.approx(alone.z, rel=1e-9)
    assert decide_modes(instant, swapped).modes == swapped


@pytest.mark.parametrize("change", ["no fingers", "no contacts", "no limits", "doubled", "smooth"])
def test_degenerate_instants(change: str, agreement: ModuleType) -> None:
    """No fingers, no contacts, f_max = 0, contacts given twice, no friction: as the reference."""
    whole = pressed_block()
    c = whole.contacts
    changed = {
        "no fingers": with_fingers(whole, 0),
        "no contacts": dataclasses.replace(
            whole, contacts=ContactState(NOBODY, NOBODY, NOBODY, c.rotation)
        ),
        "no limits": dataclasses.replace(whole, max_normal_force=np.zeros(2)),
        "doubled": dataclasses.replace(
            whole,
            contacts=ContactState(
                np.repeat(c.points, 2, axis=0), np.repeat(c.normals, 2, axis=0),
                np.repeat(c.slip, 2, axis=0), c.rotation,
            ),
        ),
        "smooth": dataclasses.replace(whole, friction=np.zeros(2), environment_friction=0.0),
    }[change]  # fmt: skip
    found = agreement.compare(changed)
    assert found.holds, found.note
    if change == "doubled":
        assert decide_instant(changed).z == pytest.approx(decide_instant(whole).z, rel=1e-9)


def test_replaced_contacts_and_friction_take_effect() -> None:
    """Coefficients that were left out follow what is replaced, whatever the number of contacts."""
    whole = pressed_block()
    rough, smooth = (
        dataclasses.replace(whole, environment_friction=mu).friction_at_contacts
        for mu in (0.75, 0.0)
    )
    assert rough.tolist() == [0.75] * 4
    assert smooth.tolist() == [0.0] * 4
    none = ContactState(NOBODY, NOBODY, NOBODY, whole.contacts.rotation)
    assert len(dataclasses.replace(whole, contacts=none).friction_at_contacts) == 0
    with pytest.raises(ShapeError, match="contact_friction"):
        dataclasses.replace(whole, contact_friction=np.ones(3))


def test_contacts_of_a_scene_are_replaced_whole() -> None:
    """Surfaces that were left out follow other points; given ones, normals and slip must fit."""
    contacts = pressed_block().contacts
    two: dict[str, Any] = {"points": contacts.points[:2], "normals": contacts.normals[:2]}
    fewer = dataclasses.replace(contacts, **two, slip=contacts.slip[:2])
    assert fewer.surfaces.tolist() == [0, 0]
    with pytest.raises(ShapeError, match="slip"):
        dataclasses.replace(contacts, **two)
    given = dataclasses.replace(contacts, surfaces=np.array([0, 1, 1, 2]))
    with pytest.raises(ShapeError, match="surfaces"):
        dataclasses.replace(given, **two, slip=contacts.slip[:2])


@pytest.mark.parametrize("fingers", [0, 2])
def test_nothing_pulls_and_nothing_can_press(fingers: int) -> None:
    """g = 0 and f_max = 0 (or no fingers): in equilibrium with no margin, and no division by 0."""
    still = dataclasses.replace(
        with_fingers(pressed_block(), fingers), gravity=0.0, max_normal_force=np.zeros(fingers)
    )
    mine = decide_instant(still)
    assert mine.outcome is decide_modes(still).outcome is Outcome.STABLE
    assert mine.z == 0.0
    assert force_unit(still) == still.force_scale == 1.0


def pressed_block() -> Instant:
    """A cube on the floor between two opposed fingers."""
    floor = np.array([[x, y, -1.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    return Instant(
        contacts=ContactState(floor, up, np.zeros((4, 3)), np.eye(3)),
        points=np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]),
        normals=np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        friction=np.full(2, 0.7),
        max_normal_force=np.full(2, 10.0),
        environment_friction=0.5,
        mass=1.0,
        inertia=np.eye(3) * 2.0 / 3.0,
        gravity=9.8,
    )


def with_fingers(instant: Instant, count: int) -> Instant:
    """Return the instant with the first fingers only."""
    return dataclasses.replace(
        instant,
        points=instant.points[:count],
        normals=instant.normals[:count],
        friction=instant.friction[:count],
        max_normal_force=instant.max_normal_force[:count],
    )
