"""What would help, tried out: nothing is suggested that was not judged again."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from gm_ompl.explain.instants import Explainer
from gm_ompl.explain.lanes import whole_lane
from gm_ompl.explain.regions import whole_region
from gm_ompl.explain.values import Remedy, SetLine
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.planners.planner import Budget, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Placements, Problem
from gm_ompl.scenario.scenario import Scenario

STRONGER = (1.5, 3.0)
"""Factors on every f_max."""
WEAKER = (0.5, 0.1)
"""Factors on z_min."""


def set_line(problem: Problem, placements: Placements) -> SetLine:
    """Return the line of one set of placements, judged from scratch."""
    explainer = Explainer(problem, Judge(problem, make_backend(problem)))
    whole = whole_lane if problem.motion.dimension == 1 else whole_region
    return whole(explainer, placements)


def for_placements(problem: Problem, placements: Placements, line: SetLine) -> Iterator[Remedy]:
    """Yield what was tried to let these placements hold from start to goal.

    Where geometry blocks them neither strength nor a smaller z_min can help: nothing is tried.
    """
    findings = {part.finding for part in line.stretches}
    findings |= {end.finding for end in (line.forward, line.backward) if end is not None}
    if Finding.GEOMETRY in findings:
        return
    for factor in STRONGER:
        limits = problem.fingers.max_normal_force * factor
        hand = dataclasses.replace(problem.fingers, max_normal_force=limits)
        after = set_line(dataclasses.replace(problem, fingers=hand), placements)
        yield _judged(f"fingers.max_normal_force={_numbers(limits)}", after)
        if after.holds:
            break
    if line.ratio is not None and 0.0 < line.ratio < 1.0:
        z_min = _rounded_down(line.ratio * problem.mechanics.z_min)
        settings = dataclasses.replace(problem.mechanics, z_min=z_min)
        after = set_line(dataclasses.replace(problem, mechanics=settings), placements)
        yield _judged(f"mechanics.z_min={z_min:g}", after)


def _judged(change: str, after: SetLine) -> Remedy:
    if after.holds:
        return Remedy(change, True, "judged again: these placements then hold from start to goal")
    assert after.forward is not None or after.nodes_from_start is not None
    why = "the goal is not reached" if after.forward is None else after.forward.finding.value
    return Remedy(change, False, f"judged again: {why}")


def for_scenario(scenario: Scenario, seconds: float) -> Iterator[Remedy]:
    """Yield what was tried to let the scenario have a plan, each by a search of limited time."""
    problem, settled = scenario.problem, set[str]()
    for key, change, value in _changes(problem):
        if key in settled:
            continue
        tree = copy.deepcopy(scenario.resolved())
        at: Any = tree
        *parents, last = key.split(".")
        for parent in parents:
            at = at[parent]
        at[last] = value
        changed = Scenario.from_resolved(tree).problem
        judge = Judge(changed, make_backend(changed))
        budget = Budget(time_limit=seconds)
        result = make_planner("astar").solve(changed, judge, budget, np.random.default_rng(0))
        helps = result.status is Status.SOLVED
        if helps:
            settled.add(key)
        yield Remedy(change, helps, f"planned again: {result.status.sentence}")


def _changes(problem: Problem) -> Iterator[tuple[str, str, Any]]:
    """Yield (key, the change as for --set, value), mild changes first."""
    for factor in STRONGER:
        limits = (problem.fingers.max_normal_force * factor).tolist()
        key = "fingers.max_normal_force"
        yield key, f"{key}={_numbers(limits)}", limits
    for factor in WEAKER:
        z_min = problem.mechanics.z_min * factor
        yield "mechanics.z_min", f"mechanics.z_min={z_min:g}", z_min
    table = problem.fingers.placements
    if len(np.unique(table.face)) < len(_all_faces(problem)):
        key = "fingers.placements.faces"
        yield key, f"{key}=all", "all"


def _all_faces(problem: Problem) -> list[int]:
    return [f for piece in problem.body.pieces for f in range(len(piece.face_offsets))]


def _numbers(values: Any) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"


def _rounded_down(value: float) -> float:
    """Return ``value`` with two digits, not larger."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / unit * (1 + 1e-12)) * unit:.12g}")
