"""Mirror symmetry: images of sets are worth as much as the sets; what breaks it is noticed."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from unittest import mock

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.reach import Reach
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph import mirror
from gm_ompl.graph.kept_tables import STATES
from gm_ompl.graph.mirror import Orbits, mirrors
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.motion.screw import Screw, Slide, Tumble
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget
from gm_ompl.problem import Placements, Problem
from gm_ompl.scenario.load import load
from tests.kept import kept

SETS, ARCS = 60, 12

ALL_WAYS = (
    "motion.free={region: {x: [-2, 2], y: [-2, 2], z: [0, 3]}, translate: [x, y, z], rotate: any}",
    "motion.goal={position: [0, 0, 1], up: -z}",
    "fingers.placements.grid=[3, 3]",
)
FENCE = "environment.obstacles={a: {box: {min: [1, -2, 0], max: [2, 2, 1]}}, "
FENCED = FENCE + "b: {box: {min: [-2, -2, 0], max: [-1, 2, 1]}}}"
ASKEW = ("motion.start={position: [0, 0, rest], yaw: 45 deg}", "mechanics.cone_edges=8")
PEG = ("fingers.placements.grid=[2, 3]",)

SYMMETRIC = (
    ("tasks/ledge", (), (1,)),
    ("tasks/peg-thin-fingers", PEG, (0,)),
    ("tasks/bookshelf", (), (0,)),
    ("tasks/pick-card-soft", (), (1,)),
    ("free/l-bracket", (), (1,)),
    ("tasks/reorient", ALL_WAYS, (0, 1)),
    ("tasks/reorient", (*ALL_WAYS, *ASKEW), (0, 1)),
    ("tasks/placedown", (*ALL_WAYS, FENCED, "fingers.count=3"), (0, 1)),
)


@pytest.fixture(params=SYMMETRIC, ids=lambda one: "-".join(map(str, (one[0], *one[2]))))
def symmetric(request: pytest.FixtureRequest) -> tuple[Problem, tuple[int, ...]]:
    """A problem, and the planes in which it is its own image."""
    name, changes, planes = request.param
    return load(name, changes).problem, planes


def begun(problem: Problem) -> KeptSearch:
    """A search that has not taken a step."""
    judge = Judge(problem, KernelBackend(problem))
    search = KeptSearch.of(judge, Log(Budget().start(), judge))
    assert search is not None
    return search


def some_arcs(problem: Problem, rng: np.random.Generator) -> Iterator[GraphArc]:
    """Arcs along a way by chance that begins anew now and then."""
    graph, judge = problem.object_graph, Judge(problem, KernelBackend(problem))
    for _ in range(ARCS):
        node = graph.start
        for _ in range(rng.integers(1, 6)):
            free = [a for a in graph.arcs_from(node) if judge.along(a.arc).object_free]
            step = free[rng.integers(len(free))]
            node = step.head
        yield step


def imaged(step: GraphArc, problem: Problem, axis: int) -> GraphArc:
    """The arc seen in a mirror: written from what a reflection does to a screw."""
    screw, motion, M = step.arc, problem.motion, np.eye(3)
    assert isinstance(screw, Screw) and isinstance(motion, FreeMotion)
    M[axis, axis] = -1.0
    centre, R = motion.start.position, motion.start.rotation

    def seen(point: Array) -> Array:
        return centre + M @ (point - centre)

    def posed(pose: Pose) -> Pose:
        return Pose(M @ pose.rotation @ R.T @ M @ R, seen(pose.position))

    whole = screw.whole
    if isinstance(whole, Slide):
        image: Slide | Tumble = Slide(M @ whole.by)
    else:
        image = Tumble(seen(whole.pivot), M @ whole.axis, -whole.angle)
    arc = dataclasses.replace(screw, origin=posed(screw.origin), whole=image, known={})
    return GraphArc(step.head, arc, step.parts)


def test_images_are_worth_as_much(symmetric: tuple[Problem, tuple[int, ...]]) -> None:
    """Along the image of an arc an image travels as far, is as free and holds as well."""
    problem, planes = symmetric
    found = mirrors(problem)
    assert tuple(found) == planes
    rng, hand = np.random.default_rng(3), problem.fingers
    backend = KernelBackend(problem)
    judge, sets = Judge(problem, backend), PlacementSets(hand.groups())
    held = 0
    for step in some_arcs(problem, rng):
        rows = sets.canonical_rows(rng.integers(0, len(hand.placements), (SETS, hand.count)))
        for axis, image in found.items():
            other = imaged(step, problem, axis)
            for i in range(hand.count):
                here, there = judge.centres(i), judge.centres(i)[image]
                assert other.lengths(there) == pytest.approx(step.lengths(here), abs=1e-12)
                free, freed = judge.along(step.arc).free[i], judge.along(other.arc).free[i]
                assert (free == freed[image]).all()
            images = sets.canonical_rows(image[rows])
            states = zip(judge.environments(step), judge.environments(other), strict=True)
            for state, mirrored in states:
                z = backend.margins(np.full(SETS, state), rows, 1e-9)
                w = backend.margins(np.full(SETS, mirrored), images, 1e-9)
                stable = np.isfinite(z)
                held += int(stable.sum())
                assert (stable == np.isfinite(w)).all()
                assert w[stable] == pytest.approx(z[stable], rel=1e-9)
    assert held > 100


def test_one_of_each_orbit_is_opened(symmetric: tuple[Problem, tuple[int, ...]]) -> None:
    """That is half of the sets, or a quarter, or a few more; the others come when asked for."""
    problem, planes = symmetric
    search = begun(problem)
    rows = search.graph.tables.hands.rows
    orbits, opened = Orbits(problem, rows), int(search.graph.tables.book.counts[STATES])
    share = len(rows) / 2 ** len(planes)
    assert share <= len(orbits.first) == opened < 1.2 * share
    taken = [orbits.take(number) for number in orbits.first.tolist()]
    assert sorted(np.concatenate([orbits.first, *taken]).tolist()) == list(range(len(rows)))
    assert not any(len(orbits.take(number)) for number in range(len(rows)))


SMALL = (
    ("tasks/reorient", ("fingers.placements.grid=[2, 2]",)),
    ("tasks/placedown", ("fingers.placements.grid=[2, 3]", "cost.samples_at=ends")),
    ("tasks/pick-card-soft", ("motion.goal.position=[0.75, 0, 0.25]", "motion.goal.rotation=any")),
    ("tasks/reorient", ("fingers.placements.grid=[2, 3]", "fingers.leave=true")),
    ("tasks/reorient", (
        ALL_WAYS[0], "fingers.count=3", "fingers.placements.grid=[1, 2]",
        "motion.goal={position: [0, 0, 0.5], up: -z}",
        "lattice.steps={translation: 0.5, rotation: 90 deg}",
    )),
    ("tasks/peg-thin-fingers", (
        "motion.goal.position=[0, -0.3, 2.6]", "fingers.placements.grid=[1, 2]",
    )),
    ("tasks/peg-thin-fingers", (
        "motion.goal={position: [0, 0, 3.2], within: {position: 0.4}}",
        "motion.free.region={x: [-0.3, 0.3], y: [-0.3, 0.3], z: [1.9, 8.5]}",
        "fingers.placements.grid=[2, 2]",
    )),
    ("random/free-clutter/3", ()),
)  # fmt: skip


def compared(problem: Problem) -> tuple[KeptSearch, KeptSearch]:
    """The search with and without the symmetry."""
    with mock.patch.object(mirror, "mirrors", return_value={}):
        whole = kept(problem, 6.0)
    return kept(problem, 6.0), whole


@pytest.mark.parametrize(("name", "changes"), SMALL)
def test_it_finds_what_all_sets_find(name: str, changes: tuple[str, ...]) -> None:
    """Costs and bounds are equal, for fewer states."""
    half, whole = compared(load(name, changes).problem)
    assert half.cost == pytest.approx(whole.cost, rel=1e-9)
    assert half.bound == pytest.approx(whole.bound, rel=1e-9)
    assert half.expanded < 0.75 * whole.expanded


@pytest.mark.parametrize("where", ["at the start", "at the goal"])
def test_what_grids_refuse_is_left_to_images(where: str) -> None:
    """Where no way through the air is found for sets that were opened, their images are asked."""
    changes = ("fingers.placements.grid=[2, 2]", "fingers.leave=true")
    problem = load("tasks/reorient", changes).problem
    rows = begun(problem).graph.tables.hands.rows
    orbits = Orbits(problem, rows)
    refused = {tuple(rows[k].tolist()) for k in orbits.first.tolist() if len(orbits.take(k))}
    start, landing = problem.object_graph.pose(problem.object_graph.start), Reach.landing

    def grudging(
        reach: Reach, pose: Pose, placements: Placements, standing: tuple[int, ...] = ()
    ) -> tuple[int, ...] | None:
        here = np.array_equal(pose.position, start.position) == (where == "at the start")
        refuses = placements in refused and here
        return None if refuses else landing(reach, pose, placements, standing)

    free = kept(problem)
    with mock.patch.object(Reach, "landing", grudging):
        half, whole = compared(problem)
    assert half.cost == pytest.approx(whole.cost, rel=1e-9)
    assert half.cost == pytest.approx(free.cost, rel=1e-9)
    assert half.moves()[0].placements not in refused


D = 0.2 * math.sqrt(3.0)
PYRAMID = "[[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0], [0, 0.001, 0.2]]"
PRISM = [
    [0.1 * math.cos(k * math.pi / 3), 0.1 * math.sin(k * math.pi / 3), z]
    for k in range(6) for z in (-0.1, 0.1)
]  # fmt: skip
UNIFORM = "object.inertia=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
LEDGE = "environment.obstacles.ledge"
BROKEN = (
    (f"{LEDGE}.box={{min: [-1, -1, 0], max: [0, {1.0 + 1e-6 * D}, 1]}}",),
    (f"{LEDGE}.rotation={{axis: [0, 0, 1], angle: 1e-5 deg}}",),
    (f"{LEDGE}.rotation={{axis: [1, 0, 0], angle: 1e-5 deg}}",),
    ("environment.obstacles.post={box: {min: [1, 0.5, 0], max: [1.1, 0.7, 1]}}",),
    ("mechanics.cone_edges=5",),
    ("mechanics.cone_edges=5", "fingers.placements.faces=[+y, -y]"),
    ("mechanics.margin=strong",),
    ("mechanics.patch_points=1",),
    ("lattice.steps.rotation=180 deg",),
    (f"motion.goal.position=[-0.3, {1e-6 * D}, 1.1]",),
    ("motion.goal={x: [-0.4, -0.2], y: [0, 1e-5], z: [1.1, 1.1]}",),
    ("motion.goal.rotation={axis: [1, 0, 0], angle: 90 deg}",),
    ("motion.goal={position: [-0.3, 0, 1.1], up: +y}",),
    ("motion.free.region={x: [-0.5, 0.6], y: [0, 0.1], z: [0, 1.4]}",),
    ("motion.start={position: [0.5, 0, rest], yaw: 10 deg}",),
    ("motion.start={position: [0.5, 0, rest], yaw: 45 deg}", "motion.goal.yaw=45 deg"),
    ("motion.start.position=[0.5, 1e-6, rest]", "motion.goal.position=[-0.3, 1e-6, 1.1]",
     "motion.free.region={x: [-0.5, 0.6], y: [1e-6, 1e-6], z: [0, 1.4]}"),
    ("fingers.start=[{face: +y, cell: [1, 1]}, any]",),
    ("fingers.goal=[{face: +y, cell: [1, 1]}, any]",),
    ("fingers.start=[{face: +y, cell: [1, 1]}, {face: -y, cell: [1, 1]}]",),
    ("fingers.placements.faces=[+x, -x, +y]",),
    ("object.centre_of_mass=[0, 1e-6, 0]", UNIFORM),
    ("object.centre_of_mass=[0, 0, 0]", "object.inertia=[[1, 0.001, 0], [0.001, 1, 0], [0, 0, 1]]"),
    (f"object.shape={{hull: {PYRAMID}}}",),
    (f"object.shape={{hull: {PYRAMID}}}", "object.centre_of_mass=[0, 0, 0.05]", UNIFORM,
     "fingers.placements={grid: [3, 3], faces: [2]}"),  # the base alone is its own image
    (f"object.shape={{hull: {PRISM}}}", "mechanics.cone_edges=12", "motion.goal.yaw=30 deg",
     "motion.start={position: [0.5, 0, rest], yaw: 30 deg}",
     "fingers.placements={grid: [1, 1], faces: [3, 4]}"),  # all but the directions of (7)
    ("uncertainty={mass: 5%}",),
    ("uncertainty={environment_friction: {ledge: 0.01}}",),
)  # fmt: skip


@pytest.mark.parametrize("changes", BROKEN, ids=lambda changes: changes[0][:60])
def test_what_breaks_it_is_noticed(changes: tuple[str, ...]) -> None:
    """The least thing that is not its own image, and there is no symmetry."""
    assert set(mirrors(load("tasks/ledge").problem)) == {1}
    assert not mirrors(load("tasks/ledge", changes).problem)


def test_no_hand_and_no_slanting_axis_is_mirrored() -> None:
    """A robot's hand stands to one side; so does an axis that is neither x nor y nor z."""
    problem = load("tasks/reorient", ALL_WAYS).problem
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    slanting = dataclasses.replace(motion.steps, rotate=np.array([[0.6, 0.8, 0.0]]))
    other = FreeMotion(motion.start, motion.goal, motion.region, slanting)
    assert set(mirrors(problem)) == {0, 1}
    assert not mirrors(dataclasses.replace(problem, motion=other))
    assert not mirrors(dataclasses.replace(problem, hand=mock.Mock()))


def test_placements_that_cannot_be_told_apart_are_not_mirrored() -> None:
    """Nor are those that lie on pieces which are no images of each other."""
    problem = load("free/l-bracket").problem
    assert set(mirrors(problem)) == {1}
    hand = problem.fingers
    table, piece = hand.placements, hand.placements.piece.copy()
    piece[0] = 1 - piece[0]
    for other in (dataclasses.replace(table, piece=piece), table.joined(table.at([0]))):
        fingers = dataclasses.replace(hand, placements=other)
        assert not mirrors(dataclasses.replace(problem, fingers=fingers))


def test_each_plane_is_looked_at_by_itself() -> None:
    """What breaks one symmetry leaves the other; only what lies on a plane is its own image."""
    for changes, planes in (
        ((*ALL_WAYS, "motion.goal={position: [0, 0.5, 1], up: -z}"), {0}),
        ((*ALL_WAYS, "motion.goal={position: [0.5, 0, 1], up: -z}"), {1}),
        ((*ALL_WAYS, "motion.goal={position: [0, 0, 1], up: x}"), {1}),
        ((*ALL_WAYS, FENCE + "b: {box: {min: [-2, -2, 0], max: [-1, 2, 1.000001]}}}"), {1}),
    ):
        assert set(mirrors(load("tasks/reorient", changes).problem)) == planes
