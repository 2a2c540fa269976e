from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.offers import rules, stand
from gm_ompl.contact.touching import Toucher
from gm_ompl.feasibility.arc_states import ArcStates
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.keys import contact_key
from gm_ompl.feasibility.reference_backend import ReferenceBackend
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.problem import Problem
from gm_ompl.sampling.contacts import touching
from gm_ompl.scenario.load import load
from tests.lattices import leaving

TASKS = ["bookshelf", "corner-pivot", "ledge", "peg-thin-fingers", "pick-card", "step-over"]
SHIPPED = [f"tasks/{name}" for name in TASKS] + ["free/l-bracket", "free/out-of-the-corner"]
RANDOM = [f"random/{kind}/{k}" for kind in ("free", "free-clutter") for k in range(6)]
EACH = 40
"""Poses of a scenario."""


def arcs(problem: Problem) -> Iterator[tuple[int, GraphArc]]:
    """The arcs that leave the first poses of a scenario's lattice, with their tails."""
    return leaving(problem.object_graph, EACH)


@pytest.fixture(scope="module", params=[*SHIPPED, *RANDOM])
def problem(request: pytest.FixtureRequest) -> Problem:
    return load(request.param).problem


def agree(problem: Problem) -> int:
    """How many contact states compiled code finds, all as the plain functions do."""
    body, environment, count = problem.body, problem.environment, 0
    fast = ArcStates(problem)
    for _, arc in arcs(problem):
        keys = fast.along(arc.arc, arc.parts)
        if keys is None:
            continue
        for k, (key, moment) in enumerate(zip(keys, arc.middles(), strict=True)):
            plain, found = contacts_at(moment, body, environment), fast.state(k)
            assert key == contact_key(plain, body.diagonal)
            for name in ("points", "normals", "slip", "rotation"):
                np.testing.assert_allclose(
                    getattr(found, name), getattr(plain, name), rtol=0, atol=1e-12
                )
            assert np.array_equal(found.surfaces, plain.surfaces)
            count += 1
    return count


def test_contact_states_are_those_of_the_plain_functions(problem: Problem) -> None:
    """Along the arcs of shipped and random lattices: the same keys, points, normals and slips."""
    assert agree(problem) > 0


def test_surfaces_are_told_apart_alike() -> None:
    """Where contacts tell which surface they are on."""
    plain = load("tasks/corner-pivot").problem
    assert agree(replace(plain, environment=replace(plain.environment, by_surface=True))) > 0


def test_patches_with_points_inside_are_left_to_the_plain_functions() -> None:
    plain = load("tasks/corner-pivot").problem
    fast = ArcStates(replace(plain, environment=replace(plain.environment, patch_points=2)))
    assert all(fast.along(arc.arc, arc.parts) is None for _, arc in arcs(plain))


def test_contact_lines_are_those_of_the_plain_functions(problem: Problem) -> None:
    """The same lines in the same order, among them those of poses where several pieces touch."""
    motion, body = problem.motion, problem.body
    assert isinstance(motion, FreeMotion)
    small = problem.environment.contact_tolerance * body.diagonal
    offered = rules(motion.steps, motion.start.position, body.diagonal, small)
    toucher, graph = Toucher(body, problem.environment), problem.object_graph
    for tail in dict.fromkeys(tail for tail, _ in arcs(problem)):
        pose = graph.pose(tail)
        corners = toucher.corners(pose.rotation, pose.position, with_obstacles=True)
        lines = stand(pose.position, *corners, offered).lines
        plain = touching(body, problem.environment, pose, motion.steps.rotate).lines
        wanted = np.array(plain).reshape(-1, 2, 3)
        np.testing.assert_allclose(lines, wanted, rtol=0, atol=1e-12)


def test_the_judge_numbers_states_alike(problem: Problem) -> None:
    """Whichever way it is asked, and whichever back end it has."""
    judge, plain = Judge(problem, KernelBackend(problem)), Judge(problem, ReferenceBackend(problem))
    for _, arc in itertools.islice(arcs(problem), EACH):
        numbers = judge.environments(arc)
        assert numbers == tuple(map(judge.environment, arc.middles()))
        assert numbers == plain.environments(arc)
