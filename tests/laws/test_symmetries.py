"""What must not change the optimal cost: place, direction, handedness, units, numbering, format."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import pytest

from gm_ompl.scenario.load import load

Tree = dict[str, Any]
SEEDS = (0, 4, 12, 14, 16, 19, 25, 33, 36, 41)
"""Seeds of ``random/small`` that need few mode decisions and leave all placements open."""

CHANGES = ("translation", "quarter turn", "half turn", "mirror", "units", "renumbering")

PLANAR = [
    "lattice.steps={x: 1, y: 1, yaw: 30 deg}", "fingers.placements.grid=[3, 1]",
    "mechanics.cone_edges=4", "motion.goal={position: [2, 0, 1], yaw: 60 deg}",
]  # fmt: skip


def small(seed: int) -> Tree:
    """A small random problem whose friction pyramids have the symmetries of the square."""
    tree = load(f"random/small/{seed}", ["mechanics.cone_edges=4"]).resolved()
    for key in ("start", "goal"):  # cells are numbered by the axes, which mirrors turn
        tree["fingers"][key] = ["any"] * tree["fingers"]["count"]
    return tree


@pytest.mark.parametrize("seed", SEEDS)
def test_the_cost_of_a_path_has_the_worlds_symmetries(
    seed: int, optimum: Callable[..., float], change: dict[str, Callable[[Tree], Tree]]
) -> None:
    """Translated, turned by the pyramid's symmetry, mirrored, in other units: the same cost."""
    tree = small(seed)
    cost = optimum(tree)
    for name in CHANGES:
        scale = 0.025 if name == "units" else 1.0
        assert optimum(change[name](tree)) == pytest.approx(cost * scale, rel=1e-6), name


@pytest.mark.parametrize("name", ["mirror", "units", "renumbering"])
def test_the_cost_of_planar_motion_has_them_too(
    name: str, optimum: Callable[..., float], change: dict[str, Callable[[Tree], Tree]]
) -> None:
    """A quarter of a planar scenario's laws: mirrored, in other units, fingers renumbered."""
    tree = load("planar/turn", PLANAR).resolved()
    cost = optimum(tree)
    assert cost < math.inf
    scale = 0.025 if name == "units" else 1.0
    assert optimum(change[name](tree)) == pytest.approx(cost * scale, rel=1e-6)


def test_planar_motion_may_happen_anywhere(
    optimum: Callable[..., float], change: dict[str, Callable[[Tree], Tree]]
) -> None:
    """Bounds and goal moved along, and turned by a quarter: the same cost."""
    tree = load("planar/turn", PLANAR).resolved()
    cost = optimum(tree)
    away = change["translation"](tree)
    away["motion"]["planar"] |= {"x": [4.25, 10.25], "y": [-5.5, -1.5]}
    assert optimum(away) == pytest.approx(cost, rel=1e-6)
    turned = change["quarter turn"](tree)
    turned["motion"]["planar"] |= {"x": [-2, 2], "y": [-3, 3]}
    assert optimum(turned) == pytest.approx(cost, rel=1e-6)


def test_the_laws_can_fail(optimum: Callable[..., float]) -> None:
    """What is no symmetry changes the cost: more friction on the floor, half the lattice."""
    tree = small(SEEDS[0])
    cost, other = optimum(tree), copy.deepcopy(tree)
    other["friction"]["environment"] *= 1.2
    assert optimum(other) != pytest.approx(cost, rel=1e-6)


def corners(size: list[float]) -> list[list[float]]:
    x, y, z = (side / 2 for side in size)
    return [[a, b, c] for a in (-x, x) for b in (-y, y) for c in (-z, z)]


BOX_FACES = [
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
]  # fmt: skip


def test_a_box_by_any_name_costs_the_same(optimum: Callable[..., float]) -> None:
    """The paper's tumble and slide with the box as box, hull, mesh, one piece, two flush pieces."""
    for name, coarse in (
        ("paper/tumble", ["lattice.segments=9", "fingers.placements.grid=[3, 4]"]),
        ("paper/slide", ["lattice.segments=5", "fingers.placements.grid=[4, 3]"]),
    ):
        tree = load(name, coarse).resolved()
        size = tree["object"]["shape"]["box"]
        cost = optimum(tree)
        assert cost < math.inf
        half = [side / 2 for side in size]
        for shape in (
            {"hull": corners(size)},
            {"mesh": {"vertices": corners(size), "faces": BOX_FACES}},
            {"pieces": [{"box": {"min": [-h for h in half], "max": half}}]},
            {"pieces": [{"hull": corners(size)}]},
        ):
            other = copy.deepcopy(tree)
            other["object"]["shape"] = shape
            assert optimum(other) == pytest.approx(cost, rel=1e-6), shape.keys()


def test_obstacles_by_any_name_are_the_same(optimum: Callable[..., float]) -> None:
    """The wall behind the paper's tumble as box, hull, mesh and two pieces."""
    coarse = ["lattice.segments=9", "fingers.placements.grid=[3, 3]"]
    tree = load("paper/tumble", coarse).resolved()
    cost, wall = optimum(tree), tree["environment"]["obstacles"]["wall_behind"]["box"]
    low, high = wall["min"], wall["max"]
    points = [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
              for z in (low[2], high[2])]  # fmt: skip
    middle = (low[1] + high[1]) / 2 + 1.0
    for shape in (
        {"hull": points},
        {"mesh": {"vertices": points, "faces": BOX_FACES}},
        {"pieces": [
            {"box": {"min": low, "max": [high[0], middle, high[2]]}},
            {"box": {"min": [low[0], middle, low[2]], "max": high}},
        ]},
    ):  # fmt: skip
        tree["environment"]["obstacles"]["wall_behind"] = shape
        assert optimum(tree) == pytest.approx(cost, rel=1e-6)
