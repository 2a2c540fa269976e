"""Other modes and other f_com at an instant, against the reference's linear programs."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.environment import contact_state, environment_contacts
from gm_ompl.contact.state import Instant
from gm_ompl.mechanics.alternatives import Alternatives
from gm_ompl.mechanics.instant import decide_instant
from gm_ompl.reference.modes import all_mode_sets, margin
from gm_ompl.scenario.load import load

SEEDS = range(12)


def stable_instant(instances: ModuleType, seed: int) -> tuple[Instant, ModeDecision]:
    """Return the seed's first random instant with a margin."""
    rng = np.random.default_rng(seed)
    while True:
        instant: Instant = instances.random_instance(rng, 1 + seed % 3)
        decision = decide_instant(instant)
        if decision.outcome is Outcome.STABLE and decision.z > 1e-3 * instant.force_scale:
            return instant, decision


@pytest.mark.parametrize("seed", SEEDS)
def test_modes_are_those_of_the_reference(instances: ModuleType, seed: int) -> None:
    """Every combination that passes (5) with a large enough z is found, and no other."""
    instant, decision = stable_instant(instances, seed)
    # Half of the best takes in combinations far from a tie as well.
    least = 0.5 * decision.z
    mine = {other.modes: other.z for other in Alternatives.of(instant).modes(least)}
    scale = instant.force_scale
    theirs = {
        judged.modes: judged.stability.z * scale
        for judged in all_mode_sets(instant)
        if judged.stability is not None
    }
    slack = 1e-6 * decision.z
    for modes, z in theirs.items():
        if z >= least + slack:
            assert mine[modes] == pytest.approx(z, rel=1e-6)
    for modes, z in mine.items():
        assert theirs[modes] >= least - slack, (modes, z)


@pytest.mark.parametrize("seed", SEEDS)
def test_margin_at_a_command_and_its_bound(instances: ModuleType, seed: int) -> None:
    """z at a given f_com equals the reference's; the cut is sharp there and bounds z elsewhere."""
    instant, _ = stable_instant(instances, seed)
    rng = np.random.default_rng([seed, 1])
    n, alternatives = len(instant.points), Alternatives.of(instant)
    modes = tuple(
        ControlMode.FORCE if i == 0 or rng.random() < 0.5 else ControlMode.POSITION
        for i in range(n)
    )
    limits = np.array([
        limit
        for limit, mode in zip(instant.max_normal_force, modes, strict=True)
        if mode is ControlMode.FORCE
    ])  # fmt: skip
    trials = [rng.random(len(limits)) * limits for _ in range(3)]
    floor = 1e-3 * instant.force_scale
    for f in trials:
        answer = alternatives.at(modes, f)
        assert answer is not None
        z, c, slopes = answer
        expected = max(margin(instant, modes, _commands(modes, f)), 0.0)
        assert max(z, 0.0) == pytest.approx(expected, rel=1e-6, abs=1e-6 * floor)
        if np.isfinite(z):
            assert c + slopes @ f == pytest.approx(z, rel=1e-9)
        for other in trials:
            there = alternatives.at(modes, other)
            assert there is not None
            assert there[0] <= c + slopes @ other + 1e-7 * max(floor, abs(c))


def _commands(modes: tuple[ControlMode, ...], f: np.ndarray) -> tuple[float | None, ...]:
    left = iter(f.tolist())
    return tuple(next(left) if mode is ControlMode.FORCE else None for mode in modes)


def test_small_pivots_do_not_spoil_the_margin() -> None:
    """Where a pivot of 1e-6 multiplies rounding, z at a given f_com is still the reference's.

    Met in a plan for planar/corridor: z came out 1.5e-4 too large.
    """
    start, end = (5.695402, -0.136627, 0.0269382), (6.627317, -0.112372, 0.0260284)
    problem = load("planar/corridor").problem
    direction = tuple(b - a for a, b in zip(start, end, strict=True))
    modes = (ControlMode.POSITION, ControlMode.FORCE)
    table = problem.fingers.placements
    places = tuple(
        int(np.argmin(np.linalg.norm(table.points - point, axis=1)))
        for point in ((-2.4, 1.0, 0.0), (-2.4, -1.0, 0.0))
    )
    for share in np.linspace(0.0, 1.0, 41):
        q = tuple(a + share * d for a, d in zip(start, direction, strict=True))
        pose, twist = problem.motion.pose(q), problem.motion.velocity(q, direction)
        touching = environment_contacts(problem.body, problem.environment, pose)
        contacts = contact_state(touching, pose, twist, problem.body)
        instant = problem.instant(contacts, (0, 1), places)
        f_com = decide_instant(instant).f_com[1]
        assert f_com is not None
        found = Alternatives.of(instant).at(modes, np.array([f_com * (1.0 - 3e-7)]))
        assert found is not None
        assert found[0] == pytest.approx(
            margin(instant, modes, (None, f_com * (1.0 - 3e-7))), rel=1e-8
        )
