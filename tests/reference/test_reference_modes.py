from collections.abc import Callable
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.geometry.pose import rotation_about
from gm_ompl.reference.modes import all_mode_sets, choose, decide_modes, decision, margin

P, F = ControlMode.POSITION, ControlMode.FORCE


def same(a: ModeDecision, b: ModeDecision, unit: float, *, factor: float = 1.0) -> None:
    """Equal z up to ``factor`` and rounding; equal outcome unless z is on the brink of 0."""
    if a.z > -np.inf and b.z > -np.inf:
        assert a.z * factor == pytest.approx(b.z, rel=1e-6, abs=1e-7 * unit)
    else:
        assert a.outcome is b.outcome


def test_decision_is_the_best_of_all_combinations(instances: ModuleType) -> None:
    """Skipping what cannot win changes nothing: same z, modes and f_com as with all sets judged."""
    outcomes = set()
    for seed in range(55):
        count = 4 if seed % 50 == 0 else None
        instant = instances.random_instance(np.random.default_rng(seed), count)
        if len(instant.points) > 4:
            continue
        quick = decide_modes(instant)
        plain = decision(choose(all_mode_sets(instant)), instant)
        same(quick, plain, instant.force_scale)
        if quick.z > 0:
            assert quick.modes == plain.modes
        outcomes.add(quick.outcome)
    assert outcomes == {Outcome.STABLE, Outcome.INTERNAL_FORCE, Outcome.NO_EQUILIBRIUM}


def test_decision_holds_at_its_own_modes_and_forces(instances: ModuleType) -> None:
    """The margin at the returned modes and f_com is the returned z; limits are kept."""
    for seed in range(100):
        instant = instances.random_instance(np.random.default_rng(seed))
        d = decide_modes(instant)
        if d.outcome is not Outcome.STABLE:
            assert d == ModeDecision(d.outcome, -np.inf)
            continue
        assert 0.0 <= d.z < np.inf
        assert 0 <= d.direction < 76
        assert len(d.modes) == len(d.f_com) == len(instant.points)
        for mode, f, most in zip(d.modes, d.f_com, instant.max_normal_force, strict=True):
            assert (f is None) == (mode is P)
            assert f is None or 0.0 <= f <= most
        again = margin(instant, d.modes, d.f_com)
        assert again == pytest.approx(d.z, rel=1e-6, abs=1e-7 * instant.force_scale)


@pytest.mark.parametrize(("length", "force"), [(1e-3, 1.0), (1e3, 1.0), (1.0, 1e-3), (1.0, 1e4)])
def test_units_do_not_matter(instances: ModuleType, length: float, force: float) -> None:
    """In other units of length z stays, in other units of force it scales with them."""
    for seed in range(40):
        instant = instances.random_instance(np.random.default_rng(seed))
        here = decide_modes(instant)
        there = decide_modes(instances.rescaled(instant, length, force))
        same(here, there, instant.force_scale * force, factor=force)


@pytest.mark.parametrize("signs", [(1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
def test_axes_of_the_object_do_not_matter(
    instances: ModuleType, signs: tuple[float, float, float]
) -> None:
    """Half turns of the object frame map even pyramids and the directions onto themselves."""
    for seed in range(50):
        instant = instances.random_instance(np.random.default_rng(seed))
        if instant.cone_edges % 2 == 0:
            turned = instances.in_other_axes(instant, np.diag(signs).astype(float))
            same(decide_modes(instant), decide_modes(turned), instant.force_scale)


def test_turning_the_scene_about_gravity_by_the_pyramids_symmetry(instances: ModuleType) -> None:
    """A scene on a floor turned by 360 deg / s about the vertical keeps its z."""
    seen = 0
    for seed in range(60):
        instant = instances.random_instance(np.random.default_rng(seed))
        c = instant.contacts
        if not np.allclose(c.normals @ c.rotation.T, [0, 0, 1], atol=1e-12):
            continue
        turn = rotation_about([0, 0, 1], 2 * np.pi / instant.cone_edges)
        turned = Instant(
            type(c)(c.points, c.normals, c.slip, turn @ c.rotation), instant.points,
            instant.normals, instant.friction, instant.max_normal_force,
            instant.environment_friction, instant.mass, instant.inertia, instant.gravity,
            instant.cone_edges,
        )  # fmt: skip
        same(decide_modes(instant), decide_modes(turned), instant.force_scale)
        seen += 1
    assert seen > 25


def test_stronger_fingers_are_never_less_stable(instances: ModuleType) -> None:
    """Doubling every f_max cannot lower z: all forces allowed before still are."""
    for seed in range(60):
        i = instances.random_instance(np.random.default_rng(seed))
        if i.gravity == 0:
            continue
        stronger = Instant(
            i.contacts, i.points, i.normals, i.friction, 2 * i.max_normal_force,
            i.environment_friction, i.mass, i.inertia, i.gravity, i.cone_edges,
        )  # fmt: skip
        before, after = decide_modes(i).z, decide_modes(stronger).z
        assert after >= before - 1e-6 * abs(before) - 1e-7 * i.force_scale or before == -np.inf


def test_pinching_needs_one_force_controlled_finger(box: Callable[..., Instant]) -> None:
    """Two opposed fingers: one under position, one under force control (Fig. 9's pinch)."""
    d = decide_modes(box([[0, -5, 0], [0, 5, 0]], [[0, 1, 0], [0, -1, 0]]))
    assert d.modes == (P, F)
    assert d.z > 0.5


def test_sliding_under_a_pressing_finger(box: Callable[..., Instant]) -> None:
    """Fig. 7: force control on top with all its force, position control behind."""
    d = decide_modes(
        box([[0, 0, 2.5], [-2.5, 0, -1]], [[0, 0, -1], [1, 0, 0]], slip=[1, 0, 0], f_max=10.0)
    )
    assert d.modes == (F, P)
    assert d.f_com[0] == pytest.approx(10.0)
    assert d.z > 0.5


def test_pushing_with_two_weak_fingers(box: Callable[..., Instant]) -> None:
    """Fig. 8: with f_max = 5 both fingers push from behind under position control."""
    d = decide_modes(
        box([[-2.5, -4, -1], [-2.5, 4, -1]], [[1, 0, 0], [1, 0, 0]], slip=[1, 0, 0], f_max=5.0)
    )
    assert d.modes == (P, P)
    assert d.z > 0.5


def test_ties_go_to_position_control_then_to_the_previous_modes(
    box: Callable[..., Instant],
) -> None:
    """A symmetric pinch ties (P, F) with (F, P): the previous modes decide, else position first."""
    pinch = box([[0, -5, 0], [0, 5, 0]], [[0, 1, 0], [0, -1, 0]])
    assert decide_modes(pinch, prefer=(F, P)).modes == (F, P)
    assert decide_modes(pinch, prefer=(F, F)).modes == (P, F)
    sets = {s.modes: s for s in all_mode_sets(pinch)}
    best = sets[P, F].stability
    assert best is not None
    alike = [replace(sets[F, F], stability=replace(best, z=best.z * (1 + 1e-9))), sets[P, F]]
    chosen = choose(alike)
    assert chosen is not None
    assert chosen.modes == (P, F)


def test_no_contact_at_all(box: Callable[..., Instant]) -> None:
    """An object that nothing holds falls; without gravity it floats with z = 0."""
    for gravity, outcome in ((9.8, Outcome.NO_EQUILIBRIUM), (0.0, Outcome.STABLE)):
        held = box(gravity=gravity)
        none = np.zeros((0, 3))
        free = Instant(
            type(held.contacts)(none, none, none, np.eye(3)), none, none, np.zeros(0),
            np.zeros(0), 0.5, held.mass, held.inertia, gravity,
        )  # fmt: skip
        d = decide_modes(free)
        assert d.outcome is outcome
        assert d.z == (0.0 if gravity == 0 else -np.inf)
