"""Many screws at once, compiled: all is as it is of one, from the plain functions."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gm_ompl import limits
from gm_ompl.contact.lattice import ContactLattice
from gm_ompl.errors import LimitError
from gm_ompl.feasibility import course_states
from gm_ompl.feasibility.arc_states import ArcStates
from gm_ompl.feasibility.case_decider import CaseDecider
from gm_ompl.feasibility.course_states import CourseStates
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.state_store import StateStore
from gm_ompl.mechanics import columns
from gm_ompl.motion.courses import Courses
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.lattices import leaving

SCENARIOS: list[tuple[str, tuple[str, ...]]] = [
    *[(f"tasks/{name}", ()) for name in ("corner-pivot", "ledge", "pick-card-soft", "step-over")],
    ("tasks/bookshelf", ("cost.samples_per_arc=3", "cost.samples_at=ends")),
    ("free/l-bracket", ()),  # a mesh, of several pieces
    ("free/out-of-the-corner", ()),
    ("tasks/ledge", ("fingers.radius=[0.05, 0.07]",)),  # two fingertips of two radii
    *[(f"random/{kind}/{k}", ()) for kind in ("free", "free-clutter") for k in range(4)],
]
POSES = 25
"""Whose arcs are asked about."""


@pytest.fixture(scope="module", params=SCENARIOS, ids=lambda each: " ".join([each[0], *each[1]]))
def problem(request: pytest.FixtureRequest) -> Problem:
    return load(*request.param).problem


def arcs(problem: Problem) -> tuple[list[GraphArc], Courses]:
    """The arcs that leave the first poses of a scenario's lattice."""
    graph = problem.object_graph
    assert isinstance(graph, ContactLattice)
    for _ in leaving(graph, POSES):
        pass
    which = range(len(graph.arcs))
    return [graph.arc(k) for k in which], graph.courses(np.array(which))


def test_what_is_free_along_screws(problem: Problem) -> None:
    """What swept tests say of one, and single poses of the node that it leads to."""
    judge, (steps, screws) = Judge(problem, KernelBackend(problem)), arcs(problem)
    object_free, free = judge.passing_along(screws)
    for k, step in enumerate(steps):
        plain = judge.passing(step, problem.object_graph.pose(step.head))
        assert object_free[k] == plain.object_free
        assert np.array_equal(free[k], np.array(plain.free))


def test_contact_states_along_screws(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    """The keys of one screw after the other, however little room there is at first."""
    monkeypatch.setattr(course_states, "USUAL", 1)
    one, (steps, screws) = ArcStates(problem), arcs(problem)
    found = CourseStates(problem).along(screws)
    keys = iter(found.keys())
    for count, step in zip(found.counts.tolist(), steps, strict=True):
        plain = one.along(step.arc, step.parts)
        assert [next(keys) for _ in range(count)] == (plain or [])
    assert next(keys, None) is None


def test_states_get_their_numbers_and_columns(problem: Problem) -> None:
    """One after the other or at once: equal numbers, contacts, columns and loads in every bit."""
    one, many, (steps, screws) = KernelBackend(problem), KernelBackend(problem), arcs(problem)
    numbers = many.along(screws)
    for row, step in zip(numbers.tolist(), steps, strict=True):
        assert (one.environments(step.arc, step.parts) or []) == [k for k in row if k >= 0]
    U, weight = columns.wrench_norm(problem.mass, problem.inertia), problem.mass
    weight *= problem.mechanics.gravity / problem.force_scale
    friction, s = problem.environment.friction, problem.mechanics.cone_edges
    for k in range(int(numbers.max()) + 1):
        plain, state = one.contacts(k), many.contacts(k)
        for name in ("points", "normals", "slip", "rotation", "surfaces"):
            assert np.array_equal(getattr(state, name), getattr(plain, name))
        env, load_ = many.columns(k)[:2]
        wanted = columns.environment_columns(plain, friction, s, U)
        np.testing.assert_allclose(env, wanted, rtol=0, atol=1e-15)
        np.testing.assert_allclose(load_, columns.load(plain.rotation, weight, U), atol=1e-15)
    assert np.array_equal(many.along(screws), numbers)


def test_cases_are_told_of_new_states() -> None:
    """Where something is not known exactly, decisions are as of states told one by one."""
    changes = ("uncertainty.finger_friction=10%",)
    problem = load("tasks/ledge", changes).problem
    one, many, (steps, screws) = KernelBackend(problem), KernelBackend(problem), arcs(problem)
    numbers = many.along(screws)
    for step in steps:
        one.environments(step.arc, step.parts)
    placements = (0,) * problem.fingers.count
    fingers = tuple(range(problem.fingers.count))
    for k in range(0, int(numbers.max()) + 1, 10):
        assert many.decide(k, fingers, placements).z == one.decide(k, fingers, placements).z


def test_what_compiled_code_does_not_tell_is_left_out() -> None:
    """Points inside patches are the plain functions' alone."""
    plain = load("tasks/corner-pivot").problem
    inside = replace(plain, environment=replace(plain.environment, patch_points=2))
    _, screws = arcs(plain)
    assert (KernelBackend(inside).along(screws) == -1).all()


def test_limits_are_heeded() -> None:
    problem = load("tasks/ledge").problem
    judge, backend = Judge(problem, KernelBackend(problem)), KernelBackend(problem)
    _, screws = arcs(problem)
    with limits.holding(seconds=0.0):
        with pytest.raises(LimitError):
            judge.passing_along(screws)
        with pytest.raises(LimitError):
            backend.along(screws)


BREAKS = [
    *[(StateStore, name) for name in ("add", "add_some", "_new_columns", "_make_room")],
    (CaseDecider, "register"),
]
"""Where Ctrl-C comes."""


@pytest.mark.parametrize(("owner", "name"), BREAKS, ids=lambda each: str(each))
@pytest.mark.parametrize("before", [True, False])
@pytest.mark.parametrize("at_once", [True, False])
def test_ctrl_c_mixes_up_no_states(
    owner: type, name: str, before: bool, at_once: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wherever it comes while states are kept, those asked for later are their own."""
    problem = load("tasks/ledge", ("uncertainty.finger_friction=10%",)).problem
    whole, broken, (steps, screws) = KernelBackend(problem), KernelBackend(problem), arcs(problem)
    kept, breaks = getattr(owner, name), iter([False, True])

    def breaking(*given: Any) -> Any:
        stop = next(breaks, False)
        if stop and before:
            raise KeyboardInterrupt
        done = kept(*given)
        if stop:
            raise KeyboardInterrupt
        return done

    monkeypatch.setattr(owner, name, breaking)
    halves = [screws.some(slice(0, 5)), screws.some(slice(5, None))]
    with contextlib.suppress(KeyboardInterrupt):
        for part in halves if at_once else ():
            broken.along(part)
        for step in () if at_once else steps:
            broken.environments(step.arc, step.parts)
    monkeypatch.undo()
    fingers, placements = (0, 1), (0, 30)
    pairs = zip(whole.along(screws).ravel(), broken.along(screws).ravel(), strict=True)
    for one, other in [pair for pair in pairs if pair[0] >= 0][::5]:
        plain, state = whole.contacts(int(one)), broken.contacts(int(other))
        assert np.array_equal(state.points, plain.points)
        assert np.array_equal(state.slip, plain.slip)
        assert np.array_equal(broken.columns(int(other))[0], whole.columns(int(one))[0])
        z = [b.decide(int(k), fingers, placements).z for b, k in ((whole, one), (broken, other))]
        assert z[0] == z[1]
