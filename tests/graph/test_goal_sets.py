"""Which sets of placements plans of free motion can end with: what is refused ends none."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.environment import contacts_at
from gm_ompl.feasibility.aloft import Aloft
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph.goal_sets import GoalSets
from gm_ompl.graph.kept_graph import KeptGraph
from gm_ompl.motion.arc import Moment
from gm_ompl.motion.free import FreeMotion, PoseGoal
from gm_ompl.problem import Problem
from gm_ompl.reference.modes import decide_modes
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from tests.free_laws import CHANGES, square
from tests.free_scenes import box_between, free_problem, up_to_a_wall
from tests.goals_near import arrivals, arriving_at, near_things, open_air, towards, turn
from tests.kept import kept, lanes

SCENES, REFUSED, NEAR = 20, 3, 60


def _sets(judge: Judge) -> tuple[IntArray, IntArray]:
    """The sets that the start allows, and those that the goal's free placements allow, too."""
    problem, every = judge.problem, np.ones(len(judge.problem.fingers.placements), dtype=bool)
    with mock.patch.object(GoalSets, "free", return_value=(every,) * problem.fingers.count):
        all_ = KeptGraph(judge).tables.hands.rows
    return all_, KeptGraph(judge).tables.hands.rows


FIGURES = (
    ("tasks/bookshelf", 1, 3406, 3406, 0),
    ("tasks/pick-card", 1, 25175, 25175, 8017),
    ("tasks/pick-card-soft", 1, 1465, 1465, 201),
    ("tasks/corner-pivot", 1, 1052, 440, 440),  # on the block
    ("tasks/peg-thin-fingers", 37, 317750, 317750, 51589),
)


@pytest.mark.parametrize(("name", "every", "start", "free", "end"), FIGURES)
def test_of_shipped_tasks(name: str, every: int, start: int, free: int, end: int) -> None:
    """So many sets are free at the start, at the goal, too, and may hold the object there."""
    judge = _judge(load(name).problem)
    all_, both = _sets(judge)
    assert (len(all_), len(both)) == (start, free)
    may = GoalSets(judge).may_end(both[::every])
    # Wrenches that prove as much of one set differ in what they say of others.
    assert every * may.sum() == pytest.approx(end, rel=0.01 if every == 1 else 0.05)


def _judge(problem: Problem) -> Judge:
    return Judge(problem, KernelBackend(problem))


def _told(judge: Judge) -> tuple[Array, float] | None:
    """The rotations and the angle that are asked about; None: the object may touch something."""
    none = np.zeros((0, judge.problem.fingers.count), dtype=np.int64)
    with mock.patch.object(Aloft, "may_hold", return_value=np.zeros(0, dtype=bool)) as asked:
        GoalSets(judge).may_end(none)
    return asked.call_args.args[1:] if asked.called else None


@pytest.mark.parametrize("seed", range(SCENES))
def test_the_last_look_is_in_the_air_and_in_the_cone(seed: int) -> None:
    """Where arcs of the plain lattice arrive nothing is touched, and gravity is as it was told."""
    problem, arriving = arriving_at(seed)
    assert arriving
    told = _told(_judge(problem))
    if told is None:
        return
    rotations, angle = told
    for arc in arriving:
        moment = arc.middles()[-1]
        assert not len(contacts_at(moment, problem.body, problem.environment).points)
        off = rotations[:, 2] @ moment.pose.rotation[2]
        assert np.arccos(np.clip(off, -1.0, 1.0)).min() <= angle + 1e-7


def test_scenes_are_of_both_kinds() -> None:
    """The object touches nothing at some goals, and may at others; all kinds of axes are there."""
    told = [_told(_judge(arriving_at(seed)[0])) is not None for seed in range(SCENES)]
    assert 0.3 * SCENES < sum(told) < SCENES


@pytest.mark.parametrize("seed", range(SCENES))
def test_no_arc_of_the_plain_lattice_ends_with_a_refused_set(seed: int) -> None:
    """The reference finds that a refused set falls short, or is not free, wherever arcs arrive."""
    problem, arriving = arriving_at(seed)
    judge, rng, everyone = _judge(problem), np.random.default_rng(seed), (0, 1, 2)
    goal_sets, hand, z_min = GoalSets(judge), problem.fingers, problem.mechanics.z_min
    rows = rng.integers(0, len(hand.placements), (50, 3))
    refused = rows[~goal_sets.may_end(rows)][:REFUSED]
    free = goal_sets.free()
    for arc in arriving[:: max(1, len(arriving) // 3)]:
        moment, end = arc.middles()[-1], arc.arc.end
        contacts = contacts_at(moment, problem.body, problem.environment)
        for row in refused.tolist():
            instant = problem.instant(contacts, everyone, tuple(row))
            assert not decide_modes(instant).z >= z_min
        masks = judge.node(end).free
        assert all((may >= is_).all() for may, is_ in zip(free, masks, strict=True))


@pytest.mark.parametrize("seed", range(SCENES))
def test_what_is_free_anywhere_in_the_goal_may_end(seed: int) -> None:
    """A fingertip free at a pose of the goal is never refused, however wide the goal is."""
    rng, problem = np.random.default_rng(200 + seed), open_air(seed)
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    low = rng.uniform([-1.0, -0.5, 0.3], [1.0, 0.5, 1.0])
    size = rng.choice([0.0, 0.02, 2.0]) * rng.random(3)
    distance, angle = rng.choice([0.0, 0.01, 0.3]), rng.choice([0.0, 0.02, 1.0, np.pi])
    goal = PoseGoal(low, low + size, turn(rng, rng.random() * np.pi), None, distance, angle)
    judge = _judge(towards(problem, goal))
    may = GoalSets(judge).free()
    assert goal.rotation is not None
    for _ in range(30):
        way = rng.normal(size=3)
        way *= distance * rng.choice([rng.random(), 1.0 - 1e-9]) / np.linalg.norm(way)
        place = low + rng.choice([0.0, 1.0, 0.5], 3) * size + way
        pose = Pose(turn(rng, rng.random() * angle) @ goal.rotation, place)
        for i, radius in enumerate(problem.fingers.radius.tolist()):
            centres, piece = judge.centres(i), problem.fingers.placements.piece
            free = judge.scene.free_placements(pose, centres, radius, piece)
            assert (may[i] >= free).all()


def test_a_goal_as_wide_as_what_stands_in_it() -> None:
    """Where a goal's middle is inside a wall plans end before that, at the best cost."""
    low, high = np.array([0.5, 0.0, 0.5]), np.array([4.0, 0.0, 0.5])
    problem = up_to_a_wall(
        goal=PoseGoal(low, high, np.eye(3), None, 1e-3, 0.01),
        obstacles={"wall": box_between([1.3, -5, 0], [3.3, 5, 0.9])},
        cost={"regrasp": 10, "stability": 0.5},
    )
    other = lanes(problem)
    assert other.cost is not None and other.optimal
    assert kept(problem).cost == pytest.approx(other.cost, rel=1e-9)


IN_THE_AIR = (("random/free-clutter/10", ()), ("random/free/37", ()))


@pytest.mark.parametrize(("name", "changes"), IN_THE_AIR)
def test_lanes_end_with_none_that_is_refused(name: str, changes: tuple[str, ...]) -> None:
    """The search over lanes, which is not told, finds no cheaper plan."""
    problem = load(name, changes).problem
    other, judge = lanes(problem), _judge(problem)
    assert other.cost is not None and other.optimal and _told(judge) is not None
    last = np.array([other.moves[-1].placements])
    assert GoalSets(judge).may_end(last).all()
    search = kept(problem, other.cost * 1.0001)
    assert search.cost >= other.cost * (1.0 - 1e-9)
    if search.proves(other.cost):
        assert search.cost == pytest.approx(other.cost, rel=1e-9)


@pytest.mark.parametrize("change", ["translation", "quarter turn", "half turn", "units"])
def test_turning_the_world_changes_nothing(change: str) -> None:
    """Moved, turned or in other units as many sets may end."""
    tree, counts = square("random/free-clutter/10"), list[tuple[int, int]]()
    changed, _ = CHANGES[change]
    for one in (tree, changed(tree)):
        judge = _judge(Scenario.from_resolved(one).problem)
        rows = _sets(judge)[1]
        counts.append((len(rows), int(GoalSets(judge).may_end(rows).sum())))
    assert counts[0] == counts[1]
    assert 0 < counts[0][1] < counts[0][0]


def test_a_start_that_is_a_goal_is_no_matter() -> None:
    """A plan that is no motion at all ends wherever it begins, with whatever begins there."""
    problem = free_problem(start=(0, 0, 2.0), goal=(0, 0, 2.0), floor=False)
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    for place, told in (([0, 0, 2.0], False), ([0.5, 0, 2.0], True)):
        goal = PoseGoal(np.array(place), np.array(place), np.eye(3), None, 1e-3, 0.01)
        judge = _judge(towards(problem, goal))
        assert (_told(judge) is not None) == told


def test_wherever_the_last_look_is() -> None:
    """Half a segment before any pose of the goal nothing is touched, and gravity is as told.

    As low as goals may be that are in the air.
    """
    asked = 0
    for seed in range(NEAR):
        rng, low, high = np.random.default_rng(seed), 0.2, 3.0
        for _ in range(6):
            middle = (low + high) / 2.0
            aloft = _told(_judge(near_things(seed, middle))) is not None
            low, high = (low, middle) if aloft else (middle, high)
        problem = near_things(seed, high)
        judge = _judge(problem)
        told, scene = _told(judge), judge.scene
        if told is None:
            continue
        rotations, angle = told
        for pose in arrivals(problem, rng):
            asked += 1
            found = contacts_at(Moment(pose), problem.body, problem.environment)
            assert not len(found.points) and scene.object_free(pose)
            off = rotations[:, 2] @ pose.rotation[2]
            assert np.arccos(np.clip(off, -1.0, 1.0)).min() <= angle + 1e-7
    assert asked > 20 * NEAR


def test_no_set_that_is_refused_is_begun() -> None:
    """Search drops them when their turn comes, and says that none is left."""
    problem = load("tasks/bookshelf", ("fingers.placements.grid=[3, 2]",)).problem
    search = kept(problem)
    hands = search.graph.tables.hands
    assert search._searches[0].cost == np.inf
    assert search.bound >= problem.cost.regrasp
    assert not hands.alive[search.graph._asked].any()
