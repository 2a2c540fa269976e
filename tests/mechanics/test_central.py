"""What is commanded where z = 0 leaves f_com free."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.feasibility.steady_force import Undecided, least_change
from gm_ompl.mechanics.alternatives import Alternatives
from gm_ompl.mechanics.central import FLAT, largest_cube
from gm_ompl.mechanics.certificate import separates_environment
from gm_ompl.mechanics.instant import decide_instant, instant_program
from gm_ompl.reference import equilibrium
from gm_ompl.reference.modes import decide_modes, margin
from gm_ompl.reference.statics import force_unit, statics
from tests.instances import random_instance, softened
from tests.mechanics.equilibrium_alone import balanced

NONE = np.zeros((0, 3))
LIMIT = np.array([20.0])


def in_the_air(points: Array, normals: Array, f_max: float, mu: float = 0.5) -> Instant:
    """A cube of mass 1 and side 2 that fingertips alone hold."""
    n = len(points)
    return Instant(
        contacts=ContactState(NONE, NONE, NONE, np.eye(3)), points=points, normals=normals,
        friction=np.full(n, mu), max_normal_force=np.full(n, f_max), environment_friction=0.0,
        mass=1.0, inertia=np.eye(3) * 2.0 / 3.0, gravity=9.8, cone_edges=4,
    )  # fmt: skip


def pinched(f_max: float) -> Instant:
    """Two fingertips at the middles of opposite sides: f_1 = f_2 in every equilibrium."""
    side = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    return in_the_air(side, -side, f_max)


def cube_of(instant: Instant, force: BoolArray) -> tuple[float, Array]:
    """Return the kernel's largest cube, forces over M g."""
    program = instant_program(instant)
    centre = np.empty(len(program.f_max))
    return largest_cube(program, separates_environment(program.env), force, centre), centre


@pytest.mark.parametrize("decide", [decide_instant, decide_modes])
def test_a_pinch_by_hand(decide: Callable[[Instant], ModeDecision]) -> None:
    """Points that pinch lift with z = 0: one is commanded the middle of what carries 9.8 N.

    With mu = 0.5 two fingers of 20 N carry it with 9.8 to 20 N each.
    """
    found = decide(pinched(20.0))
    assert found.outcome is Outcome.STABLE
    assert found.z == 0.0
    assert found.modes == (ControlMode.POSITION, ControlMode.FORCE)
    assert found.f_com[1] == pytest.approx((9.8 + 20.0) / 2.0, rel=1e-9)
    assert decide(pinched(9.7)).outcome is Outcome.NO_EQUILIBRIUM


def test_commands_that_equilibrium_ties_together() -> None:
    """Both under force control: the first is in the middle of its range, the other equal to it."""
    found = {d.modes: d for d in Alternatives.of(pinched(20.0)).modes(0.0)}
    both = found[ControlMode.FORCE, ControlMode.FORCE]
    assert both.z == 0.0
    assert both.f_com == pytest.approx((14.9, 14.9), rel=1e-9)
    model = statics(pinched(20.0))
    commands = equilibrium.central_command(model, np.ones(2, dtype=bool))
    assert commands is not None
    assert commands * model.scale == pytest.approx([14.9, 14.9], rel=1e-7)
    assert margin(pinched(20.0), both.modes, both.f_com) == 0.0
    at = Alternatives.of(pinched(20.0)).at(both.modes, np.array([14.0, 15.0]))
    assert at is not None
    assert at[0] == -np.inf
    assert at[1] + at[2] @ np.array([14.0, 15.0]) < 0.0
    same = Alternatives.of(pinched(20.0)).at(both.modes, np.array([14.0, 14.0]))
    assert same is not None
    assert same[0] == 0.0


def unforced(seed: int) -> Instant:
    """A random instant whose margin is 0, with some force control to choose."""
    rng = np.random.default_rng(seed)
    instant = random_instance(rng, int(rng.integers(1, 5)))
    return softened(rng, instant) if seed % 3 == 0 else instant


def test_the_cube_is_the_references() -> None:
    """Cutting planes and one program for all corners: cubes of the same size, for any fingers.

    At the kernel's centre and corners the reference finds equilibrium.
    """
    sizes = 0
    for seed in range(60):
        instant = unforced(seed)
        rng, model = np.random.default_rng(seed), statics(instant)
        force = rng.random(model.fingers) < 0.7
        if not force.any() or not (model.f_max > 0.0).all():
            continue
        half, centre = cube_of(instant, force)
        theirs, _ = equilibrium.largest_cube(model, force)
        size = max(1.0, float(model.f_max.max()))
        assert max(half, 0.0) == pytest.approx(max(theirs, 0.0), abs=1e-7 * size), seed
        if half > FLAT * size:
            sizes += 1
            for sign in (-1.0, 0.0, 1.0):
                corner = np.where(force, centre + sign * half * (1.0 - 1e-9), model.f_max)
                assert equilibrium.in_equilibrium(model, corner, force), seed
    assert sizes > 10


def test_commands_at_no_margin_keep_equilibrium() -> None:
    """Kernel and reference, for any modes: the reference finds equilibrium at what is commanded."""
    seen = 0
    for seed in range(100, 400):
        rng = np.random.default_rng(seed)
        instant = random_instance(rng, int(rng.integers(1, 3)))
        if decide_instant(instant).z != 0.0:
            continue
        for found in Alternatives.of(instant).modes(0.0):
            force = np.array([mode is ControlMode.FORCE for mode in found.modes])
            if not force.any():
                continue
            seen += 1
            assert margin(instant, found.modes, found.f_com) == 0.0, (seed, found)
            model = statics(instant)
            theirs = equilibrium.central_command(model, force)
            assert theirs is not None
            assert equilibrium.in_equilibrium(model, theirs, force), (seed, found)
    assert seen > 20


def test_no_command_is_wanted_where_nothing_presses() -> None:
    """A finger that may not press is commanded nothing, and the cube has no size."""
    instant = dataclasses.replace(pinched(20.0), max_normal_force=np.zeros(2), gravity=0.0)
    assert force_unit(instant) == 1.0
    half, _ = cube_of(dataclasses.replace(instant, mass=1.0), np.ones(2, dtype=bool))
    assert half == 0.0


def test_feasible_is_what_a_plain_program_balances() -> None:
    """50 random instants, points and soft: z_min = 0 holds where a balance is found by scipy."""
    told = dict.fromkeys((True, False), 0)
    for seed in range(1000, 1050):
        instant = unforced(seed)
        decision, plain = decide_instant(instant), balanced(instant)
        if plain is None or decision.outcome is Outcome.INTERNAL_FORCE:
            continue
        told[plain] += 1
        assert (decision.outcome is Outcome.STABLE) == plain, seed
    assert min(told.values()) > 10


def test_steady_control_leaves_commands_at_no_margin() -> None:
    """What is free gives way: a pinch of points keeps 14.9 N, the soft one before it takes that."""
    soft = dataclasses.replace(pinched(20.0), soft=np.full(2, 0.1))
    one, other = decide_instant(soft), decide_instant(pinched(20.0))
    assert one.z > 0.0
    commands = [
        Undecided(Alternatives.of(instant), found, (0, 1), 0.5 * found.z, 0.6 * found.z, LIMIT)
        for instant, found in ((soft, one), (pinched(20.0), other))
    ]
    (before, after), _ = least_change(commands)
    assert after == other
    assert after.f_com[1] == pytest.approx(14.9, rel=1e-9)
    assert one.f_com[1] != pytest.approx(14.9, rel=1e-3)
    assert before.f_com[1] == pytest.approx(14.9, rel=1e-6)
