"""Placements on no grid, which plans of scenarios with continuous placements name."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from gm_ompl.geometry.patches import loose, patches
from gm_ompl.planfile.model import DisplacementStep, PlacementRecord, Plan
from gm_ompl.problem import Problem

FLAT = 1e-9
"""How far off its face's plane a point may be, over D."""


def with_points(problem: Problem, plan: Plan) -> Problem:
    """Return the problem with the points in its hand's table that a plan names and that it offers.

    A point is offered on a face that fingers may be placed on, at least the margin from its rim.
    """
    where = problem.fingers.anywhere
    wanted = dict.fromkeys(r.spot for r in _records(plan) if r.cell is None)
    if where is None or not wanted:
        return problem
    table, diagonal = problem.fingers.placements, problem.body.diagonal
    found = patches(problem.body, where.faces, where.margin)
    numbers = {table.labels[patch.number]: f for f, patch in enumerate(found)}
    which, points = [], []
    for face, point in wanted:
        spot = np.array([point])
        f = numbers.get(face, -1)
        if f >= 0 and abs(found[f].height(spot)[0]) <= FLAT * diagonal and found[f].offers(spot)[0]:
            which.append(f)
            points.append(point)
    if not points:
        return problem
    table = table.joined(loose(found, which, np.array(points), table.labels))
    return dataclasses.replace(
        problem, fingers=dataclasses.replace(problem.fingers, placements=table)
    )


def _records(plan: Plan) -> Iterator[PlacementRecord]:
    """Yield every placement that the steps name."""
    for step in plan.steps:
        yield from step.placements
        if not isinstance(step, DisplacementStep):
            yield from (step.from_, step.to)
