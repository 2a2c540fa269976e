from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import linprog

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.reference import highs
from gm_ompl.reference.modes import combinations
from gm_ompl.reference.program import LpStatus
from gm_ompl.reference.stability import (
    DIRECTIONS,
    K,
    Stability,
    direction_program,
    stability,
    stability_at,
    stability_of,
    stability_program,
)  # fmt: skip
from gm_ompl.reference.statics import Statics, statics

P, F = ControlMode.POSITION, ControlMode.FORCE


def close(a: float, b: float, unit: float = 1.0) -> bool:
    """Equal within 1e-6, or both no more than the solver's rounding above 0."""
    return a == b or abs(a - b) <= 1e-6 * max(abs(a), abs(b)) + 1e-7 * unit


def test_directions_circumscribe_the_unit_ball() -> None:
    """76 distinct directions of length k, in opposite pairs; their hull contains the unit ball.

    Sec. 5 states k = 2 sqrt(3 - sqrt 6) (about 1.48). The hull's facets are at distance 1: no
    unit vector's support among the directions is below 1, and some come close.
    """
    assert pytest.approx(1.4839, abs=1e-4) == K
    assert DIRECTIONS.shape == (76, 6)
    np.testing.assert_allclose(np.linalg.norm(DIRECTIONS, axis=1), K)
    assert len(np.unique(DIRECTIONS.round(9), axis=0)) == 76
    opposite = np.unique(-DIRECTIONS.round(9), axis=0)
    np.testing.assert_allclose(opposite, np.unique(DIRECTIONS.round(9), axis=0))
    rng = np.random.default_rng(0)
    u = rng.normal(size=(20000, 6))
    u[:100] = np.sqrt(1.0 + np.sqrt(6.0)) * np.eye(6)[0] + 1.0  # towards a facet's middle
    support = (u / np.linalg.norm(u, axis=1, keepdims=True) @ DIRECTIONS.T).max(axis=1)
    assert support.min() >= 1.0 - 1e-12
    assert support.min() < 1.05


def test_closed_form_for_the_axes_of_a_box_on_the_floor(box: Callable[..., Instant]) -> None:
    """A box alone on the floor, four edges per cone: each axis disturbance by hand.

    A pull along x or y slips at mu W or tips at W a / c; up, it lifts at W; down, never. A moment
    about x or y tips at W b or W a; one about z slips at mu W max(a, b): opposite corners pull
    opposite ways along the longer arm. Moments count by norm (7), so divided by the gyration
    radius.
    """
    for a, b, c, mu in ((2.5, 5.0, 2.5, 0.5), (1.0, 2.0, 6.0, 0.9), (0.3, 0.2, 0.1, 1.5)):
        model = statics(box(half=(a, b, c), mu_env=mu, edges=4))
        gyration = np.sqrt(np.array([b * b + c * c, c * c + a * a, a * a + b * b]) / 3)
        most = [
            min(mu, a / c), min(mu, a / c), min(mu, b / c), min(mu, b / c), np.inf, 1.0,
            *np.repeat([b, a, mu * max(a, b)] / gyration, 2),
        ]  # fmt: skip
        solver = highs.Solver(direction_program(model, np.zeros(0), np.zeros(0, dtype=bool)))
        for number, expected in enumerate(most):
            tau = solver.solve_for(DIRECTIONS[number], DIRECTIONS[number]).objective
            z = np.inf if abs(tau) < 1e-12 else 1.0 / tau
            assert K * z == pytest.approx(expected), number


def test_no_friction_is_equilibrium_without_stability(box: Callable[..., Instant]) -> None:
    """On ice the box rests, but the least pull moves it: z = 0, not -inf."""
    assert stability(statics(box(mu_env=0.0)), ()).z == 0.0


def test_sliding_box_alone_is_not_in_equilibrium(box: Callable[..., Instant]) -> None:
    """Nothing balances the friction of a box that slides unpushed: z = -inf in both statements."""
    model = statics(box(slip=[1.0, 0.0, 0.0]))
    assert stability(model, ()).z == -np.inf
    assert highs.solve(stability_program(model, ())).status is LpStatus.INFEASIBLE


def test_a_weak_pusher_cannot_keep_the_box_sliding(box: Callable[..., Instant]) -> None:
    """Pushing needs mu_env times the weight, less what the finger's friction lifts: the limit
    f_max decides between equilibrium and none at mu W / (1 + mu mu_finger), edges along z.
    """  # noqa: D205
    least = 0.5 / (1.0 + 0.5 * 0.7)
    for f_max, balanced in ((least * 0.999, False), (least * 1.001, True)):
        model = statics(
            box([[-2.5, 0, -1]], [[1, 0, 0]], slip=[1, 0, 0], f_max=9.8 * f_max, edges=4)
        )
        assert (stability(model, (P,)).z > -np.inf) is balanced
        assert (stability(model, (F,)).z > -np.inf) is balanced


def test_whole_program_equals_one_program_per_direction(instances: ModuleType) -> None:
    """On 60 random instants: (6) whole has the z of the 76 small programs.

    Where f_com is free the small programs get the whole one's f_com.
    """
    seen = 0
    for seed in range(60):
        model = statics(instances.random_instance(np.random.default_rng(seed)))
        for modes in combinations(model.fingers)[:4]:
            whole = stability_of(highs.solve(stability_program(model, modes)), model.fingers)
            assert whole.residual < 1e-8
            f_com = whole.f_com if len(whole.f_com) else np.zeros(model.fingers)
            if F in modes and not len(whole.f_com):
                continue
            pieces = stability_at(model, modes, f_com)
            if whole.z == np.inf:  # Problem (5) fails there
                assert pieces.z == np.inf
                continue
            assert close(whole.z, pieces.z), (seed, modes)
            assert pieces.residual < 1e-8
            seen += whole.z > 0
    assert seen > 25


def test_whole_program_agrees_with_scipy(instances: ModuleType) -> None:
    """The linprog of scipy, on the equations of (6) written out again, finds the same z."""
    seen = 0
    for seed in range(20):
        instant = instances.random_instance(np.random.default_rng(1000 + seed), fingers=2)
        model = statics(instant)
        for modes in ((P, F), (F, F)):
            z = scipy_z(model, modes)
            ours = stability(model, modes).z
            assert close(z, ours), (seed, modes)
            seen += ours > 0
    assert seen > 5


def scipy_z(model: Statics, modes: tuple[ControlMode, ...]) -> float:
    """Problem (6) with one variable f_com per force-controlled finger, forces per contact."""
    n, N = model.fingers, len(DIRECTIONS)
    e, s = model.C_env.shape[1], model.C_rob.shape[1] // n
    forced = [i for i in range(n) if modes[i] is F]
    width = e + n * s
    columns = 1 + len(forced) + N * width
    A_eq, b_eq, A_ub, b_ub = [], [], [], []
    for d in range(N):
        start = 1 + len(forced) + d * width
        block = np.zeros((6, columns))
        block[:, 0] = DIRECTIONS[d]
        block[:, start : start + e] = -model.R_sqrt @ (model.W_env @ model.C_env)
        block[:, start + e : start + width] = -model.R_sqrt @ (model.W_rob @ model.C_rob)
        A_eq.append(block)
        b_eq.append(model.R_sqrt @ model.Q_known)
        for i in range(n):
            row = np.zeros((1, columns))
            cone = model.C_rob[3 * i : 3 * i + 3, i * s : (i + 1) * s]
            row[0, start + e + i * s :][:s] = model.N_rob[3 * i : 3 * i + 3, i] @ cone
            if i in forced:
                row[0, 1 + forced.index(i)] = -1.0
                A_eq.append(row)
                b_eq.append(np.zeros(1))
            else:
                A_ub.append(row)
                b_ub.append(model.f_max[i : i + 1])
    bounds = [(None, None), *((0.0, float(model.f_max[i])) for i in forced)]
    bounds += [(0.0, None)] * (N * width)
    cost = np.zeros(columns)
    cost[0] = -1.0
    answer = linprog(
        cost, A_eq=np.vstack(A_eq), b_eq=np.concatenate(b_eq), bounds=bounds,
        A_ub=np.vstack(A_ub) if A_ub else None, b_ub=np.concatenate(b_ub) if b_ub else None,
        method="highs", options={"primal_feasibility_tolerance": 1e-10},
    )  # fmt: skip
    return {0: -answer.fun if answer.status == 0 else np.nan, 2: -np.inf, 3: np.inf}[answer.status]


def test_force_control_is_never_more_stable_than_position_control(instances: ModuleType) -> None:
    """A force-controlled finger's forces are among the position-controlled ones: z cannot grow."""
    for seed in range(60):
        model = statics(instances.random_instance(np.random.default_rng(seed), fingers=2))
        z = {modes: stability(model, modes).z for modes in combinations(2)}
        for one in ((P, F), (F, P)):
            assert z[P, P] >= z[one] - 1e-7
            assert z[one] >= z[F, F] - 1e-7


def test_z_at_a_commanded_force_is_at_most_the_best(instances: ModuleType) -> None:
    """No other f_com beats the one that (6) returns, and z is concave along f_com."""
    seen = 0
    for seed in range(60):
        model = statics(instances.random_instance(np.random.default_rng(seed), fingers=1))
        best = stability(model, (F,))
        if best.z <= 0:
            continue
        grid = np.linspace(0, model.f_max[0], 7)
        z = np.array([stability_at(model, (F,), np.array([f])).z for f in grid])
        assert (z <= best.z * (1 + 1e-7) + 1e-8).all()
        inside = z[np.isfinite(z)]
        assert (np.diff(inside, 2) <= 1e-6).all()
        seen += 1
    assert seen > 5


def test_the_limiting_direction_limits(instances: ModuleType) -> None:
    """Pushing 1% further in the named direction alone is impossible."""
    seen = 0
    for seed in range(120):
        model = statics(instances.random_instance(np.random.default_rng(seed), fingers=1))
        found: Stability = stability(model, (F,))
        if found.z <= 1e-6 or not np.isfinite(found.z):
            continue
        limits = np.asarray(found.f_com)
        load = 1.01 * found.z * DIRECTIONS[found.direction]
        assert not resists(model, limits, load)
        assert resists(model, limits, load / 1.02)
        seen += 1
    assert seen > 10


def resists(model: Statics, f_com: Array, disturbance: Array) -> bool:
    """Whether contact forces, normal ones as commanded, add up to ``disturbance`` less gravity."""
    A = np.hstack([model.env_wrenches, model.rob_wrenches])
    normal = np.hstack([np.zeros((model.fingers, model.C_env.shape[1])), model.normal_parts])
    answer = linprog(
        np.zeros(A.shape[1]), A_eq=np.vstack([A, normal]),
        b_eq=np.concatenate([disturbance - model.load, f_com]), bounds=(0, None),
    )  # fmt: skip
    return bool(answer.status == 0)
