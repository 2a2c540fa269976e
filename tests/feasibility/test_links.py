"""Ramps between commands: what the kernel says of them, and what it learns."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from gm_ompl.arrays import BoolArray
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.feasibility.links import Link, Side, failing
from gm_ompl.mechanics.alternatives import Alternatives
from gm_ompl.reference.equilibrium import in_equilibrium
from gm_ompl.reference.statics import statics

P, F = ControlMode.POSITION, ControlMode.FORCE


def drawn(instances: ModuleType, seed: int) -> tuple[Instant, Link, BoolArray]:
    """Return a random instant, a link of one end there, and who is commanded by it."""
    rng = np.random.default_rng([seed, 17])
    instant: Instant = instances.random_instance(rng, 1 + seed % 3)
    force = rng.random(len(instant.points)) < 0.6
    force[0] = True
    modes = tuple(F if commanded else P for commanded in force)
    places = 1 + np.arange(force.sum())
    side = Side(Alternatives.of(instant), lambda: instant)
    link = Link(0, modes, (places,), False, lambda: [side])
    return instant, link, force


def test_kernel_and_solver_agree_whether_a_ramp_holds(instances: ModuleType) -> None:
    """Against HiGHS alone, on 100 random instants with random commands."""
    answers = []
    for seed in range(100):
        instant, link, force = drawn(instances, seed)
        f = np.random.default_rng(seed).uniform(size=force.sum()) * instant.max_normal_force[force]
        model = statics(instant)
        limits = model.f_max.copy()
        limits[force] = f / model.scale
        answers.append(link.holds(f))
        assert answers[-1] == in_equilibrium(model, limits, force), seed
        assert failing([link], f) == ([] if answers[-1] else [link])
    assert 20 <= sum(answers) <= 80


def test_a_cut_spares_all_commands_that_hold(instances: ModuleType) -> None:
    """What is learnt where a ramp fails excludes that command, and none that can be balanced."""
    cuts = spared = 0
    for seed in range(60):
        instant, link, force = drawn(instances, seed)
        rng, most = np.random.default_rng(seed), instant.max_normal_force[force]
        tried = rng.uniform(size=(8, force.sum())) * most
        held = [f for f in tried if link.holds(f)]
        scale = float(most.max()) or 1.0
        for c, slopes, _ in link.cuts:
            assert min(c + slopes @ f for f in tried) <= 1e-9 * scale
            assert all(c + slopes @ f >= -1e-7 * scale for f in held)
            cuts, spared = cuts + 1, spared + len(held)
    assert cuts >= 50 and spared >= 20


def test_no_force_stands_at_place_zero(instances: ModuleType) -> None:
    """A finger that is not down yet has the command 0, whatever the plan commands."""
    for seed in range(20):
        _, link, force = drawn(instances, seed)
        nothing = Link(0, link.modes, (np.zeros(force.sum(), dtype=np.int64),), False, link.look)
        assert nothing.holds(np.array([7.0])) == link.holds(np.zeros(force.sum()))


def test_equal_commands_are_no_ramp(instances: ModuleType) -> None:
    """Where neither modes nor forces change nothing is looked at; else both ends are."""
    for seed in range(20):
        _, link, force = drawn(instances, seed)
        n, rng = int(force.sum()), np.random.default_rng(seed)
        ends = 1 + np.arange(n), 1 + n + np.arange(n)
        f = rng.uniform(size=(2, n))
        both = Link(0, link.modes, ends, True, link.look)
        assert both.holds(np.concatenate([f[0], f[0]])) and "sides" not in vars(both)
        assert both.holds(f.ravel()) == all(link.holds(end) for end in f)
