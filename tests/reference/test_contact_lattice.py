from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.motion.free import PoseGoal
from tests.free_scenes import (
    ACROSS,
    DEGREE,
    WALL,
    box_between,
    equal,
    explored,
    free_problem,
    hull_of,
    is_set,
    lattice_of,
    listed,
    slides,
    steps,
    turns,
    upright,
)

QUARTERS = [(x / 2, 0.5, 90 * k) for x in range(-2, 3) for k in range(4)]
EDGES = [(x / 2, math.sqrt(0.5), 45 + 90 * k) for x in range(-2, 3) for k in range(4)]


@pytest.mark.parametrize(("rotation", "wanted"), [(90.0, QUARTERS), (45.0, QUARTERS + EDGES)])
def test_a_cube_on_a_bare_floor(rotation: float, wanted: list[tuple[float, float, float]]) -> None:
    """A unit cube tumbles by quarters and slides by halves: five places, four (or eight) ways up.

    A quarter turn takes its middle from x to x +- 1. On an edge its middle is above that edge, at
    x +- 1/2: on the grid, so that it may turn on and slide there too.
    """
    lattice = lattice_of(free_problem(by=steps(rotation=rotation)))
    found = [lattice.pose(node) for node in explored(lattice)]
    assert is_set(found, [upright(*pose) for pose in wanted])


def test_a_tumble_lands_flat_exactly() -> None:
    """In steps of 25 deg the fourth arc ends after 15 deg, flat on the floor, in two segments."""
    lattice = lattice_of(free_problem(by=steps(rotation=25.0)))
    node = lattice.start
    for angle in (25, 50, 75):
        arcs = lattice.arcs_from(node)
        node = next(
            arc.head for arc in arcs
            if equal(arc.arc.end, corner_of_the_way(angle), 1e-12) and arc.parts == 3
        )  # fmt: skip
    last = next(
        arc for arc in lattice.arcs_from(node)
        if turns([arc]) and arc.arc.end.position[0] > corner_of_the_way(75).position[0]
    )  # fmt: skip
    assert equal(last.arc.end, upright(1.0, 0.5, 90), 1e-12)
    assert turns([last])[0].angle == pytest.approx(15 * DEGREE, abs=1e-12)
    assert last.parts == 2
    assert last.arc.pitch == pytest.approx(25 / 3 / 15)
    assert [s.last for s in last.arc.segments(2)] == pytest.approx([25 / 3 / 15, 1.0])


def corner_of_the_way(angle: float) -> Pose:
    """The unit cube turned about its edge at x = 1/2 on the floor."""
    return upright(0.0, 0.5, 0.0).turned([0.5, 0.0, 0.0], ACROSS, angle * DEGREE)


def test_rotations_begin_on_the_grid_alone() -> None:
    """Tilted by 25 deg the cube's middle is off the grid: the turn goes on and back, no other."""
    lattice = lattice_of(free_problem(by=steps(rotation=25.0)))
    tilted = next(
        arc.head for arc in lattice.arcs_from(lattice.start)
        if equal(arc.arc.end, corner_of_the_way(25))
    )  # fmt: skip
    arcs = lattice.arcs_from(tilted)
    found = turns(arcs)
    assert sorted(np.sign(turn.axis[1]) * turn.angle / DEGREE for turn in found) == pytest.approx(
        [-25, 25]
    )
    for turn in found:
        assert np.cross(turn.pivot - [0.5, 0, 0], ACROSS) == pytest.approx([0, 0, 0], abs=1e-12)
    x = float(lattice.pose(tilted).position[0])
    down, up = math.floor(2 * x) / 2, math.ceil(2 * x) / 2
    assert listed(slides(arcs)) == listed(np.array([u - x, 0, 0]) for u in (down, up))
    moved = next(arc.head for arc in arcs if slides([arc]))
    assert len(turns(lattice.arcs_from(moved))) == 2  # on the grid again: about its edge, anew


def test_a_box_slides_up_to_a_wall() -> None:
    """The wall is at 1.3, so the last step ends at 0.8, in two segments; the wall fixes x there."""
    lattice = lattice_of(free_problem(obstacles=WALL))
    node, xs, parts = lattice.start, list[float](), list[int]()
    while ahead := [a for a in lattice.arcs_from(node) if slides([a]) and slides([a])[0][0] > 0]:
        assert len(ahead) == 1
        node = ahead[0].head
        xs.append(float(lattice.pose(node).position[0]))
        parts.append(ahead[0].parts)
    assert xs == pytest.approx([0.5, 0.8], abs=1e-12)
    assert parts == [3, 2]
    found = turns(lattice.arcs_from(node))  # about the edge behind, or the one high on the wall
    assert sorted(np.round(t.pivot[[0, 2]], 9).tolist() for t in found) == [[0.3, 0], [1.3, 1]]
    assert [t.axis[1] * t.angle / DEGREE for t in sorted(found, key=lambda t: t.pivot[0])] == (
        pytest.approx([-45, 45])
    )


def test_a_box_leans_on_a_wall() -> None:
    """Tumbling 0.3 in front of a wall ends where sin(angle) = 0.3; it may then turn about both."""
    lattice = lattice_of(free_problem(obstacles=WALL, start=(0.5, 0, 0.5), by=steps(rotation=15.0)))
    (once,) = (a.head for a in lattice.arcs_from(lattice.start)
               if turns([a]) and a.arc.end.position[0] > 0.5)  # fmt: skip
    x = lattice.pose(once).position[0]
    (twice,) = (a for a in lattice.arcs_from(once) if turns([a]) and a.arc.end.position[0] > x)
    lean = math.asin(0.3)
    want = upright(0.5, 0.5, 0.0).turned([1, 0, 0], ACROSS, lean)
    assert equal(twice.arc.end, want, 1e-12)
    found = {tuple(np.round(t.pivot[[0, 2]], 9)) for t in turns(lattice.arcs_from(twice.head))}
    assert found == {(1.0, 0.0), (1.3, round(math.cos(lean), 9))}


def test_along_a_slope() -> None:
    """On a slope of 30 deg the cube slides one step up or down it, and as listed axes say."""
    slope = hull_of([(0, y, 0) for y in (-5, 5)] + [(4, y, 0) for y in (-5, 5)]
                    + [(4, y, 4 * math.tan(30 * DEGREE)) for y in (-5, 5)])  # fmt: skip
    normal = np.array([-0.5, 0.0, math.sqrt(0.75)])
    along = np.array([math.sqrt(0.75), 0.0, 0.5])
    start = Pose(rotation_about(ACROSS, -30 * DEGREE), 2.0 * along + 0.5 * normal)
    problem = free_problem(
        obstacles={"slope": slope}, start=start, region=((-9, -9, 0), (9, 9, 9)),
        by=steps(translate=(0, 1, 2), rotate=((0, 0, 1),)),
    )  # fmt: skip
    lattice = lattice_of(problem)
    wanted = [0.5 * along, -0.5 * along, [0, 0.5, 0], [0, -0.5, 0], [-0.5, 0, 0], [0, 0, 0.5]]
    arcs = lattice.arcs_from(lattice.start)
    assert listed(slides(arcs)) == listed(map(np.array, wanted))
    assert not turns(arcs)  # no line is upright


def test_what_touches_nothing_turns_about_its_middle() -> None:
    """In the air: to and fro along three axes, and about three through the centre of mass."""
    problem = free_problem(
        start=(0, 0, 2), region=((-5, -5, 0), (5, 5, 5)),
        by=steps(translate=(0, 1, 2), rotate=None),
    )  # fmt: skip
    lattice = lattice_of(problem)
    arcs = lattice.arcs_from(lattice.start)
    steps_of = [sign * 0.5 * axis for sign in (1, -1) for axis in np.eye(3)]
    assert listed(slides(arcs)) == listed(steps_of)
    found = turns(arcs)
    assert all((turn.pivot == [0, 0, 2]).all() for turn in found)
    assert listed(turn.axis * turn.angle / (90 * DEGREE) for turn in found) == listed(steps_of)


def test_a_flat_box_turns_about_its_edges_and_in_place() -> None:
    """With any rotation: about four edges outwards, and either way about the turning line."""
    problem = free_problem(region=((-5, -5, 0), (5, 5, 5)), by=steps(rotate=None))
    arcs = turns(lattice_of(problem).arcs_from(0))
    assert (
        sorted(np.round(turn.pivot, 9).tolist() for turn in arcs if turn.axis[2])
        == [[0, 0, 0.5]] * 2
    )
    tumbles = [turn for turn in arcs if not turn.axis[2]]
    assert len(tumbles) == 4
    for turn in tumbles:  # the middle goes up and over the edge
        assert turn.angle * np.cross(turn.axis, [0, 0, 0.5] - turn.pivot)[2] > 0


def test_the_region_holds_all_along() -> None:
    """Under a ceiling of the region the middle may not rise, though the quarter turn ends low."""
    low = free_problem(region=((-1, 0, 0), (1, 0, 0.7)), by=steps(rotation=90.0))
    high = free_problem(region=((-1, 0, 0), (1, 0, 0.7072)), by=steps(rotation=90.0))
    assert not turns(lattice_of(low).arcs_from(0))
    assert len(turns(lattice_of(high).arcs_from(0))) == 2


def test_a_seam_ends_a_slide_and_is_passed() -> None:
    """Sliding from one table onto the next ends where it is first touched, and then goes on."""
    tables = {
        "one": box_between([-5, -5, -1], [0.7, 5, 0]),
        "two": box_between([0.7, -5, -1], [5, 5, 0]),
    }
    problem = free_problem(obstacles=tables, floor=False, region=((-1, 0, 0), (2, 0, 3)))
    lattice = lattice_of(problem)
    node, xs = lattice.start, list[float]()
    for _ in range(3):
        node = next(
            a.head for a in lattice.arcs_from(node) if slides([a]) and slides([a])[0][0] > 0
        )
        xs.append(float(lattice.pose(node).position[0]))
    assert xs == pytest.approx([0.2, 0.5, 1.0], abs=1e-12)


def test_a_face_that_comes_flush_ends_a_slide() -> None:
    """A block whose side lies in the plane of the box's side is touched: the slide ends there."""
    block = {"block": box_between([0.75, 0.5, 0], [2, 1, 1])}
    lattice = lattice_of(free_problem(obstacles=block))
    ahead = [by for by in slides(lattice.arcs_from(0)) if by[0] > 0]
    assert listed(ahead) == [[0.25, 0, 0]]
    beside = {"block": box_between([0.75, 0.501, 0], [2, 1, 1])}
    assert [0.5, 0, 0] in listed(slides(lattice_of(free_problem(obstacles=beside)).arcs_from(0)))


def test_thin_things_are_not_jumped_over() -> None:
    """A sheet far thinner than a step ends the slide; a post ends the turn in place."""
    sheet = {"sheet": box_between([0.6, -5, 0], [0.6001, 5, 3])}
    lattice = lattice_of(free_problem(obstacles=sheet, by=steps(translation=4.0),
                                      region=((-9, 0, 0), (9, 0, 3))))  # fmt: skip
    assert [0.1, 0, 0] in listed(slides(lattice.arcs_from(0)))
    post = {"post": box_between([0.6, -0.0005, 0], [0.6005, 0.0005, 3])}
    problem = free_problem(obstacles=post, by=steps(rotation=90.0, rotate=((0, 0, 1),)))
    one, other = turns(lattice_of(problem).arcs_from(0))
    # A corner, 0.7071 from the middle, ends at the post's near side or at its edge: by symmetry.
    assert one.angle == pytest.approx(-other.angle, abs=1e-9)
    assert 0.0 < abs(one.angle) < 45 * DEGREE


def test_depth_counts_arcs_on_geometry_alone() -> None:
    """Nodes within a depth are those so many arcs from the start, in whatever order one asks."""
    whole = lattice_of(free_problem(obstacles=WALL, start=(0.5, 0, 0.5)))
    layers = {whole.start: 0}
    for node in (queue := [whole.start]):
        for arc in whole.arcs_from(node) if layers[node] < 2 else ():
            if arc.head not in layers:
                layers[arc.head] = layers[node] + 1
                queue.append(arc.head)
    limited = lattice_of(free_problem(obstacles=WALL, start=(0.5, 0, 0.5), by=steps(depth=2)))
    found, waiting = {limited.start}, [limited.start]
    while waiting:  # depth first
        new = {arc.head for arc in limited.arcs_from(waiting.pop())} - found
        found |= new
        waiting += sorted(new)
    assert is_set([limited.pose(n) for n in found], [whole.pose(n) for n in layers])
    assert sorted(map(limited.depth, found)) == sorted(layers.values())


def test_a_way_follows_its_nodes() -> None:
    """A way's places are its nodes' poses, its arcs lead from one to the next."""
    lattice = lattice_of(free_problem(obstacles=WALL))
    nodes = [lattice.start]
    for _ in range(4):
        nodes.append(lattice.arcs_from(nodes[-1])[-1].head)
    way = lattice.way(nodes)
    assert way.coordinates == ((),) * 5
    assert [arc.head for arc in way.arcs] == [1, 2, 3, 4]
    for (tail, head), arc in zip(itertools.pairwise(way.poses), way.arcs, strict=True):
        assert equal(arc.arc.start, tail)
        assert equal(arc.arc.end, head, 1e-6)


def test_the_goal_is_met_at_nodes() -> None:
    """A node is in the goal where place and rotation are near enough."""
    place = np.array([1.0, 0.0, 0.5])
    goal = PoseGoal(place, place, rotation_about(ACROSS, 90 * DEGREE), None, 1e-3, 0.5 * DEGREE)
    lattice = lattice_of(free_problem(goal=goal, by=steps(1.0, rotation=90.0)))
    assert lattice.goal_nodes is None
    met = [lattice.pose(node) for node in explored(lattice) if lattice.in_goal(node)]
    assert is_set(met, [upright(1.0, 0.5, 90)])
