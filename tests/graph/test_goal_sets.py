"""Which sets of placements plans of free motion can end with: what is refused ends none."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from unittest import mock

import numpy as np
import pytest

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.environment import contacts_at
from gm_ompl.feasibility.aloft import Aloft
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.graph.goal_sets import GoalSets
from gm_ompl.graph.kept_graph import KeptGraph
from gm_ompl.motion.free import FreeMotion, PoseGoal
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.plain.contact_lattice import PlainContactLattice
from gm_ompl.problem import Problem
from gm_ompl.reference.modes import decide_modes
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from tests.free_laws import CHANGES, square
from tests.free_scenes import box_between, free_problem, steps, up_to_a_wall
from tests.kept import kept, lanes

SCENES, NODES, REFUSED = 20, 40, 3

TURNS = ((), ((0, 1, 0),), ((0, 0, 1),), ((1, 0, 0), (0, 0, 1)), None)
AXES = ((2,), (0, 2), (1, 2), (0, 1, 2))

SHAPES = (
    {"box": [1, 1, 0.5]},
    {"box": [0.5, 1, 1]},
    {"pieces": [{"box": {"min": [0, 0, 0], "max": [1, 1, 0.4]}},
                {"box": {"min": [0, 0, 0.4], "max": [0.4, 1, 1]}}]},
)  # fmt: skip


def _turn(rng: np.random.Generator, angle: float) -> Array:
    """A rotation by an angle about any axis."""
    axis = rng.normal(size=3)
    return rotation_about(axis / np.linalg.norm(axis), angle)


def _open(seed: int) -> Problem:
    """A body over the floor, a block beside it, its motion of any kind; its goal is not asked."""
    rng = np.random.default_rng(seed)
    shape, parts = SHAPES[rng.integers(len(SHAPES))], int(rng.integers(1, 4))
    ends = bool(rng.random() < 0.4)
    problem = free_problem(
        obstacles={"block": box_between([0.9, -1, 0], [2, 1, rng.choice([0.5, 1.0])])},
        start=(0, 0, rng.choice([0.6, 1.0, 1.5])),
        region=((-1, -1, 0), (1, 1, 3)),
        by=steps(
            float(rng.choice([0.1, 0.25, 0.5])), float(rng.choice([5.0, 20.0, 60.0])),
            AXES[rng.integers(len(AXES))], TURNS[rng.integers(len(TURNS))],
        ),
        object={"shape": shape, "mass": 1},
        fingers={"count": 3, "radius": 0.05, "max_normal_force": rng.choice([5.0, 15.0, 20.0]),
                 "placements": {"grid": [2, 1], "faces": "all"}},
        mechanics={"z_min": 0.3},
        cost={"samples_per_arc": max(parts, 1 + ends), "samples_at": "ends" if ends else "middles"},
    )  # fmt: skip
    problem.motion.ends = ends
    return problem


@cache
def _scene(seed: int) -> tuple[Problem, list[GraphArc]]:
    """A problem whose goal is about a pose of the lattice, and the arcs that lead to goals."""
    rng, problem = np.random.default_rng(100 + seed), _open(seed)
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    lattice, found = PlainContactLattice(problem, motion), list[GraphArc]()
    nodes, node = 1, 0
    while node < min(nodes, NODES):
        found += lattice.arcs_from(node)
        nodes, node = max([nodes, *(arc.head + 1 for arc in found)]), node + 1
    chosen = lattice.pose(found[rng.integers(len(found))].head)
    distance, angle = rng.choice([1e-3, 0.05]), rng.choice([0.01, 0.2])
    size = rng.choice([0.0, 0.0, 0.1]) * rng.random(3)
    place = chosen.position + rng.uniform(-0.5, 0.5, 3) * distance
    turned = _turn(rng, rng.random() * angle) @ chosen.rotation
    goal = PoseGoal(place - size, place + size, turned, None, distance, angle)
    there = FreeMotion(motion.start, goal, motion.region, motion.steps)
    there.ends = motion.ends
    arriving = [arc for arc in found if goal.contains(lattice.pose(arc.head))]
    return replace(problem, motion=there), arriving


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
    # Wrenches that prove as much differ with rounding, and so does what they say of others.
    assert every * may.sum() == pytest.approx(end, rel=0.002 if every == 1 else 0.05)


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
    problem, arriving = _scene(seed)
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
    told = [_told(_judge(_scene(seed)[0])) is not None for seed in range(SCENES)]
    assert 0.3 * SCENES < sum(told) < SCENES


@pytest.mark.parametrize("seed", range(SCENES))
def test_no_arc_of_the_plain_lattice_ends_with_a_refused_set(seed: int) -> None:
    """The reference finds that a refused set falls short, or is not free, wherever arcs arrive."""
    problem, arriving = _scene(seed)
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
    rng, problem = np.random.default_rng(200 + seed), _open(seed)
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    low = rng.uniform([-1.0, -0.5, 0.3], [1.0, 0.5, 1.0])
    size = rng.choice([0.0, 0.02, 2.0]) * rng.random(3)
    distance, angle = rng.choice([0.0, 0.01, 0.3]), rng.choice([0.0, 0.02, 1.0, np.pi])
    goal = PoseGoal(low, low + size, _turn(rng, rng.random() * np.pi), None, distance, angle)
    judge = _judge(
        replace(problem, motion=FreeMotion(motion.start, goal, motion.region, motion.steps))
    )
    may = GoalSets(judge).free()
    assert goal.rotation is not None
    for _ in range(30):
        way = rng.normal(size=3)
        way *= distance * rng.choice([rng.random(), 1.0 - 1e-9]) / np.linalg.norm(way)
        place = low + rng.choice([0.0, 1.0, 0.5], 3) * size + way
        pose = Pose(_turn(rng, rng.random() * angle) @ goal.rotation, place)
        for i, radius in enumerate(problem.fingers.radius.tolist()):
            centres, piece = judge.centres(i), problem.fingers.placements.piece
            free = judge.scene.free_placements(pose, centres, radius, piece)
            assert (may[i] >= free).all()


def test_a_goal_as_wide_as_what_stands_in_it() -> None:
    """Where a goal's middle is inside a wall plans end before that, at the best cost."""
    low, high = np.array([0.5, 0.0, 0.5]), np.array([4.0, 0.0, 0.5])
    problem = up_to_a_wall(goal=PoseGoal(low, high, np.eye(3), None, 1e-3, 0.01))
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
    problem = load("tasks/pick-card").problem
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    place = motion.start.position
    wide = PoseGoal(place, place + np.array([0, 0, 1.0]), motion.start.rotation, None, 1e-3, 0.01)
    judge = _judge(
        replace(problem, motion=FreeMotion(motion.start, wide, motion.region, motion.steps))
    )
    assert _told(judge) is None
    assert all(mask.all() for mask in GoalSets(judge).free())


def test_no_set_that_is_refused_is_begun() -> None:
    """Search drops them when their turn comes, and says that none is left."""
    problem = load("tasks/bookshelf", ("fingers.placements.grid=[3, 2]",)).problem
    search = kept(problem)
    hands = search.graph.tables.hands
    assert search.cost == np.inf
    assert search.bound >= problem.cost.regrasp
    assert not hands.alive[search.graph._asked].any()
