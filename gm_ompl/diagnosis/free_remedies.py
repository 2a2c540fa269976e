"""What may be opened in free motion: its axes, region, depth and goal. Each is tried by itself."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from typing import Any

from gm_ompl.contact.deeds import AXES
from gm_ompl.diagnosis.free_values import Explored
from gm_ompl.diagnosis.remedies import SHORTEST, search
from gm_ompl.diagnosis.values import Remedy
from gm_ompl.errors import ScenarioError
from gm_ompl.limits import Limits
from gm_ompl.planners.planner import Status
from gm_ompl.scenario.scenario import Scenario

MOST = 10.0
"""What a search with one change may take at most [s]."""

FIRST = 0.5
"""What the first change tried may take of the time: it is the likeliest to help."""


def of_motion(scenario: Scenario, alone: Explored, deadline: Limits) -> Iterator[Remedy]:
    """Yield what was tried to let the object get farther, by searches of limited time.

    Args:
        scenario: it has no plan, or none was found.
        alone: what the object reaches on geometry alone.
        deadline: of all that is tried.
    """
    every = list(_changes(scenario, alone))
    for k, (key, value, shown) in enumerate(every):
        if deadline.left() < SHORTEST:
            return
        share = deadline.part(max(FIRST if k == 0 else 0.0, 1.0 / (len(every) - k)), MOST)
        yield from _tried(scenario, key, value, shown, share)


def _changes(scenario: Scenario, alone: Explored) -> Iterator[tuple[str, Any, str]]:
    """Yield keys, what is to be there, and how that is written."""
    tree = scenario.resolved()
    motion, free = tree["motion"], tree["motion"]["free"]
    if not alone.arrived:
        within = _within(scenario, alone)
        degrees = math.degrees(float(str(within["rotation"]).split()[0]))
        shown = f"{{position: {within['position']:g}, rotation: {degrees:.6g} deg}}"
        if within != motion["goal"].get("within"):
            yield "motion.goal.within", within, shown
    depth = tree["lattice"].get("depth")
    if depth is not None:
        yield "lattice.depth", 2 * depth, str(2 * depth)
    if free.get("rotate", "any") != "any":
        yield "motion.free.rotate", "any", "any"
    if len(free["translate"]) < len(AXES):
        yield "motion.free.translate", list(AXES), f"[{', '.join(AXES)}]"
    if alone.borders:
        region = _wider(free["region"], alone, scenario.problem.body.diagonal)
        ranges = ", ".join(f"{key}: [{low:g}, {high:g}]" for key, (low, high) in region.items())
        yield "motion.free.region", region, f"{{{ranges}}}"


def _within(scenario: Scenario, alone: Explored) -> dict[str, Any]:
    """Return tolerances of the goal that the nearest pose meets."""
    given = scenario.resolved()["motion"]["goal"]["within"]
    position = max(float(given["position"]), _up(alone.nearest.distance))
    angle = max(float(str(given["rotation"]).split()[0]), _up(math.radians(alone.nearest.angle)))
    return {"position": position, "rotation": f"{angle!r} rad"}


def _up(value: float) -> float:
    """Return a number of three digits that is no smaller."""
    return float(f"{1.006 * value:.3g}")


def _wider(region: dict[str, Any], alone: Explored, by: float) -> dict[str, Any]:
    """Return the region, wider by twice the object's size where poses come near its borders."""
    wider = {key: list(ends) for key, ends in region.items()}
    for border in alone.borders:
        key, value = border.split(" = ")
        low, high = wider[key]
        end = 0 if abs(float(value) - low) <= abs(float(value) - high) else 1
        wider[key][end] = float(f"{wider[key][end] + (2 * end - 1) * 2.0 * by:.4g}")
    return wider


def _tried(scenario: Scenario, key: str, value: Any, shown: str, share: Limits) -> Iterator[Remedy]:
    tree = copy.deepcopy(scenario.resolved())
    place = tree
    *path, last = key.split(".")
    for part in path:
        place = place[part]
    place[last] = value
    try:
        changed = Scenario.from_resolved(tree).problem
    except ScenarioError:  # a rotation that does not divide 360 deg, and the like
        return
    status = search(changed, share.left())
    evidence = {
        Status.SOLVED: "a plan exists with it",
        Status.INFEASIBLE: "none with it, which is proven",
    }.get(status, "not settled in the time")
    yield Remedy(f"{key}={shown}", status is Status.SOLVED, evidence)
