from collections.abc import Callable
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import linprog

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.reference.internal_force import (
    InternalForce,
    certify,
    excessive_internal_force,
    unit_wrenches,
)  # fmt: skip
from gm_ompl.reference.modes import all_mode_sets
from gm_ompl.reference.statics import statics


def wrenches_by_hand(instant: Instant, position: list[int]) -> Array:
    """Unit edge wrenches assembled contact by contact, moments scaled by an eigen root of R."""
    c = instant.contacts
    pairs: list[tuple[Array, Array]] = []
    for p, n, slip in zip(c.points, c.normals, c.slip, strict=True):
        mu = instant.environment_friction
        if slip.any():
            pairs.append((p, n - mu * slip))
        else:
            world = (c.rotation[0], c.rotation[1])
            pairs += [(p, e) for e in edges_by_hand(n, mu, instant.cone_edges, *world)]
    for i in position:
        n, mu = instant.normals[i], float(instant.friction[i])
        own = (np.eye(3)[0], np.eye(3)[1])
        pairs += [(instant.points[i], e) for e in edges_by_hand(n, mu, instant.cone_edges, *own)]
    inverse = np.linalg.inv(instant.inertia)
    columns = []
    for p, e in pairs:
        moment = np.cross(p, e)
        norm = np.sqrt(e @ e + instant.mass * moment @ inverse @ moment)
        columns.append(np.concatenate([e, moment]) / norm)
    return np.array(columns).reshape(-1, 6).T


def edges_by_hand(n: Array, mu: float, s: int, x: Array, y: Array) -> list[Array]:
    axis = x if abs(float(n @ x)) < 0.9 else y
    t1 = np.cross(np.cross(n, axis), n)
    t1 = t1 / np.linalg.norm(t1)
    angles = [2 * np.pi * k / s for k in range(s)]
    return [n + mu * (np.cos(a) * t1 + np.sin(a) * np.cross(n, t1)) for a in angles]


def prove(instant: Instant, position: list[int], verdict: InternalForce) -> None:
    """Check a certificate against wrenches that the reference did not assemble."""
    W = wrenches_by_hand(instant, position)
    assert W.shape == verdict.wrenches.shape
    if verdict.excessive:
        assert (verdict.ray >= 0).all()
        assert verdict.ray.sum() == pytest.approx(1.0)
        sum_ = W @ verdict.ray
        moment = sum_[3:] @ np.linalg.inv(instant.inertia) @ sum_[3:]
        assert np.sqrt(sum_[:3] @ sum_[:3] + instant.mass * moment) < 2e-9
    elif W.shape[1]:
        # y acts on R^(1/2) Q; in the object's units that is the functional R^(1/2)^T y.
        functional = statics(instant).R_sqrt.T @ verdict.wrench
        assert (functional @ W).min() > 0.9 * verdict.margin > 0.0


def test_every_verdict_proves_itself(instances: ModuleType) -> None:
    """On 320 random instants, every mode set's ray cancels or wrench separates; none is marginal.

    Fewer than 0.1% of the verdicts may be marginal.
    """
    verdicts = []
    for seed in range(320):
        instant = instances.random_instance(np.random.default_rng(seed))
        model = statics(instant)
        for bits in range(2**model.fingers):
            position = [i for i in range(model.fingers) if bits >> i & 1]
            verdict = excessive_internal_force(model, position)
            if not verdict.marginal:
                prove(instant, position, verdict)
            verdicts.append(verdict)
    assert sum(v.marginal for v in verdicts) <= 0.001 * len(verdicts)
    assert 0.05 < sum(v.excessive for v in verdicts) / len(verdicts) < 0.95


def test_verdicts_agree_with_scipy(instances: ModuleType) -> None:
    """The unbounded program of Sec. 3.2 itself is unbounded for scipy just where we say so."""
    seen = set()
    for seed in range(400, 500):
        model = statics(instances.random_instance(np.random.default_rng(seed)))
        verdict = excessive_internal_force(model, range(model.fingers))
        A = verdict.wrenches
        if A.shape[1] == 0:
            continue
        answer = linprog(-np.ones(A.shape[1]), A_eq=A, b_eq=np.zeros(6), bounds=(0, None))
        assert (answer.status != 0 or answer.fun < -1e-6) == verdict.excessive
        seen.add(verdict.excessive)
    assert seen == {True, False}


def test_more_position_control_never_removes_internal_force(instances: ModuleType) -> None:
    """If some position-controlled fingers can build up internal force, so can every superset."""
    for seed in range(60):
        instant = instances.random_instance(np.random.default_rng(seed), fingers=3)
        model = statics(instant)
        bad = {
            bits
            for bits in range(8)
            if excessive_internal_force(model, [i for i in range(3) if bits >> i & 1]).excessive
        }
        assert {more for bits in bad for more in range(8) if more & bits == bits} == bad


def test_two_fingers_facing_each_other_can_squeeze(box: Callable[..., Instant]) -> None:
    """Opposed fingers: both under position control fail, either one alone passes."""
    instant = box([[0, -5, 0], [0, 5, 0]], [[0, 1, 0], [0, -1, 0]])
    model = statics(instant)
    assert excessive_internal_force(model, [0, 1]).excessive
    assert not excessive_internal_force(model, [0]).excessive
    assert not excessive_internal_force(model, [1]).excessive


def test_pressing_down_on_a_static_floor_squeezes_and_on_sliding_contacts_too(
    box: Callable[..., Instant],
) -> None:
    """A position-controlled finger on top squeezes the object against the floor, still or not."""
    for slip in ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]):
        model = statics(box([[0, 0, 2.5]], [[0, 0, -1]], slip=slip))
        assert excessive_internal_force(model, [0]).excessive
        assert not excessive_internal_force(model, []).excessive


def test_a_finger_beyond_the_friction_angle_cannot_squeeze(box: Callable[..., Instant]) -> None:
    """Opposed normals turned apart by more than both friction angles leave no common line."""
    for mu, squeezes in ((0.30, True), (0.25, False)):
        # A wedge of half angle atan(0.28): the line between the contacts leaves a cone at 0.28.
        n = np.array([0.28, 1.0, 0.0]) / np.hypot(0.28, 1.0)
        instant = box(
            [[0, -5, 0], [0, 5, 0]], [n, n * [1, -1, 1]], mu_finger=mu, mu_env=0.0, edges=4
        )
        assert excessive_internal_force(statics(instant), [0, 1]).excessive is squeezes


def test_a_wedge_fails_every_mode_set(box: Callable[..., Instant]) -> None:
    """Environment contacts that squeeze the object by themselves fail all modes."""
    instant = box([[0, -5, 0]], [[0, 1, 0]])
    c = instant.contacts
    jammed = type(c)(
        np.array([[2.5, 0, 0], [-2.5, 0, 0]]), np.array([[-1.0, 0, 0], [1.0, 0, 0]]),
        np.zeros((2, 3)), np.eye(3),
    )  # fmt: skip
    sets = all_mode_sets(
        Instant(
            jammed, instant.points, instant.normals, instant.friction, instant.max_normal_force,
            0.5, instant.mass, instant.inertia, instant.gravity,
        )
    )  # fmt: skip
    assert len(sets) == 2
    assert all(s.internal_force.excessive and s.stability is None for s in sets)


def test_nothing_that_presses_is_no_internal_force(box: Callable[..., Instant]) -> None:
    """Without contacts and without position-controlled fingers (5) is trivially bounded."""
    instant = box([[0, -5, 0]], [[0, 1, 0]])
    none = np.zeros((0, 3))
    free = Instant(
        type(instant.contacts)(none, none, none, np.eye(3)), instant.points, instant.normals,
        instant.friction, instant.max_normal_force, 0.5, 1.0, instant.inertia, 9.8,
    )  # fmt: skip
    verdict = excessive_internal_force(statics(free), [])
    assert not verdict.excessive
    assert verdict.margin == np.inf
    assert next(s.modes for s in all_mode_sets(free)) == (ControlMode.POSITION,)


def test_borderline_counts_as_internal_force() -> None:
    """A residual under 1e-9 counts; between two inconclusive certificates the verdict is yes."""
    A = np.zeros((6, 2))
    A[0] = [1.0, -1.0]
    A[1] = 5e-10
    assert certify(A, np.array([0.5, 0.5]), np.eye(6)[1]).excessive
    A[1] = 1e-8
    apart = certify(A, np.array([0.5, 0.5]), np.eye(6)[1])
    assert not apart.excessive
    assert apart.margin == pytest.approx(1e-8)
    unsure = certify(A, np.array([0.5, 0.5]), np.eye(6)[0])
    assert unsure.excessive
    assert unsure.marginal


def test_nearly_opposed_contacts_are_told_apart_at_the_stated_residual(
    box: Callable[..., Instant],
) -> None:
    """Two frictionless contacts, opposed but for an angle e, leave e / 2 at k = (1/2, 1/2).

    Up to 1e-9 that counts as internal force; beyond, a wrench separates, and only within the
    sqrt 6 between the sum norm of the program and norm (7) may the verdict be marginal.
    """
    held = box()
    for e in np.geomspace(1e-13, 1e-3, 41):
        contacts = type(held.contacts)(
            np.array([[-1.0, 0, 0], [1.0, 0, 0]]),
            np.array([[1.0, 0, 0], [-np.cos(e), np.sin(e), 0]]),
            np.zeros((2, 3)),
            np.eye(3),
        )
        instant = replace(held, contacts=contacts, environment_friction=0.0)
        verdict = excessive_internal_force(statics(instant), [])
        first, *_, last = verdict.wrenches.T  # without friction a cone's edges coincide
        residual = np.linalg.norm(first + last) / 2
        if residual <= 0.9e-9:
            assert verdict.excessive, e
        elif residual > 3e-9:
            assert not verdict.excessive, e
            assert verdict.margin > 1e-9
        assert not verdict.marginal or 0.9e-9 < residual < 3e-9


def test_false_certificates_are_refused(instances: ModuleType) -> None:
    """A ray that does not cancel and a wrench that does not separate prove nothing."""
    model = statics(instances.random_instance(np.random.default_rng(0), fingers=2))
    A = unit_wrenches(model, [])
    k = np.zeros(A.shape[1])
    k[0] = 1.0
    verdict = certify(A, k, -A[:, 0])
    assert verdict.marginal
    assert verdict.residual == pytest.approx(1.0)
