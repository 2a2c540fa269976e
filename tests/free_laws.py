"""Free motion changed as a whole: turned, mirrored, moved, in other units, renumbered."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.scenario.load import load
from tests.laws.conftest import in_units, renumbered

Tree = dict[str, Any]

AXES: Final = "xyz"
LENGTH: Final = 0.025
"""Of the other units; costs are lengths."""


def square(name: str, *changes: str) -> Tree:
    """A scenario whose friction pyramids have the symmetries of the square."""
    return load(name, ["mechanics.cone_edges=4", *changes]).resolved()


def mapped(tree: Tree, world: Sequence[Sequence[float]], by: Sequence[float] = (0, 0, 0)) -> Tree:
    """The scenario with every point p of the world at ``world`` p + ``by``.

    Args:
        tree: a box in free motion; what fingers touch at the start and the goal is left open.
        world: (3, 3), takes axes to axes, up to up; where it is a reflection the object is
            reflected alike, which takes a box to itself.
        by: a translation along the floor.
    """
    M, shift = np.array(world, dtype=np.float64), np.array(by, dtype=np.float64)
    own = M if np.linalg.det(M) < 0.0 else np.eye(3)
    new = copy.deepcopy(tree)
    scene, motion = new["environment"], new["motion"]
    for obstacle in scene["obstacles"].values():
        ends = np.array([obstacle["box"]["min"], obstacle["box"]["max"]]) @ M.T + shift
        obstacle["box"] = {"min": ends.min(axis=0).tolist(), "max": ends.max(axis=0).tolist()}
    for place in (motion["start"], motion["goal"]):
        if "position" in place:
            place["position"] = (M @ np.array(place["position"]) + shift).tolist()
        else:
            _map_ranges(place, M, shift)
        turned = M @ _rotation(place) @ own.T
        place.pop("yaw", None)
        place["rotation"] = {"quaternion": Pose(turned, shift).quaternion().tolist()}
    free = motion["free"]
    _map_ranges(free["region"], M, shift)
    free["translate"] = [_axis(axis, M) for axis in free["translate"]]
    if free.get("rotate", "any") != "any":
        free["rotate"] = [_axis(axis, M) for axis in free["rotate"]]
    placements = new["fingers"]["placements"]
    if placements["faces"] != "all":
        placements["faces"] = [_face(face, own) for face in placements["faces"]]
    return new


def _map_ranges(place: Tree, M: Array, shift: Array) -> None:
    ends = np.array([place[axis] for axis in AXES if axis in place], dtype=np.float64)
    low, high = np.sort(np.stack([M @ ends[:, 0] + shift, M @ ends[:, 1] + shift]), axis=0)
    place.update(
        {axis: [a, b] for axis, a, b in zip(AXES, low.tolist(), high.tolist(), strict=True)}
    )


def _rotation(place: Tree) -> Array:
    """The rotation of a place of a resolved scenario."""
    given = place.get("rotation")
    if given is not None and "quaternion" in given:
        return Pose.from_quaternion([0, 0, 0], given["quaternion"]).rotation
    if given is not None:
        angle = float(given["angle"].split()[0])
        return Pose(np.eye(3), np.zeros(3)).turned([0, 0, 0], given["axis"], angle).rotation
    return Pose.from_yaw([0, 0, 0], float(str(place.get("yaw", "0")).split()[0])).rotation


def _axis(name: str, M: Array) -> str:
    return AXES[int(np.abs(M @ np.eye(3)[AXES.index(name)]).argmax())]


def _face(name: str, own: Array) -> str:
    sign = -1.0 if name[0] == "-" else 1.0
    normal = sign * own @ np.eye(3)[AXES.index(name[1])]
    k = int(np.abs(normal).argmax())
    return f"{'-' if normal[k] < 0 else '+'}{AXES[k]}"


CHANGES: dict[str, tuple[Callable[[Tree], Tree], float]] = {
    "translation": (lambda tree: mapped(tree, np.eye(3).tolist(), (7.25, -3.5, 0)), 1.0),
    "quarter turn": (lambda tree: mapped(tree, [[0, -1, 0], [1, 0, 0], [0, 0, 1]]), 1.0),
    "half turn": (lambda tree: mapped(tree, [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]), 1.0),
    "mirror": (lambda tree: mapped(tree, [[1, 0, 0], [0, -1, 0], [0, 0, 1]]), 1.0),
    "other mirror": (lambda tree: mapped(tree, [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]), 1.0),
    "units": (lambda tree: in_units(tree, LENGTH), LENGTH),
    "renumbering": (renumbered, 1.0),
}
"""What must not change the optimal cost, beside its unit."""
