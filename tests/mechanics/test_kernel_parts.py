"""The kernel's parts by themselves, each against another solver."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import linprog, nnls

from gm_ompl.mechanics import modes
from gm_ompl.mechanics.alternatives import margin
from gm_ompl.mechanics.blocks import joint_margin
from gm_ompl.mechanics.certificate import separates_environment, upper_bound
from gm_ompl.mechanics.instant import instant_program
from gm_ompl.mechanics.internal_force import FAILS, PASSES, separate
from gm_ompl.mechanics.master import best_command
from gm_ompl.mechanics.stability import REACHED, position_margin
from gm_ompl.mechanics.tableau import FEASIBLE
from gm_ompl.mechanics.tau import new_tableau


@pytest.mark.parametrize("seed", range(60))
def test_separation(seed: int) -> None:
    """Wolfe's algorithm separates where non-negative least squares finds a distance."""
    rng = np.random.default_rng(seed)
    K = int(rng.integers(1, 40))
    P = rng.normal(size=(K, 6)) + rng.choice([0.0, 0.5, 2.0]) * np.eye(6)[seed % 6]
    if seed % 3 == 0:
        P[:, seed % 6] = np.abs(P[:, seed % 6])  # the origin is outside
    if seed % 4 == 0:
        P = np.concatenate([P, P[: K // 2]])  # the same points twice
    P /= np.linalg.norm(P, axis=1, keepdims=True)
    # min |P^T k| over sum k = 1, the sum by a heavy row.
    heavy = 1e4
    k, _ = nnls(np.vstack([P.T, np.full(len(P), heavy)]), np.append(np.zeros(6), heavy))
    expected = np.linalg.norm(P.T @ (k / k.sum()))
    x = np.zeros(6)
    end, margin = separate(np.ascontiguousarray(P), len(P), x)
    assert end == (PASSES if expected > 1e-6 else FAILS)
    if end == PASSES:
        assert np.linalg.norm(x) <= 1.0 + 1e-12
        assert (P @ x).min() == pytest.approx(margin, abs=1e-14)
        assert margin <= expected + 1e-7


@pytest.mark.parametrize("seed", range(60))
def test_best_command(seed: int) -> None:
    """The small program over f_com: z and a maximiser as linprog finds them."""
    rng = np.random.default_rng(seed)
    n, K = int(rng.integers(1, 4)), int(rng.integers(1, 15))
    h, c = rng.uniform(0.1, 2.0, K), rng.normal(1.0, 1.0, K)
    s, limits = rng.normal(size=(K, n)), rng.uniform(0.0, 3.0, n)
    if seed % 5 == 0:
        s[:, 0] = 0.0
    found = linprog(
        np.append(-1.0, np.zeros(n)), np.column_stack([h, -s]), c,
        bounds=[(None, None), *((0.0, limit) for limit in limits)],
    )  # fmt: skip
    f = np.empty(n)
    which, weights = np.empty(1 + n, dtype=np.int64), np.empty(1 + n)
    z = best_command(h, c, s, limits, f, which, weights)
    used = which >= 0
    total, on = weights[used] @ c[which[used]], weights[used] @ s[which[used]]
    assert weights[used] @ h[which[used]] == pytest.approx(1.0)
    assert total + np.maximum(on, 0.0) @ limits == pytest.approx(z, abs=1e-9)
    assert z == pytest.approx(-found.fun, abs=1e-9)
    assert (f >= 0.0).all()
    assert (f <= limits).all()
    assert ((c + s @ f) / h).min() == pytest.approx(z, abs=1e-8)


@pytest.mark.parametrize("seed", range(30))
def test_joint_program(seed: int, instances: ModuleType) -> None:
    """All directions that cuts need, in one program: the z that cutting planes find, or more.

    With all that limit z among them it is the same; a few directions alone can only allow more.
    """
    rng = np.random.default_rng(seed)
    program = instant_program(instances.random_instance(rng, 2))
    force = np.array([True, seed % 2 == 0])
    mask = sum(1 << i for i in range(2) if not force[i])
    end, z, direction = margin(program, mask, 0.0, np.zeros(2))
    if end != modes.STABLE or z < 1e-6:
        return
    chosen, count = np.zeros(24, dtype=np.int64), 1
    chosen[0] = direction
    before = np.inf
    for i in rng.permutation(76)[:10]:
        g, Y = np.zeros(2), np.zeros((24, 6))
        solved, joint = joint_margin(program, force, chosen[:count], FEASIBLE, g, Y)
        assert solved
        bound = upper_bound(program, force, Y[:count])
        assert z * (1.0 - 1e-7) <= bound <= joint * (1.0 + 1e-7) + 1e-9
        # joint = 0 stands for "tau is nothing": the chosen directions do not limit z.
        if joint > 0.0:
            assert z * (1.0 - 1e-7) <= joint <= before * (1.0 + 1e-7)
            before = joint
        if i not in chosen[:count]:
            chosen[count] = i
            count += 1


@pytest.mark.parametrize("seed", range(40))
def test_a_short_look_bounds_z(seed: int, instances: ModuleType) -> None:
    """A pass without patience: never below z, and never BELOW where z reaches the threshold."""
    rng = np.random.default_rng(seed)
    program, y = instant_program(instances.random_instance(rng, 2)), np.zeros(6)
    separation = separates_environment(program.env)
    room = new_tableau(len(program.tips), len(program.env), program.tips.shape[1])
    end, z, _ = position_margin(program, separation, 0.0, True, room, y)
    if end != REACHED or z <= 0.0:
        return
    for below in (0.5 * z, 0.999 * z, 1.001 * z, 2.0 * z):
        how, bound, _ = position_margin(program, separation, below, False, room, y)
        assert bound >= z * (1.0 - 1e-9)
        if below < z:
            assert how == REACHED
