"""What the check remembers from instant to instant gives the reference's answers."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.checking import remembered
from gm_ompl.checking.recheck import Hold, Recheck
from gm_ompl.contact.decision import ControlMode
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.cases import cases
from gm_ompl.reference.internal_force import excessive_internal_force
from gm_ompl.reference.modes import all_mode_sets, decide_modes
from gm_ompl.reference.stability import stability_at
from gm_ompl.reference.statics import statics

HANDS = (
    ("paper/tumble", ((10, 60), (0, 100))),
    ("random/tumble/17", ((1, 4),)),
    ("planar/turn", ((0, 30),)),
)
INSTANTS = 8


def instants(name: str, rows: tuple[int, ...]) -> list[Any]:
    """Return instants along a motion, each a little further than the last."""
    problem = gm_ompl.load(name).problem
    rows = tuple(row % len(problem.fingers.placements) for row in rows)
    rows = rows[: problem.fingers.count]
    recheck, found = Recheck(problem), []
    low, high = np.array(problem.motion.low), np.array(problem.motion.high)
    start = np.array(problem.start)
    direction = tuple(0.2 * (high - low))
    for k in range(INSTANTS):
        q = tuple(start + (k + 0.5) / INSTANTS * np.array(direction))
        contacts = recheck.contacts(problem.motion.moment(q, direction))
        found.append(problem.instant(contacts, tuple(range(len(rows))), rows))
    return found


CASES = [(name, rows) for name, hands in HANDS for rows in hands]


@pytest.mark.parametrize(("name", "rows"), CASES)
def test_margins_and_verdicts_are_the_reference_s(name: str, rows: tuple[int, ...]) -> None:
    """Along a motion z for given modes and f_com, and Problem (5), come out as in HiGHS alone."""
    memory = remembered.Remembered()
    for instant in instants(name, rows):
        model = statics(instant)
        for force in itertools.product((False, True), repeat=model.fingers):
            position = frozenset(i for i, own in enumerate(force) if not own)
            verdict = memory.excessive(position, [model], position)
            assert verdict == excessive_internal_force(model, position).excessive
            f_com = np.where(force, 0.5 * model.f_max, 0.0)
            found = memory.bases.margins(force, model, np.array(force), f_com)
            modes = [ControlMode.FORCE if own else ControlMode.POSITION for own in force]
            want = stability_at(model, modes, f_com).z
            if found is not None:
                assert found.z == pytest.approx(want, rel=1e-7, abs=1e-9)
            else:
                assert want <= 0.0


@pytest.mark.parametrize(("name", "rows"), CASES)
def test_no_bound_is_below_what_some_f_com_reaches(name: str, rows: tuple[int, ...]) -> None:
    """The multipliers at any f_com bound the z of every other, and so that of the best."""
    memory = remembered.Remembered()
    for instant in instants(name, rows)[::3]:
        model = statics(instant)
        for judged in all_mode_sets(instant):
            if judged.stability is None or not np.isfinite(judged.stability.z):
                continue
            force = np.array([mode is ControlMode.FORCE for mode in judged.modes])
            for share in (0.2, 0.9):
                f_com = np.where(force, share * model.f_max, 0.0)
                found = memory.bases.margins((judged.modes, share), model, force, f_com)
                if found is not None:
                    least = judged.stability.z * (1.0 - 1e-7) - 1e-9
                    assert remembered.bound(cases(instant), force, [found]) >= least


def test_the_best_is_told_from_what_is_worse() -> None:
    """Along a tumble, z a hair above the best is unbeaten, and z a hair below is beaten."""
    problem = gm_ompl.load("paper/tumble").problem
    recheck, hand = Recheck(problem), ((0, 1), (10, 60))
    judged = 0
    for k in range(INSTANTS):
        contacts = recheck.contacts(problem.motion.moment((0.02 * (k + 0.5),), (1.0,)))
        best = decide_modes(problem.instant(contacts, *hand))
        if not best.z > 0.0:
            continue
        judged += 1
        for factor, unbeaten in ((1.0 + 1e-6, True), (1.0 - 1e-4, False)):
            hold = Hold(contacts, *hand, best.modes, best.f_com)
            assert recheck.unbeaten(hold, factor * best.z) is unbeaten
    assert judged > INSTANTS // 2


def test_a_tumble_takes_few_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where every segment has a contact state of its own, few programs go to the solver."""
    plan = gm_ompl.plan(gm_ompl.load("paper/tumble", ["lattice.segments=40"]))
    solved = [0]
    solve = highs.Solver.solve

    def counting(solver: highs.Solver) -> Any:
        solved[0] += 1
        return solve(solver)

    monkeypatch.setattr(highs.Solver, "solve", counting)
    assert gm_ompl.check(plan).holds
    segments = sum(len(step.segments) for step in plan.steps if step.kind == "displacement")
    assert segments == 120
    assert solved[0] < 25 * segments  # 76 directions, and one program or more for the best modes


def _gives_up(*_: object) -> None:
    raise SolverError("HiGHS ended with 'Unknown'")


def test_exact_arithmetic_answers_where_the_solver_gives_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A plan whose programs HiGHS does not solve one by one is found to hold all the same."""
    plan = gm_ompl.plan(gm_ompl.load("paper/slide", ["lattice.segments=4"]))
    monkeypatch.setattr(highs.Solver, "solve_for", _gives_up)
    assert gm_ompl.check(plan).holds


def test_what_nobody_decides_is_a_violation(monkeypatch: pytest.MonkeyPatch) -> None:
    """A margin that cannot be decided is not shown to hold; `check` says so and ends."""
    plan = gm_ompl.plan(gm_ompl.load("paper/slide", ["lattice.segments=4"]))
    monkeypatch.setattr(Recheck, "margin", _gives_up)
    report = gm_ompl.check(plan)
    assert not report.holds
    assert "cannot be decided: HiGHS" in report.violations[0].message
