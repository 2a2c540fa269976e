"""Random scenarios, ``random/FAMILY/SEED``: the same everywhere, for tests, studies, tuning.

Sizes, masses, friction, limits, grids, segments, walls and units vary; what a family keeps is
the kind of motion. Forces are drawn relative to the object's weight and lengths relative to its
sides, so that no unit is special.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from gm_ompl.scenario.document import dump
from gm_ompl.scenario.free_families import free, free_clutter
from gm_ompl.scenario.model import FORMAT
from gm_ompl.scenario.small import Draw, rounded, small

Tree: TypeAlias = dict[str, Any]

GRAVITY = 9.8
FAR = 20.0
"""How far walls and floors reach, in lengths of the object's diagonal."""


def family_yaml(family: str, seed: int) -> str:
    """Return the YAML text of ``random/family/seed``."""
    draw = Draw(family, seed)
    tree = {
        "format": FORMAT,
        "name": f"random/{family}/{seed}",
        "source": f"generated: family {family}, seed {seed}",
        **FAMILIES[family](draw),
    }
    return dump(_scaled(tree, draw))


def _scaled(tree: Tree, draw: Draw) -> Tree:
    """Return the scenario in other units of length and mass, one time in three."""
    if not draw.chance(1 / 3):
        return tree
    length = draw.pick((0.001, 0.01, 100.0, 1000.0))
    mass = draw.pick((0.001, 0.1, 1.0, 100.0))
    factors = {
        "box": length, "min": length, "max": length, "position": length, "by": length,
        "x": length, "y": length, "z": length, "translation": length, "radius": length,
        "regrasp": length,
        "mass": mass, "gravity": length,
        "max_normal_force": mass * length, "z_min": mass * length, "stability": mass * length,
    }  # fmt: skip
    return {key: _times(value, key, factors) for key, value in tree.items()}


def _times(value: Any, key: str, factors: dict[str, float]) -> Any:
    """Return ``value`` with every number multiplied by its key's factor.

    Doubling and halving survive: a height of half a size stays exactly that.
    """
    if isinstance(value, dict):
        return {name: _times(part, name, factors) for name, part in value.items()}
    if isinstance(value, list):
        return [_times(part, key, factors) for part in value]
    if isinstance(value, (int, float)) and key in factors:
        return rounded(value * factors[key], 12)
    return value


def _object(draw: Draw) -> tuple[list[float], float]:
    """Return a box's size and its mass."""
    size = [draw.between(2, 12, 2) for _ in range(3)]
    return size, rounded(10 ** draw.between(-1, 1.5), 2)


def _hand(draw: Draw, size: list[float], mass: float, limits: tuple[float, float]) -> Tree:
    """Return a hand of one to three fingers; limits are relative to the weight."""
    count = draw.pick((1, 2, 2, 2, 2, 3))
    weight = mass * GRAVITY
    radius = rounded(draw.between(0.08, 0.3) * min(size), 2)
    limit = rounded(draw.between(*limits) * weight, 2)
    grid = [draw.whole(3, 9), draw.whole(3, 9)] if count < 3 else [3, 3]
    hand: Tree = {
        "count": count,
        "radius": radius,
        "max_normal_force": limit,
        "placements": {"grid": grid, "faces": "all"},
    }
    if count == 3:  # the number of hands grows with the third power of the placements
        hand["placements"]["faces"] = draw.some(("+x", "-x", "+y", "-y", "+z"), 3)
    if count > 1 and draw.chance(0.25):
        hand["max_normal_force"] = [
            rounded(limit * draw.between(0.4, 1.6), 2) for _ in range(count)
        ]
    if count > 1 and draw.chance(0.15):
        hand["radius"] = [rounded(radius * draw.between(0.7, 1.3), 2) for _ in range(count)]
    return hand


def _settings(draw: Draw, size: list[float], mass: float) -> Tree:
    """Return mechanics and cost; z_min is a few percent of the weight, as in the paper."""
    z_min = rounded(draw.between(0.01, 0.06) * mass * GRAVITY, 2)
    return {
        "mechanics": {"cone_edges": draw.pick((4, 6, 6, 6, 8)), "directions": 76, "z_min": z_min},
        "cost": {
            "regrasp": rounded(draw.between(3, 20) * max(size), 2),
            "stability": rounded(0.02 * z_min, 2),
            "samples_per_arc": draw.pick((1, 2, 3, 3)),
        },
    }


def _friction(draw: Draw) -> Tree:
    return {"environment": draw.between(0.2, 1.2, 2), "finger": draw.between(0.3, 1.2, 2)}


def _wall(size: list[float], side: str, gap: float, height: float | None = None) -> Tree:
    """Return a wall at ``gap`` from the box's side (-x, +x, -y or +y) at its start."""
    far = rounded(FAR * max(size), 2)
    low, high = [-far, -far, 0.0], [far, far, far if height is None else height]
    axis = "xy".index(side[1])
    edge = rounded(size[axis] / 2 + gap, 6)
    if side[0] == "-":
        high[axis] = -edge
    else:
        low[axis] = edge
    return {"box": {"min": low, "max": high}}


def _walls(draw: Draw, size: list[float], sides: tuple[str, ...], often: float) -> Tree:
    """Return walls and low steps on some of the ``sides``."""
    walls = {}
    for side in sides:
        if draw.chance(often):
            gap = rounded(draw.between(0.02, 1.2) * min(size), 2)
            low = draw.chance(0.3)
            height = rounded(draw.between(0.1, 0.6) * size[2], 2) if low else None
            name = f"{'step' if low else 'wall'}_{PLACE[side]}"
            walls[name] = _wall(size, side, gap, height)
    return walls


PLACE = {"-x": "behind", "+x": "ahead", "-y": "right", "+y": "left"}


def _path(draw: Draw, description: str, limits: tuple[float, float], pieces: list[str]) -> Tree:
    """Return a scenario whose path is made of slides and tumbles towards +x."""
    size, mass = _object(draw)
    path: list[Tree] = []
    for piece in pieces:
        if piece == "slide":
            path.append({"slide": {"by": [rounded(draw.between(0.5, 3) * size[0], 2), 0, 0]}})
        else:
            path.append({"tumble": {"towards": "+x", "angle": "90 deg"}})
    fewest, most = 10 // len(pieces) + 1, 60 // len(pieces)
    segments: Any = [draw.whole(fewest, most) for _ in pieces]
    tumbles = "tumble" in pieces
    sides = ("-x", "-y", "+y") if tumbles or draw.chance(0.5) else ("-y", "+y")
    return {
        "description": description,
        "object": {"shape": {"box": size}, "mass": mass},
        "friction": _friction(draw),
        "gravity": GRAVITY,
        "fingers": _hand(draw, size, mass, limits),
        "environment": {"floor": True, "obstacles": _walls(draw, size, sides, 0.4)},
        "motion": {"start": {"position": [0, 0, size[2] / 2]}, "path": path},
        "lattice": {"segments": segments},
        **_settings(draw, size, mass),
    }


def regrasp(draw: Draw) -> Tree:
    """Return a tumble past a wall behind and a wall beside, as in the paper's Fig. 10."""
    tree = _path(draw, "A tumble past a wall behind and one beside.", (0.7, 2.0), ["tumble"])
    size = tree["object"]["shape"]["box"]
    tip = tree["fingers"]["radius"]
    narrow = 1.8 * (min(tip) if isinstance(tip, list) else tip)  # too narrow for a fingertip
    tree["environment"]["obstacles"] = {
        "wall_behind": _wall(size, "-x", rounded(draw.between(0.1, 1) * narrow, 2)),
        "wall_beside": _wall(size, "+y", rounded(draw.between(0.1, 1) * narrow, 2)),
    }
    return tree


def _blocks(
    draw: Draw,
    room: tuple[float, float],
    ends: tuple[list[float], list[float]],
    clear: float,
    height: float,
) -> Tree:
    """Return at most three boxes in the room, farther than ``clear`` from start and goal."""
    blocks: Tree = {}
    for k in range(draw.whole(0, 3)):
        middle = [draw.between(0, room[0]), draw.between(0, room[1])]
        half = [rounded(draw.between(0.1, 0.6) * clear, 2) for _ in "xy"]
        gaps = [
            sum(max(abs(middle[d] - end[d]) - half[d], 0.0) ** 2 for d in (0, 1)) ** 0.5
            for end in ends
        ]
        if min(gaps) > 1.05 * clear:
            low = [rounded(middle[d] - half[d], 4) for d in (0, 1)]
            high = [rounded(middle[d] + half[d], 4) for d in (0, 1)]
            top = rounded(draw.between(0.2, 2) * height, 2)
            blocks[f"block_{k}"] = {"box": {"min": [*low, 0.0], "max": [*high, top]}}
    return blocks


def planar(draw: Draw) -> Tree:
    """Return x, y, yaw motion among a few boxes, start and goal on the lattice."""
    size, mass = _object(draw)
    clear = 0.5 * (size[0] ** 2 + size[1] ** 2) ** 0.5
    step = rounded(draw.between(0.4, 0.8) * min(size[:2]), 2)
    nx, ny, turns = draw.whole(4, 9), draw.whole(3, 7), draw.pick((12, 18, 24))
    degrees = 360 // turns
    goal = [draw.whole(nx // 2, nx), draw.whole(0, ny)]
    ends = ([0.0, 0.0], [goal[0] * step, goal[1] * step])
    obstacles = _blocks(draw, (nx * step, ny * step), ends, clear, size[2])
    height = size[2] / 2
    yaw = degrees * draw.whole(-turns // 4, turns // 4)
    return {
        "description": "Planar motion among boxes.",
        "object": {"shape": {"box": size}, "mass": mass},
        "friction": _friction(draw),
        "gravity": GRAVITY,
        "fingers": _hand(draw, size, mass, (0.6, 2.5)),
        "environment": {"floor": True, "obstacles": obstacles},
        "motion": {
            "planar": {
                "x": [0.0, rounded(nx * step, 6)],
                "y": [0.0, rounded(ny * step, 6)],
                "yaw": ["-180 deg", "180 deg"],
            },
            "start": {"position": [0, 0, height], "yaw": "0 deg"},
            "goal": {
                "position": [rounded(goal[0] * step, 6), rounded(goal[1] * step, 6), height],
                "yaw": f"{yaw} deg",
            },
        },
        "lattice": {"steps": {"x": step, "y": step, "yaw": f"{degrees} deg"}},
        **_settings(draw, size, mass),
    }


def _along(description: str, limits: tuple[float, float], *pieces: str) -> Callable[[Draw], Tree]:
    return lambda draw: _path(draw, description, limits, list(pieces))


FAMILIES: dict[str, Callable[[Draw], Tree]] = {
    "slide": _along("A slide along +x.", (0.6, 2.5), "slide"),
    "push": _along("A slide along +x with weak fingers.", (0.3, 0.6), "slide"),
    "tumble": _along("A tumble towards +x.", (0.6, 2.5), "tumble"),
    "regrasp": regrasp,
    "chain": _along("Slide, tumble, slide.", (0.6, 2.5), "slide", "tumble", "slide"),
    "planar": planar,
    "small": small,
    "free": free,
    "free-clutter": free_clutter,
}
