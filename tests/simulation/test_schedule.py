"""Time laid over plans: continuity, pace, contacts, clearance."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose
from gm_ompl.planfile.arcs import arc_of
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.simulation.balance import balance
from gm_ompl.simulation.schedule import schedule
from gm_ompl.simulation.segments import commanded, runs
from gm_ompl.simulation.timeline import PHASES, Pace, Timeline, progress, ramp
from gm_ompl.simulation.transit import Clearance

DT = 0.005


def problem_of(plan: Plan) -> Problem:
    return Scenario.from_resolved(plan.scenario).problem


@pytest.fixture(scope="module")
def line(regrasp_plan: Plan) -> Timeline:
    return schedule(regrasp_plan, problem_of(regrasp_plan), Pace(), DT)


@pytest.mark.parametrize("length", [0.001, 0.05, 3.0])
def test_a_way_is_travelled_smoothly_to_its_very_end(length: float) -> None:
    """``progress`` never goes back, never exceeds its speed, starts and stops at rest."""
    way = progress(length, 0.5, 0.3, 0.001)
    steps = np.diff(np.concatenate([[0.0], way]))
    assert way[-1] == length
    assert steps.min() >= -1e-12
    assert steps.max() <= 0.5 * 0.001 * (1 + 1e-6)
    assert max(steps[0], steps[-1]) <= 0.02 * steps.max()


def test_a_ramp_ends_at_one() -> None:
    """``ramp`` rises from above 0 to exactly 1."""
    assert ramp(7)[-1] == 1.0
    assert (np.diff(ramp(7)) > 0).all()


def test_nothing_jumps(line: Timeline) -> None:
    """Fingertips, forces and limits change by what their speeds allow, regrasp included."""
    size = 12.247
    assert np.linalg.norm(np.diff(line.centre, axis=0), axis=2).max() <= 0.7 * size * DT
    assert np.abs(np.diff(line.position, axis=0)).max() <= 0.31 * size * DT
    loaded = line.f_com * line.force_share
    assert (
        np.abs(np.diff(loaded, axis=0)).max() <= 10.0 * np.pi / 0.3 * DT
    )  # a product of two ramps
    assert np.abs(np.diff(line.force_share, axis=0)).max() <= np.pi / 2 / 0.3 * DT * 1.1


def test_a_switch_is_the_ramp_that_was_judged(line: Timeline) -> None:
    """One command, before or after, counts all through a switch; after a touch it starts at 0."""
    taken = given = touched = 0
    switching = np.flatnonzero(line.phase == PHASES.index("switch"))
    for block in np.split(switching, np.flatnonzero(np.diff(switching) > 1) + 1):
        before, end = block[0] - 1, block[-1]
        for i in range(line.fingers):
            shares, f_com = line.force_share[[before, end], i], line.f_com[block, i]
            if shares.tolist() == [1.0, 0.0]:
                given += 1
                assert (f_com == line.f_com[before, i]).all()
            elif shares.tolist() == [0.0, 1.0] and line.limit[before, i] < line.limit[end, i]:
                touched += 1
                assert f_com[0] < 0.1 * f_com[-1] and (np.diff(f_com) > 0.0).all()
            elif shares.tolist() == [0.0, 1.0]:
                taken += 1
                assert (f_com == line.f_com[end, i]).all()
    assert touched >= 1 and given >= 1, (taken, given, touched)


def test_the_timeline_passes_through_the_plan(line: Timeline, regrasp_plan: Plan) -> None:
    """It begins at the plan's first pose, ends at its last, and fingers touch where planned."""
    first, last = regrasp_plan.steps[0], regrasp_plan.steps[-1]
    assert first.kind == "displacement" and last.kind == "displacement"
    assert np.allclose(line.position[0], first.pose_from.position)
    assert np.allclose(line.position[-1], last.pose_to.position)
    pose = Pose(line.rotation[-1], line.position[-1])
    radius = problem_of(regrasp_plan).fingers.radius
    touch = line.centre[-1] + radius[:, None] * line.normal[-1]
    assert np.allclose(pose.to_object(touch), [place.point for place in last.placements])


def test_commands_are_the_plans(line: Timeline, regrasp_plan: Plan) -> None:
    """While the object moves, modes are the segment's, forces within those of its neighbours."""
    for k in np.flatnonzero(line.phase == PHASES.index("move"))[::7]:
        step = regrasp_plan.steps[int(line.step[k])]
        assert step.kind == "displacement"
        segment = step.segments[int(line.segment[k])]
        assert line.z[k] == segment.z
        assert [share == 1.0 for share in line.force_share[k]] == [
            mode == "force" for mode in segment.modes
        ]


def test_a_lifted_finger_stays_clear(line: Timeline, regrasp_plan: Plan) -> None:
    """In transit a finger keeps its distance from object, floor, walls and other finger."""
    problem = problem_of(regrasp_plan)
    transit = np.flatnonzero(line.phase == PHASES.index("transit"))
    assert len(transit)
    i = int(np.flatnonzero(~line.down[transit[0]])[0])
    pose = Pose(line.rotation[transit[0]], line.position[transit[0]])
    other = line.centre[transit[0], [1 - i]]
    clear = Clearance(problem, pose, i, other, problem.fingers.radius[[1 - i]], 0.0)
    assert clear.free(line.centre[transit, i]).all()
    assert not line.notes


def test_runs_break_only_where_modes_or_fingers_change(regrasp_plan: Plan) -> None:
    """A run's segments follow each other, and cover the plan's way exactly once."""
    problem = problem_of(regrasp_plan)
    parts = [run for run in runs(regrasp_plan, problem) if isinstance(run, list)]
    segments = [segment for run in parts for segment in run]
    for before, after in itertools.pairwise(segments):
        assert np.allclose(before.part.end.position, after.part.start.position)
        assert np.allclose(before.part.end.rotation, after.part.start.rotation)
    steps = [step for step in regrasp_plan.steps if step.kind == "displacement"]
    for pose, record in ((segments[0].part.start, steps[0].pose_from),
                         (segments[-1].part.end, steps[-1].pose_to)):  # fmt: skip
        assert np.allclose(pose.position, record.position)
        assert np.allclose(pose.quaternion(), record.quaternion)
    assert sum(map(len, parts)) == sum(len(step.segments) for step in steps)
    for run, following in itertools.pairwise(parts):
        assert len({segment.record.modes for segment in run}) == 1
        last, first = run[-1], following[0]
        assert (last.record.modes, last.placements) != (first.record.modes, first.placements)


def test_leaning_forces_balance_the_object(cork_plan: Plan) -> None:
    """The forces to lean with obey friction, and carry with the floor's what the object weighs.

    The floor's share is not returned; by symmetry of the tumble its force must point up and lie
    within its own friction cone.
    """
    problem = problem_of(cork_plan)
    step = cork_plan.steps[15]
    assert step.kind == "displacement"
    segment = step.segments[1]
    found = balance(
        problem, arc_of(step, problem).moment(0.5), step.placements,
        *commanded(segment),
    )  # fmt: skip
    assert found.holds
    normals = np.array([place.normal for place in step.placements])
    along = (found.forces * normals).sum(axis=1)
    sideways = np.linalg.norm(found.forces - along[:, None] * normals, axis=1)
    assert (sideways <= 0.15 * along * (1 + 1e-9)).all()
    assert (found.least <= along + 1e-9).all() and (along <= found.most + 1e-9).all()
    pose = arc_of(step, problem).pose(0.5)
    floor = -pose.rotation @ found.forces.sum(axis=0) + [0.0, 0.0, problem.mass * 9.8]
    assert floor[2] > 0
    assert np.linalg.norm(floor[:2]) <= 1.2 * floor[2]


def test_a_plan_without_motion_cannot_be_executed(cork_plan: Plan) -> None:
    """Bad input is said to be so."""
    empty = cork_plan.model_copy(update={"steps": ()})
    with pytest.raises(InputError, match="moves nothing"):
        schedule(empty, problem_of(cork_plan), Pace(), DT)
    with pytest.raises(InputError, match="speed"):
        Pace(speed=0.0)
