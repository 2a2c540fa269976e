"""Which sets may hold the object in the air: what is refuted holds it under no load in question."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.state import ContactState
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.aloft import Aloft
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import rotation_about
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.stability import BALANCED
from gm_ompl.problem import Problem
from gm_ompl.reference.modes import decide_modes
from gm_ompl.scenario.load import load

SETS, LOADS, SECOND = 600, 6, 5
ANGLE = 0.05

HANDS = (
    ("tasks/pick-card", ()),
    ("tasks/pick-card-soft", ()),
    ("tasks/pick-card", ("mechanics.z_min=0", "fingers.max_normal_force=0.05")),
    ("tasks/pick-card", ("fingers.max_normal_force=[0.1, 0.5, 2]",
                         "friction.finger=[0.9, 0.3, 0.6]")),
    ("tasks/pick-card", ("fingers.soft=[0, 0.1, 0]",)),
    ("tasks/pick-card", ("object.inertia=[[0.01, 0, 0], [0, 0.02, 0.004], [0, 0.004, 0.015]]",
                         "object.centre_of_mass=[0.1, 0.2, 0]")),
    ("tasks/pick-card", ("gravity=0",)),
)  # fmt: skip


def _asked(problem: Problem) -> tuple[Aloft, IntArray, Array]:
    """Who answers, sets (SETS, n) and rotations (2, 3, 3)."""
    rng = np.random.default_rng(5)
    shape = SETS, problem.fingers.count
    rows = rng.integers(0, len(problem.fingers.placements), shape)
    rotations = np.array([_turn(rng, 3.0), _turn(rng, 3.0)])
    return Aloft(problem, KernelBackend(problem).tips), rows, rotations


def _turn(rng: np.random.Generator, angle: float) -> Array:
    """A rotation by an angle about any axis."""
    axis = rng.normal(size=3)
    return rotation_about(axis / np.linalg.norm(axis), angle)


def _near(rotation: Array, angle: float, rng: np.random.Generator) -> Array:
    """A rotation that gravity sees within an angle of another's; it is turned about up besides."""
    share = rng.choice([0.0, rng.random(), 1.0])
    heading = rotation_about([0.0, 0.0, 1.0], rng.uniform(-np.pi, np.pi))
    return np.asarray(heading @ _turn(rng, share * angle) @ rotation)


def _in_the_air(rotation: Array) -> ContactState:
    none = np.zeros((0, 3))
    return ContactState(none, none, none, rotation)


@pytest.mark.parametrize(("name", "changes"), HANDS)
def test_what_is_refuted_holds_nowhere(name: str, changes: tuple[str, ...]) -> None:
    """Under loads in the cone, at its rim too, neither kernel nor reference finds z_min."""
    problem, rng = load(name, changes).problem, np.random.default_rng(6)
    aloft, rows, rotations = _asked(problem)
    may, z_min = aloft.may_hold(rows, rotations, ANGLE), problem.mechanics.z_min
    assert not may.all()
    backend, everyone = KernelBackend(problem), tuple(range(rows.shape[1]))
    for k in range(LOADS):
        contacts = _in_the_air(_near(rotations[k % len(rotations)], ANGLE, rng))
        state = backend.environment(contacts)
        holds = backend.margins(np.full(SETS, state), rows, z_min) >= z_min
        assert not holds[~may].any()
    for placements in rows[~may][:SECOND].tolist():
        contacts = _in_the_air(_near(rotations[0], ANGLE, rng))
        decision = decide_modes(problem.instant(contacts, everyone, tuple(placements)))
        assert not decision.z >= z_min


@pytest.mark.parametrize(("name", "changes"), HANDS)
def test_z_is_within_the_bound(name: str, changes: tuple[str, ...]) -> None:
    """z at no load in the cone is above the bound there; at the cone's middle it is no use else."""
    problem, rng = load(name, changes).problem, np.random.default_rng(8)
    aloft, rows, rotations = _asked(problem)
    backend = KernelBackend(problem)
    middle = backend.environment(_in_the_air(rotations[0]))
    z = backend.margins(np.full(SETS, middle), rows, 0.0)
    load_ = backend.columns(middle)[1]
    wrenches = aloft._decide(rows, load_)
    for angle in (0.0, ANGLE, 1.0, 4.0):
        bounds = aloft._bounds(rows, wrenches, load_, angle) * problem.force_scale
        near = backend.environment(_in_the_air(_near(rotations[0], angle, rng)))
        zs = np.maximum(z, backend.margins(np.full(SETS, near), rows, 0.0))
        assert (zs <= bounds + BALANCED * problem.force_scale).all()


@pytest.mark.parametrize(("name", "changes"), HANDS)
def test_no_forces_and_no_load_do_more_work(name: str, changes: tuple[str, ...]) -> None:
    """Any wrench gives a bound: what forces and loads do along it is no more."""
    problem, rng = load(name, changes).problem, np.random.default_rng(9)
    aloft, rows, rotations = _asked(problem)
    backend = KernelBackend(problem)
    tips, f_max = backend.tips, problem.fingers.max_normal_force / problem.force_scale
    wrenches = rng.normal(size=(SETS, 6)) * [1, 1, 1, 5, 5, 5]
    reach = (wrenches @ DIRECTIONS.T).max(axis=1)
    middle = backend.columns(backend.environment(_in_the_air(rotations[0])))[1]
    forces = np.zeros(SETS)
    for i, limit in enumerate(f_max.tolist()):
        works = [(column * wrenches).sum(axis=1) for column in tips[i, rows[:, i]].swapaxes(0, 1)]
        forces += limit * np.max([np.zeros(SETS), *works], axis=0)
    for angle in (0.0, ANGLE, 1.0):
        most = aloft._bounds(rows, wrenches, middle, angle) * reach
        for _ in range(40):
            state = backend.environment(_in_the_air(_near(rotations[0], angle, rng)))
            work = wrenches @ backend.columns(state)[1] + forces
            assert (work <= most + 1e-9).all()
        assert angle or most == pytest.approx(work)


@pytest.mark.parametrize(("name", "changes"), HANDS)
def test_wrenches_bound_others_as_their_own(name: str, changes: tuple[str, ...]) -> None:
    """Tried on all sets at once they rule out those whose least bound, one by one, is too small."""
    problem, rng = load(name, changes).problem, np.random.default_rng(10)
    aloft, rows, rotations = _asked(problem)
    backend = KernelBackend(problem)
    middle = backend.columns(backend.environment(_in_the_air(rotations[0])))[1]
    wrenches = rng.normal(size=(40, 6)) * [1, 1, 1, 5, 5, 5]
    each = [aloft._bounds(rows, np.tile(y, (SETS, 1)), middle, ANGLE) for y in wrenches]
    least, short = np.min(each, axis=0), list[IntArray]()
    aloft._least = float(np.median(least)) + 1e-9
    left = aloft._without(rows, np.arange(SETS), wrenches, (middle, ANGLE), short)
    assert left.tolist() == np.flatnonzero(least >= aloft._least).tolist()
    assert sorted(np.concatenate(short)) == np.flatnonzero(least < aloft._least).tolist()


def test_without_an_angle_it_says_what_the_kernel_says() -> None:
    """Sets that only the modes rule out, as forces could build up, are left; all others are not."""
    problem = load("tasks/pick-card").problem
    aloft, rows, rotations = _asked(problem)
    backend, z_min = KernelBackend(problem), problem.mechanics.z_min
    may = aloft.may_hold(rows, rotations[:1], 0.0)
    state = backend.environment(_in_the_air(rotations[0]))
    holds = backend.margins(np.full(SETS, state), rows, z_min) >= z_min
    assert holds.any() and not holds.all()
    assert (may >= holds).all()
    assert (may & ~holds).sum() < 0.1 * (~holds).sum()


def test_turning_the_world_and_wider_cones() -> None:
    """Headings do not matter; in wider cones, and in more of them, more may hold."""
    problem = load("tasks/pick-card").problem
    aloft, rows, rotations = _asked(problem)
    may = aloft.may_hold(rows, rotations[:1], ANGLE)
    heading = rotation_about([0.0, 0.0, 1.0], 0.7)
    assert (aloft.may_hold(rows, heading @ rotations[:1], ANGLE) == may).all()
    wider, both = (
        aloft.may_hold(rows, rotations[:1], 3.0 * ANGLE), aloft.may_hold(rows, rotations, ANGLE),
    )  # fmt: skip
    assert 0 < may.sum() < both.sum() and may.sum() < wider.sum()
    assert aloft.may_hold(rows, rotations[:1], np.pi).sum() > wider.sum()


def test_more_force_refutes_no_more() -> None:
    """A hand that may press harder may hold whatever the weaker one may."""
    problem = load("tasks/pick-card").problem
    hand = problem.fingers
    strong = dataclasses.replace(hand, max_normal_force=2.0 * hand.max_normal_force)
    aloft, rows, rotations = _asked(problem)
    stronger, _, _ = _asked(dataclasses.replace(problem, fingers=strong))
    may = aloft.may_hold(rows, rotations, 0.0)  # in cones the wrenches may be others
    assert (stronger.may_hold(rows, rotations, 0.0) >= may).all()


def test_limits_hold_over_many_sets() -> None:
    """Many sets take long: the limits are looked at on the way."""
    problem = load("tasks/pick-card").problem
    aloft, _, rotations = _asked(problem)
    rows = np.zeros((100_000, problem.fingers.count), dtype=np.int64)
    with limits.holding(0.0), pytest.raises(LimitError):
        aloft.may_hold(rows, rotations, ANGLE)
