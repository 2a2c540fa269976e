"""Screws of any length, and routes of free motion made of them."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

from gm_ompl.contact.environment import environment_contacts
from gm_ompl.contact.poses import SAME
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.holds.watch import never
from gm_ompl.motion.free import PoseGoal, angle_between
from gm_ompl.motion.screw import Screw, Slide, Tumble
from gm_ompl.problem import Problem
from gm_ompl.sampling.free_routes import FreeRouteMaker
from gm_ompl.sampling.lane_store import SetDraw
from gm_ompl.sampling.pose_tree import nearest_in
from gm_ompl.sampling.route import Route
from gm_ompl.sampling.screws import Leap, Screws
from gm_ompl.scenario.load import load


def problem(name: str, *changes: str) -> Problem:
    """A shipped scenario's problem."""
    return load(name, list(changes)).problem


def leaps(screws: Screws, *, position: Any, rotation: Any = None) -> list[Leap]:
    """The leaps from the start towards a pose."""
    turned = screws.motion.start.rotation if rotation is None else rotation
    return screws.towards(screws.start, Pose(turned, np.array(position, dtype=np.float64)))


def test_a_slide_goes_to_the_very_place_or_to_the_first_contact() -> None:
    """On the floor the object gets where it is wanted; a step in its way it touches exactly."""
    screws = Screws(problem("free/stairs"))
    near, far = (leaps(screws, position=[x, 0.0, 1.0]) for x in (0.37, 4.0))
    assert any(np.abs(leap.end.position - [0.37, 0, 1]).max() < 1e-12 for leap in near)
    ends = [leap.end.position for leap in far if isinstance(leap.piece, Slide)]
    assert any(np.abs(end - [1, 0, 1]).max() < 1e-9 for end in ends)
    assert not any(end[0] > 1 + 1e-9 and end[2] < 1.5 for end in ends)


def test_a_turn_ends_on_the_next_face() -> None:
    """A cube tumbles by 90 deg to either side; a contact closes there."""
    found = leaps(Screws(problem("tasks/reorient")), position=[1, 0, 0.5])
    turned = [leap for leap in found if isinstance(leap.piece, Tumble)]
    assert {round(float(leap.end.position[0]), 9) for leap in turned} == {1.0, -1.0}
    given = problem("tasks/reorient")
    for leap in turned:
        contacts = environment_contacts(given.body, given.environment, leap.end)
        assert len(contacts.points) == 4


def test_barred_axes_are_not_used() -> None:
    """Slides stay along listed axes, turns about listed directions."""
    screws = Screws(problem("tasks/reorient"))
    away = rotation_about([1.0, 2.0, 3.0], 1.0)
    for leap in leaps(screws, position=[0.4, 0.3, 0.9], rotation=away):
        if isinstance(leap.piece, Slide):
            assert np.abs(leap.piece.by[1:]).max() == 0.0
        else:
            assert abs(leap.piece.axis[1]) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("steps", "parts"), [(3.0, [3, 3, 3]), (2.3, [3, 3, 1]), (1.0, [3]), (0.6, [2])]
)
def test_strides_are_steps_and_the_rest(steps: float, parts: list[int]) -> None:
    """A leap is cut into whole steps and a shorter one, judged as densely as the lattice's."""
    screws, end = Screws(problem("tasks/reorient")), [0.25 * steps, 0.0, 0.5]
    found = [leap for leap in leaps(screws, position=end) if isinstance(leap.piece, Slide)]
    assert [leap.steps for leap in found] == pytest.approx([steps] * len(found))
    strides = screws.strides(found[0])
    assert [stride.arc.parts for stride in strides] == parts
    for a, b in itertools.pairwise(strides):
        assert a.arc.head == b.tail
    assert np.abs(screws.pose(strides[-1].arc.head).position - end).max() < 1e-12


def random_pose(rng: np.random.Generator) -> Pose:
    """Any pose."""
    axis = rng.normal(size=3)
    return Pose(rotation_about(axis, rng.uniform(0, math.pi)), rng.uniform(-1, 1, size=3))


@pytest.mark.parametrize("kind", ["pose", "up", "any"])
def test_the_nearest_pose_in_a_goal(kind: str) -> None:
    """It is in the goal; no other that is drawn there is nearer, in place or in angle."""
    rng = np.random.default_rng(0)
    for _ in range(30):
        low = rng.uniform(-1, 1, size=3)
        high = low + rng.uniform(0, 1, size=3)
        turned = random_pose(rng).rotation if kind == "pose" else None
        up = random_pose(rng).rotation[0] if kind == "up" else None
        goal, here = PoseGoal(low, high, turned, up, 1e-9, 1e-7), random_pose(rng)
        nearest = nearest_in(goal, here)
        assert goal.contains(nearest)
        angle = angle_between(nearest.rotation, here.rotation)
        assert angle == pytest.approx(goal.rotation_error(here), abs=1e-7)
        far = np.linalg.norm(nearest.position - here.position)
        assert far == pytest.approx(goal.position_error(here), abs=1e-12)


def test_a_goal_that_hangs_upside_down() -> None:
    """What points down exactly is turned up by half a turn."""
    goal = PoseGoal(np.zeros(3), np.zeros(3), None, np.array([0.0, 0.0, -1.0]), 1e-9, 1e-7)
    assert goal.contains(nearest_in(goal, Pose(np.eye(3), np.zeros(3))))


def made(name: str, seed: int) -> tuple[FreeRouteMaker, Route]:
    """A route of a scenario, and its maker."""
    given, rng = problem(name), np.random.default_rng(seed)
    judge = Judge(given, make_backend(given))
    maker = FreeRouteMaker(judge, SetDraw(given, judge, 2.0, 0.1), rng)
    for _ in range(5):
        route = maker.make(never)
        if route is not None:
            return maker, route
    raise AssertionError("no route in five attempts")


@pytest.mark.parametrize("name", ["tasks/flip-cube", "free/stairs", "free/out-of-the-corner"])
def test_routes_lead_to_the_goal(name: str) -> None:
    """So do their variants: each arc begins where the last one ended, the object free all along."""
    maker, route = made(name, 0)
    routes = [route, *(maker.variant(route) for _ in range(20))]
    found = [one for one in routes if one is not None]
    assert len(found) > 3
    motion, diagonal = problem(name).motion, problem(name).body.diagonal
    for one in found:
        assert one.table.object_free
        assert motion.goal.contains(one.way.poses[-1])  # type: ignore[attr-defined]
        here = motion.start  # type: ignore[attr-defined]
        for arc, pose in zip(one.way.arcs, one.way.poses[1:], strict=True):
            assert isinstance(arc.arc, Screw)
            for a, b in ((arc.arc.start, here), (arc.arc.end, pose)):
                assert np.linalg.norm(a.position - b.position) <= SAME * diagonal
                assert angle_between(a.rotation, b.rotation) <= SAME
            here = pose
