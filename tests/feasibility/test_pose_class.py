"""PoseClasses: what moves along the floor out of reach of obstacles is judged once."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.arrays import BoolArray
from gm_ompl.contact.environment import contact_state, environment_contacts
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.keys import PoseClasses, contact_key
from gm_ompl.geometry.collision import Scene
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load

SCENARIOS = [
    *(f"random/{family}/{k}" for family in ("slide", "chain", "planar") for k in range(4)),
    "paper/slide",
    "paper/regrasp",
    "planar/corner",
    "shapes/hexagon",
]


def _states(problem: Problem, rng: np.random.Generator) -> list[tuple[float, ...]]:
    low, high = np.array(problem.motion.low), np.array(problem.motion.high)
    along = np.linspace(0.0, 1.0, 9)[:, None] * (high - low) + low
    scattered = rng.uniform(low, high, (9, len(low)))
    return [tuple(float(x) for x in q) for q in (*along, *scattered)]


def _free(problem: Problem, q: tuple[float, ...]) -> list[BoolArray]:
    """Return the free placements of every finger at ``q``, by a scene of its own."""
    environment, table = problem.environment, problem.fingers.placements
    scene = Scene(problem.body, [o.body for o in environment.obstacles], environment.floor)
    pose = problem.motion.pose(q)
    object_free = scene.object_free(pose)
    return [
        scene.free_placements(pose, table.centres(radius), radius, table.piece) & object_free
        for radius in problem.fingers.radius.tolist()
    ]


@pytest.mark.parametrize("name", SCENARIOS)
def test_what_is_shared_is_the_same(name: str) -> None:
    """Free placements and contact states from the memo are those of the pose itself."""
    problem = load(name).problem
    backend = KernelBackend(problem)
    judge = Judge(problem, backend)
    rng = np.random.default_rng(1)
    dq = tuple(float(x) for x in rng.normal(size=problem.motion.dimension))
    for q in _states(problem, rng):
        for mask, free in zip(
            judge.node(problem.motion.pose(q)).free, _free(problem, q), strict=True
        ):
            assert (mask == free).all(), q
        pose, twist = problem.motion.pose(q), problem.motion.velocity(q, dq)
        touching = environment_contacts(problem.body, problem.environment, pose)
        for way in (None, twist):
            state = contact_state(touching, pose, way, problem.body)
            number = judge.environment(problem.motion.moment(q, None if way is None else dq))
            found = backend.contacts(number)
            scale = problem.body.diagonal
            assert contact_key(found, scale) == contact_key(state, scale), q


def test_a_slide_in_the_open_is_one_pose_class() -> None:
    """Poses along the floor share theirs; a turned or lifted one has another."""
    problem = load("paper/slide").problem
    classes = PoseClasses(problem)
    every = {classes.of(problem.motion.pose((s,))) for s in np.linspace(0.0, 1.0, 20)}
    assert len(every) == 1
    assert None not in every
    pose = problem.motion.pose((0.5,))
    turned = pose.turned([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.1)
    lifted = type(pose)(pose.rotation, pose.position + np.array([0.0, 0.0, 0.1]))
    assert {classes.of(turned), classes.of(lifted)}.isdisjoint(every)


def test_an_obstacle_in_reach_of_a_fingertip_has_no_pose_class() -> None:
    """The hand counts, not the object alone: its corners end 6.2 from the centre."""
    pose = load("paper/slide").problem.motion.pose((0.0,))
    for gap, shared in ((9.0, True), (6.5, False)):
        wall = f"{{box: {{min: [-20, -9, 0], max: [{-gap}, 9, 9]}}}}"
        problem = load("paper/slide", [f"environment.obstacles={{wall: {wall}}}"]).problem
        assert (PoseClasses(problem).of(pose) is not None) == shared
