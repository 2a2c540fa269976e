"""The families ``random/free`` and ``random/free-clutter``: free motion, few poses and hands."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

from gm_ompl.scenario.small import GRAVITY, Draw, rounded

Tree: TypeAlias = dict[str, Any]

FACES = ("-x", "+x", "-y", "+y", "+z")


class FreeTask(NamedTuple):
    """What is to be done.

    Attributes:
        motion: the scenario's section.
        lattice: likewise.
        arcs: how many arcs are enough for it, with some to spare.
        reach: how far the object reaches from its centre of mass at the start, along x and y.
        side: whether it goes towards +x or -x.
        farthest: the greatest |x| that the goal needs free.
        fingers: how many it takes: in the air two point contacts hold nothing.
    """

    motion: Tree
    lattice: Tree
    arcs: int
    reach: tuple[float, float]
    side: int
    farthest: float
    fingers: int


def free(draw: Draw) -> Tree:
    """Return a box to be rolled, turned where it stands, or lifted; no obstacles."""
    tree, _ = _free(draw, "Free motion of a box on an open floor.")
    return tree


def free_clutter(draw: Draw) -> Tree:
    """Return the same with one or two boxes about, sometimes where the object touches them."""
    tree, task = _free(draw, "Free motion of a box past one or two others.")
    behind, beside, ahead = (
        _box(draw, task, tree, place) for place in ("behind", "beside", "ahead")
    )
    walls = {"behind": behind, "beside": beside, "ahead": ahead}
    # Among obstacles the object comes to lie askew in ever new places.
    tree["lattice"]["depth"] = task.arcs
    kept = draw.some(tuple(walls), draw.whole(1, 2))
    tree["environment"]["obstacles"] = {name: walls[name] for name in kept}
    return tree


def _free(draw: Draw, description: str) -> tuple[Tree, FreeTask]:
    size = [draw.between(2, 8, 2) for _ in range(3)]
    mass = rounded(10 ** draw.between(-1, 1), 2)
    task = draw.pick((_roll, _roll, _turn, _lift))(draw, size)
    if task.fingers == 3:
        faces = list(draw.pick((("-x", "+x"), ("-y", "+y"))))
    else:
        faces = draw.some(FACES, draw.pick((1, 2, 2, 3)))
    limit = rounded(draw.pick((0.5, 1.0, 2.0, 4.0)) * mass * GRAVITY, 2)
    z_min = rounded(draw.between(0.002, 0.04) * mass * GRAVITY, 2)
    tree = {
        "description": description,
        "object": {"shape": {"box": size}, "mass": mass},
        "friction": {
            "environment": draw.between(0.2, 1.0, 2),
            "finger": draw.between(0.4, 1.2, 2),
        },
        "gravity": GRAVITY,
        "fingers": {
            "count": task.fingers,
            "radius": rounded(draw.between(0.05, 0.2) * min(size), 2),
            "max_normal_force": limit,
            "placements": {"grid": [2, 2] if len(faces) > 1 else [3, 3], "faces": faces},
        },
        "environment": {"floor": True, "obstacles": {}},
        "motion": task.motion,
        "lattice": task.lattice,
        "mechanics": {"cone_edges": draw.pick((4, 6)), "directions": 76, "z_min": z_min},
        "cost": {
            "regrasp": rounded(draw.pick((0.02, 1.0, 5.0)) * max(size), 2),
            "stability": rounded(0.001 * mass * GRAVITY, 2),
            "samples_per_arc": draw.pick((1, 1, 2)),
        },
    }
    return tree, task


def _motion(x: list[float], z: float, translate: str, rotate: str, goal: Tree) -> Tree:
    """Return the section; ``x`` and ``z`` bound the region, axes are letters."""
    low, high = sorted(rounded(value, 6) for value in x)
    return {
        "free": {
            "region": {"x": [low, high], "y": [0, 0], "z": [0, rounded(z, 6)]},
            "translate": list(translate),
            "rotate": list(rotate),
        },
        "start": {"position": [0, 0, "rest"]},
        "goal": goal,
    }


def _roll(draw: Draw, size: list[float]) -> FreeTask:
    """Return a quarter turn or two over an edge, to within a step or two of where that ends."""
    a, _, c = size
    step = rounded(draw.between(0.6, 1.0) * a, 2)
    side, quarters = draw.pick((1, -1)), draw.pick((1, 1, 1, 2))
    way = quarters * (a + c) / 2
    ends = sorted(rounded(side * (way + sign * quarters * step), 6) for sign in (-1, 1))
    x = [-side * step, side * (way + 2 * step)]
    height = (a * a + c * c) ** 0.5
    goal = {"x": ends, "rotation": {"axis": [0, 1, 0], "angle": f"{90 * side * quarters} deg"}}
    degrees = draw.pick((30, 45, 90))
    lattice: Tree = {"steps": {"translation": step, "rotation": f"{degrees} deg"}}
    arcs = min(7, quarters * 90 // degrees + 3)
    if quarters == 2 or draw.chance(0.5):
        lattice["depth"] = arcs
    motion = _motion(x, height, "x", "y", goal)
    farthest = way + (c if quarters == 1 else a) / 2
    return FreeTask(motion, lattice, arcs, (a / 2, size[1] / 2), side, farthest, 2)


def _turn(draw: Draw, size: list[float]) -> FreeTask:
    """Return a turn about the vertical and a way along x."""
    a, b, c = size
    step = rounded(draw.between(0.6, 1.0) * a, 2)
    side, steps, degrees = draw.pick((1, -1)), draw.whole(0, 2), draw.pick((30, 45, 90))
    yaw = degrees * draw.whole(1, 2) * draw.pick((1, -1))
    x = [-side * step, side * (steps + 1) * step]
    goal = {"position": [rounded(side * steps * step, 6), 0, "rest"], "yaw": f"{yaw} deg"}
    lattice = {"steps": {"translation": step, "rotation": f"{degrees} deg"}}
    around = rounded((a * a + b * b) ** 0.5 / 2, 6)
    motion = _motion(x, c, "x", "z", goal)
    return FreeTask(motion, lattice, steps + 4, (around, around), side, steps * step + around, 2)


def _lift(draw: Draw, size: list[float]) -> FreeTask:
    """Return a way up, and along x in the air."""
    a, b, c = size
    step = rounded(draw.between(0.4, 0.8) * min(a, c), 2)
    side, along, up = draw.pick((1, -1)), draw.whole(0, 2), draw.whole(1, 2)
    arcs = along + up + 1
    x = [0.0, side * (along + 1) * step]
    top = rounded(c / 2 + up * step, 6)
    goal = {"position": [rounded(side * along * step, 6), 0, top]}
    lattice = {"steps": {"translation": step, "rotation": "90 deg"}, "depth": arcs}
    motion = _motion(x, top + step, "xz", "", goal)
    return FreeTask(motion, lattice, arcs, (a / 2, b / 2), side, along * step + a / 2, 3)


def _box(draw: Draw, task: FreeTask, tree: Tree, place: str) -> Tree:
    """Return a box behind the object, beside it, or ahead of where it must get to."""
    size = tree["object"]["shape"]["box"]
    far, gap = 10.0 * max(size), draw.pick((0.0, 0.0, 0.1, 0.5)) * min(size)
    top = rounded(draw.pick((0.3, 0.6, 3.0)) * size[2], 3)
    low, high = [-far, -far, 0.0], [far, far, top]
    if place == "beside":
        low[1] = rounded(task.reach[1] + gap, 6)
        return {"box": {"min": low, "max": high}}
    edge = rounded((task.farthest if place == "ahead" else task.reach[0]) + gap, 6)
    if (place == "ahead") == (task.side > 0):
        low[0] = edge
    else:
        high[0] = -edge
    return {"box": {"min": low, "max": high}}
