"""What proves a decision does so, and where the kernel proves nothing somebody else decides."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import linprog

import gm_ompl
from gm_ompl import limits
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.errors import LimitError, SolverError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.mechanics.certificate import (
    into_polar,
    reach,
    separates_environment,
    upper_bound,
)
from gm_ompl.mechanics.instant import (
    DIRECTIONS,
    decide_instant,
    instant_program,
    prove_instant,
)
from gm_ompl.mechanics.resistance import lower_bound, new_resistance
from gm_ompl.mechanics.sides import number
from gm_ompl.mechanics.tau import fill
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.reference import proof
from gm_ompl.reference.exact import Effort, exact_margin
from gm_ompl.reference.exact_command import exact_best
from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.proof import proven_decision
from gm_ompl.reference.stability import stability
from gm_ompl.reference.statics import force_unit, statics
from tests.certified import mistake
from tests.degenerate import degenerate_instance
from tests.mechanics.agreement import compared, z_error

NEAR_TRANSLATIONS = [
    ((0.5, 0.5, 9.225786104202767e-05), (1.0, -2.7334372678820742e-05, 7.108505784664482e-05),
     [10, 7], 3.61174902988093),
    ((0.5, 0.5, -7.623664844747534e-05), (0.3, 9.599894776172456e-07, 1.755950164534426e-06),
     [16, 31], 0.7642309887638541),
]  # fmt: skip


@pytest.mark.parametrize(("q", "dq", "rows", "z"), NEAR_TRANSLATIONS)
def test_a_motion_that_is_almost_a_translation(
    q: tuple[float, ...], dq: tuple[float, ...], rows: list[int], z: float
) -> None:
    """Sliding contacts whose columns depend on each other but for 1e-8: z is the reference's."""
    verdict = gm_ompl.judge("planar/turn", q, dq, rows)
    assert verdict.decision is not None
    assert verdict.decision.z == pytest.approx(z, rel=1e-7)


def test_relatives_of_almost_a_translation() -> None:
    """A hundred more such motions, at random: kernel and reference agree."""
    problem = gm_ompl.load("planar/turn").problem
    backend, rng, stable = KernelBackend(problem), np.random.default_rng(1), 0
    judge = Judge(problem, backend)
    for _ in range(100):
        q = (float(rng.uniform(-2, 2)), float(rng.uniform(-2, 1)), float(rng.normal() * 1e-4))
        tiny = 10.0 ** rng.uniform(-9, -3, 2) * rng.choice([-1, 1], 2)
        dq = (float(rng.uniform(0.3, 1.0)), float(tiny[0]), float(tiny[1]))
        rows = tuple(rng.choice(len(problem.fingers.placements), 2, replace=False).tolist())
        environment = judge.environment(problem.motion.moment(q, dq))
        instant = problem.instant(backend.contacts(environment), (0, 1), rows)
        mine, theirs = backend.decide(environment, (0, 1), rows), decide_modes(instant)
        found = compared(mine, theirs, force_unit(instant))
        assert found.holds, found.note
        stable += theirs.outcome is Outcome.STABLE
    assert stable > 30


@pytest.mark.parametrize("seed", [*range(24), 4371, 8794])
def test_degenerate_instants(seed: int) -> None:
    """Nearly dependent columns, whatever the units: what the kernel proves the reference proves."""
    instant = degenerate_instance(np.random.default_rng(seed))
    mine = decide(instant)
    theirs = proven_decision(instant)
    assert theirs is not None
    assert mine.outcome is theirs.outcome
    if mine.outcome is Outcome.STABLE:
        assert z_error(mine.z, theirs.z, force_unit(instant)) <= 1e-6


def decide(instant: Instant) -> ModeDecision:
    """Decide with the kernel, or where it finds no proof with the reference."""
    try:
        return decide_instant(instant)
    except SolverError:
        decision = proven_decision(instant)
        assert decision is not None
        return decision


@pytest.mark.parametrize("seed", [0, 5, 8])
def test_forces_bound_z_from_below(seed: int, instances: ModuleType) -> None:
    """76 solutions prove z, spoilt ones prove less, and never more than the exact z."""
    rng = np.random.default_rng(seed)
    instant = instances.random_instance(rng, 2)
    model, nobody = statics(instant), np.zeros(2, dtype=bool)
    exact = exact_margin(model, model.f_max.tolist(), nobody, Effort()).z
    if not 1e-6 < exact < np.inf:
        return
    program = instant_program(instant)
    env, _, tips, f_max, _ = program
    raw = np.empty((8, 1 + len(env) + tips.shape[0] * tips.shape[1] + 2))
    cost = fill(program, nobody, f_max, raw)
    tau = 1.0 / exact
    N = raw.shape[1]
    found = new_resistance(N)
    found.basis[:], found.order[:], found.times[:] = np.arange(N), np.arange(76), 0.0
    for code in range(76):
        side = np.append(DIRECTIONS[number(code)], np.zeros(2))
        bounds = [(0.0, tau / cost * (1 + 1e-9)), *[(0.0, None)] * (N - 1)]
        found.x[code] = linprog(np.eye(N)[0], A_eq=raw, b_eq=side, bounds=bounds).x
    proven = lower_bound(raw, cost, DIRECTIONS, found)
    assert exact * (1 - 1e-5) <= proven <= exact * (1 + 1e-9)
    for size in (1e-3, 1e-2, 1e-1):
        spoilt = found.x * (1.0 + size * rng.uniform(-1, 1, size=found.x.shape))
        assert lower_bound(raw, cost, DIRECTIONS, found._replace(x=spoilt)) <= exact * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(30))
def test_wrenches_bound_z_from_above(seed: int, instances: ModuleType) -> None:
    """Any wrenches, moved into the polar, bound z of every choice of modes from above."""
    rng = np.random.default_rng(seed)
    instant = instances.random_instance(rng, 2)
    program = instant_program(instant)
    env, separation = program.env, separates_environment(program.env)
    if not separation.margin > 1e-3:
        return
    z = decide_modes(instant).z / force_unit(instant)
    for _ in range(50):
        Y = rng.normal(size=(3, 6))
        assert all(into_polar(env, separation, y) for y in Y)
        assert (Y @ env.T).max(initial=-1.0) <= 1e-12
        assert reach(DIRECTIONS, Y[0]) == pytest.approx((DIRECTIONS @ Y[0]).max())
        nobody = np.zeros(2, dtype=bool)
        assert upper_bound(program, nobody, Y) >= z * (1 - 1e-9)


@pytest.mark.parametrize("seed", [0, 4, 5, 8, 10])
def test_exact_arithmetic_is_a_second_opinion(seed: int, instances: ModuleType) -> None:
    """Integers find the z that HiGHS finds, with position control and with the best f_com."""
    instant = instances.random_instance(np.random.default_rng(seed), 2)
    model = statics(instant)
    for force in (np.zeros(2, dtype=bool), np.array([True, False])):
        best = exact_best(model, force, Effort())
        modes = tuple(ControlMode.FORCE if f else ControlMode.POSITION for f in force)
        z = max(stability(model, modes).z, 0.0)
        assert best.least == pytest.approx(z, rel=1e-7, abs=1e-9)


def test_creeping_cuts_are_put_into_one_program() -> None:
    """Cuts on z(f_com) that come closer by 1e-18 each: all directions met at once tell z."""
    instant = degenerate_instance(np.random.default_rng(7198))
    decision = proven_decision(instant)
    assert decision is not None and decision.z == 0.0


def test_a_second_attempt_writes_its_own_proof() -> None:
    """What the first attempt has written down proves nothing about the second."""
    instant = degenerate_instance(np.random.default_rng(23658))
    assert mistake(instant, *prove_instant(instant)) == ""


def test_what_nobody_proves_is_in_no_plan_and_no_proof(monkeypatch: pytest.MonkeyPatch) -> None:
    """Undecided arcs are refused, and "optimal" or "infeasible" are no longer claimed."""
    scenario = "random/small/8"
    whole = gm_ompl.plan(scenario)
    assert whole.optimal

    def unproven(*_: object, **__: object) -> None:
        return None

    monkeypatch.setattr(proof, "proven_decision", unproven)
    monkeypatch.setattr("gm_ompl.feasibility.kernel_backend.as_decision", unproven)
    nothing = gm_ompl.plan(scenario)
    assert nothing.status == "budget"
    assert nothing.cost is None
    assert nothing.lower_bound is not None
    assert whole.lower_bound is not None
    assert 0.0 < nothing.lower_bound <= whole.lower_bound


def test_what_the_kernel_cannot_prove_the_reference_decides(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With a kernel that never proves anything the plan is the same, and it is counted."""
    scenario = "random/small/8"
    whole = gm_ompl.plan(scenario)

    def unproven(*_: object, **__: object) -> None:
        return None

    monkeypatch.setattr("gm_ompl.feasibility.kernel_backend.as_decision", unproven)
    problem = gm_ompl.load(scenario).problem
    backend = KernelBackend(problem)
    judge = Judge(problem, backend)
    found = make_planner("astar").solve(problem, judge, Budget(), np.random.default_rng(0))
    assert found.cost == pytest.approx(whole.cost, rel=1e-6)
    assert backend.fallbacks == backend.decisions > 0
    assert backend.undecided == 0


def test_exact_arithmetic_has_an_end() -> None:
    """What is left shrinks with the integers; nothing left, or a limit in force, ends it."""
    effort = Effort()
    effort.spend(100, 10_000)
    with pytest.raises(SolverError):
        effort.spend(1_000_000, 1_000_000)
    with limits.holding(0.0), pytest.raises(LimitError):
        Effort().spend(1, 1)
