"""A small plan with a regrasp, put together by hand, for the check to judge."""

from __future__ import annotations

import itertools
import json
from typing import Any

import numpy as np
import pytest

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.environment import contact_state, environment_contacts
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Displacement, Move, Placements, Problem, Regrasp
from gm_ompl.reference.modes import decide_modes
from gm_ompl.scenario.scenario import Scenario
from tests.airborne import airborne

SCENARIO = {
    "format": "gm-ompl-scenario/1",
    "name": "test/slide",
    "object": {"shape": {"box": [5, 10, 5]}, "mass": 1},
    "friction": {"environment": 0.5, "finger": 0.7},
    "gravity": 9.8,
    "fingers": {
        "count": 2,
        "radius": 1,
        "max_normal_force": 10,
        "placements": {"grid": [5, 5], "faces": ["+x", "-x", "+y", "+z"]},
    },
    "environment": {
        "floor": True,
        "obstacles": {"wall": {"box": {"min": [-20, 7.6, 0], "max": [30, 8.6, 20]}}},
    },
    "motion": {
        "start": {"position": [0, 0, 2.5]},
        "path": [{"slide": {"by": [4, 0, 0]}}, {"slide": {"by": [0, -2, 0]}}],
    },
    "lattice": {"segments": [2, 1]},
    "mechanics": {"cone_edges": 4, "z_min": 0.2},
}
"""Two pieces: along x, then along y; the wall stands clear of the object, and a fingertip passes
between."""


class Author:
    """Writes plans without any planner: decisions from the reference, costs from Eq. (9)."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.problem = scenario, scenario.problem

    def row(self, face: str, i: int, j: int) -> int:
        """Return a row of the placement table."""
        row = self.problem.fingers.placements.find(face, (i, j))
        assert row is not None
        return row

    def decide(
        self, q: Coordinates, direction: Coordinates | None, fingers: Placements, rows: Placements
    ) -> ModeDecision:
        """Return the best modes at ``q``."""
        problem = self.problem
        pose = problem.motion.pose(q)
        twist = None if direction is None else problem.motion.velocity(q, direction)
        touching = environment_contacts(problem.body, problem.environment, pose)
        state = contact_state(touching, pose, twist, problem.body)
        decision = decide_modes(problem.instant(state, fingers, rows))
        assert decision.z >= problem.mechanics.z_min
        return decision

    def slide(self, start: float, end: float, rows: Placements) -> Displacement:
        """Return the arc from ``start`` to ``end`` with fingers at ``rows``."""
        problem, parts = self.problem, self.problem.cost.samples_per_arc
        cuts = np.linspace(start, end, parts + 1)
        decisions = tuple(
            self.decide(((a + b) / 2,), (end - start,), tuple(range(len(rows))), rows)
            for a, b in itertools.pairwise(cuts)
        )
        # Both pieces are slides: every fingertip goes as far as the centre of mass.
        places = [problem.motion.pose((s,)).position for s in cuts]
        lengths = [float(np.linalg.norm(b - a)) for a, b in itertools.pairwise(places)]
        cost = sum(
            (1 + problem.cost.stability / d.z) * length
            for d, length in zip(decisions, lengths, strict=True)
        )
        arc = problem.motion.arc((start,), (end,))
        return Displacement(arc, (start,), (end,), rows, decisions, cost)

    def regrasp(self, at: float, finger: int, target: int, rows: Placements) -> Regrasp:
        """Return the arc that moves ``finger`` to ``target``."""
        rest = tuple(i for i in range(len(rows)) if i != finger)
        decision = self.decide((at,), None, rest, tuple(rows[i] for i in rest))
        pose = self.problem.motion.pose((at,))
        return Regrasp(pose, (at,), finger, target, rows, decision, self.problem.cost.regrasp)

    def plan(self, moves: list[Move]) -> Plan:
        """Return the plan that ``moves`` make."""
        return assemble(
            self.problem,
            self.scenario.resolved(),
            airborne(self.problem, moves),
            status="solved",
            planner="by hand",
            statistics={"time_s": 0.5, "expanded": 4, "mode_decisions": 4, "history": []},
            seed=7,
            lower_bound=5.0,
        )


def _regrasping_plan(author: Author) -> Plan:
    push, top, other = author.row("-x", 2, 2), author.row("+z", 2, 2), author.row("+y", 2, 2)
    return author.plan(
        [
            author.slide(0.0, 0.25, (top, push)),
            author.slide(0.25, 0.5, (top, push)),
            author.regrasp(0.5, 1, other, (top, push)),
            author.slide(0.5, 1.0, (top, other)),
        ]
    )


@pytest.fixture(scope="session")
def author() -> Author:
    """Writes plans for the small scenario."""
    return Author(Scenario.from_resolved(SCENARIO))


@pytest.fixture(scope="session")
def hand_plan(author: Author) -> Plan:
    """Two arcs along x, a regrasp between the pieces, one arc along y."""
    return _regrasping_plan(author)


@pytest.fixture
def draft(hand_plan: Plan) -> Any:
    """The plan as plain values, to be tampered with."""
    return json.loads(json.dumps(hand_plan.to_dict()))


@pytest.fixture(scope="session")
def problem(author: Author) -> Problem:
    """The small scenario's problem."""
    return author.problem
