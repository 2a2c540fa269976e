"""What can be dragged in the scene: obstacles, the start, the goal; as keys and values."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.scenario.fields import REST
from gm_ompl.scenario.scenario import Scenario

FINE: Final = 50.0  # where no lattice says how far, a step is about this part of the object's size
LARGEST: Final = 200  # an obstacle of more points cannot be dragged: each move would carry them all

Tree: TypeAlias = Any  # part of a scenario's text: mappings, lists, scalars
UNITS: Final = np.eye(3)

UNSAFE: Final = re.compile(r"[.=]")
"""Names with these cannot stand in KEY=VALUE."""


@dataclass(frozen=True)
class Moved:
    """A value that moves: where it stands, and what it is.

    ``axis`` is None where the value holds points, whose coordinates all move; else the value holds
    coordinates along that axis.
    """

    key: str
    value: Tree
    axis: int | None = None


@dataclass(frozen=True)
class Handle:
    """A place to take hold of."""

    kind: str  # start, goal or obstacle
    name: str  # an obstacle's, as its author wrote it
    at: list[float]  # (3,), world frame
    axes: list[list[float]]  # unit vectors, at most three, along which it is dragged
    steps: list[float]  # along each; displacements are whole steps
    moved: list[Moved]
    nodes: list[int]  # an obstacle's nodes in the scene


def handles(scenario: Scenario, parts: Sequence[tuple[int, Array]]) -> list[Handle]:
    """Return what can be dragged.

    Args:
        scenario: the scenario as it is now.
        parts: of each node in which the scene draws an obstacle, whose part it is (a number) and
            its middle (3,).
    """
    tree: Tree = scenario.document.tree
    return [*_ends(scenario, tree["motion"]), *_obstacles(scenario, tree, parts)]


def _ends(scenario: Scenario, motion: Tree) -> Iterator[Handle]:
    """Yield the start and, where the scenario's own numbers say where it is, the goal."""
    ways = _ways(scenario)
    if _rests(motion["start"]):
        ways.pop(2, None)
    at = scenario.problem.motion.pose(scenario.problem.start).position.tolist()
    place = [Moved("motion.start.position", motion["start"]["position"])]
    yield _handle("start", at, ways, place)
    if motion.get("path"):
        yield from _path_goal(scenario, motion["path"])
    else:
        yield from _goal(motion["goal"], at, _ways(scenario))


def _handle(kind: str, at: list[float], ways: Mapping[int, float], place: list[Moved]) -> Handle:
    return Handle(kind, "", at, [UNITS[k].tolist() for k in ways], [*ways.values()], place, [])


def _goal(goal: Tree, start: list[float], ways: dict[int, float]) -> Iterator[Handle]:
    """Yield a goal that is a pose, or a region; what it leaves open is drawn where the start is."""
    given = dict(enumerate(goal["position"])) if "position" in goal else {
        k: goal[name] for k, name in enumerate("xyz") if name in goal
    }  # fmt: skip
    if "position" in goal:
        place = [Moved("motion.goal.position", goal["position"])]
    else:
        place = [Moved(f"motion.goal.{'xyz'[k]}", interval, k) for k, interval in given.items()]
    at = list(start)
    for k, value in given.items():
        if isinstance(value, list):
            at[k] = sum(value) / 2
        elif _number(value):
            at[k] = float(value)
    ways = {k: step for k, step in ways.items() if k in given and given[k] != REST}
    if ways:
        yield _handle("goal", at, ways, place)


def _rests(part: Tree) -> bool:
    """Whether the height is to be found, so that it cannot be dragged."""
    return "position" in part and not _number(part["position"][2])


def _number(value: object) -> bool:
    return isinstance(value, (int, float))


def _path_goal(scenario: Scenario, path: Tree) -> Iterator[Handle]:
    """Yield the end of a path that ends with a slide: dragged, the slide grows."""
    last = len(path) - 1
    if not path[last].get("slide"):
        return
    by = np.array(path[last]["slide"]["by"], dtype=float)
    level = by[2] == 0.0
    axes = UNITS[:2].tolist() if level else [(by / np.linalg.norm(by)).tolist()]
    step = _nice(scenario.problem.body.diagonal / FINE)
    at = scenario.problem.motion.pose((1.0,)).position.tolist()
    place = [Moved(f"motion.path.{last}.slide.by", path[last]["slide"]["by"])]
    yield Handle("goal", "", at, axes, [step] * len(axes), place, [])


def _ways(scenario: Scenario) -> dict[int, float]:
    """Return along which coordinates start and goal may be dragged, and by which steps."""
    model = scenario.model
    fine = _nice(scenario.problem.body.diagonal / FINE)
    given = model.lattice.steps.given if model.lattice.steps else {}
    if model.motion.free is None:
        return {0: given.get("x", fine), 1: given.get("y", fine)}
    room = (getattr(model.motion.free.region, name) for name in "xyz")
    return {k: given.get("translation", fine) for k, (low, high) in enumerate(room) if low < high}


def _obstacles(
    scenario: Scenario, tree: Tree, parts: Sequence[tuple[int, Array]]
) -> Iterator[Handle]:
    axes = [UNITS[k].tolist() for k in _ways(scenario)]
    step = _nice(scenario.problem.body.diagonal / FINE)
    for k, obstacle in enumerate(scenario.problem.environment.obstacles):
        name = obstacle.name
        place = list(_corners(f"environment.obstacles.{name}", _of(tree, name)))
        if not place or UNSAFE.search(name) or name != name.strip() or not name:
            continue
        nodes = [node for node, (number, _) in enumerate(parts) if number == k]
        middles = [parts[node][1] for node in nodes] or obstacle.body.vertices
        at = np.mean(middles, axis=0).tolist()
        yield Handle("obstacle", name, at, axes, [step] * len(axes), place, nodes)


def _of(tree: Tree, obstacle: str) -> Tree:
    return tree["environment"]["obstacles"][obstacle]


def _corners(key: str, shape: Tree) -> Iterator[Moved]:
    """Yield the points that say where an obstacle is; none where a file says it."""
    if "box" in shape:
        yield from (Moved(f"{key}.box.{end}", shape["box"][end]) for end in ("min", "max"))
    elif "pieces" in shape:
        for k, piece in enumerate(shape["pieces"]):
            yield from _corners(f"{key}.pieces.{k}", piece)
    elif "hull" in shape:
        yield from _points(f"{key}.hull", shape["hull"])
    elif isinstance(shape["mesh"], dict):
        yield from _points(f"{key}.mesh.vertices", shape["mesh"]["vertices"])


def _points(key: str, points: Tree) -> Iterator[Moved]:
    if len(points) <= LARGEST:
        yield Moved(key, points)


def _nice(length: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at most ``length``."""
    power = 10.0 ** math.floor(math.log10(length))
    times = max(factor for factor in (1, 2, 5) if factor * power <= length * (1 + 1e-9))
    return float(f"{times * power:.1g}")
