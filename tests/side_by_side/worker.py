"""A work process: one build's answers to requests, a JSON line each; runs inside that build.

Only what every version of the package has is used here: ``gm_ompl.load``, ``gm_ompl.plan``, and
for decisions by themselves ``KernelBackend`` with the contacts that it is asked about.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import gm_ompl

SMALL = ("lattice.segments=3", "fingers.placements.grid=[2, 2]")
"""Overrides that make a scenario of the paper small, for what is not to be timed."""

Answer = dict[str, Any]


def plan(scenario: str, planner: str = "astar", **limits: Any) -> Answer:
    """Plan, and say what came of it; memos are empty at first, compiled code need not be."""
    loaded = gm_ompl.load(scenario)
    wall, cpu = time.perf_counter(), time.process_time()
    found = gm_ompl.plan(loaded, planner, **limits)
    costs = [entry for entry in found.statistics.history if entry[1] is not None]
    return {
        "wall_s": time.perf_counter() - wall,
        "cpu_s": time.process_time() - cpu,
        "first_plan_s": costs[0][0] if costs else None,
        "status": found.status,
        "cost": found.cost,
        "bound": found.lower_bound,
        "optimal": found.optimal,
        "regrasps": found.regrasps,
    }


def decisions(scenario: str, threshold: bool, count: int = 1000, seed: int = 0) -> Answer:
    """Decide for random placements of the whole hand in random segments and directions."""
    from gm_ompl.feasibility.kernel_backend import KernelBackend

    problem = gm_ompl.load(scenario).problem
    backend = KernelBackend(problem)
    states = _states(problem, backend)
    rng = np.random.default_rng(seed)
    hand = problem.fingers
    shape = (count, hand.count)
    rows = [tuple(row) for row in rng.integers(len(hand.placements), size=shape).tolist()]
    which = [states[k] for k in rng.integers(len(states), size=count).tolist()]
    below = problem.mechanics.z_min if threshold else 0.0
    fingers = tuple(range(hand.count))
    backend.decide(which[0], fingers, rows[0], below)
    backend.forget()
    wall, cpu = time.perf_counter(), time.process_time()
    for state, row in zip(which, rows, strict=True):
        backend.decide(state, fingers, row, below)
    return {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}


def _states(problem: Any, backend: Any) -> list[int]:
    """Return the contact states at the middles of the lattice's edges, both ways, and at rest."""
    from gm_ompl.contact.environment import contact_state, environment_contacts

    lattice, motion, numbers = problem.lattice, problem.motion, []
    for node in range(min(lattice.size, 200)):
        tail = np.array(lattice.coordinates(node))
        for _, head in lattice.neighbours(node):
            q, dq = (tail + head) / 2.0, head - tail
            pose = motion.pose(q)
            touching = environment_contacts(problem.body, problem.environment, pose)
            for twist in (motion.velocity(q, dq), None):
                state = contact_state(touching, pose, twist, problem.body)
                numbers.append(backend.environment(state))
    return numbers


def warm() -> Answer:
    """Load or compile what the other tasks use."""
    for planner in ("astar", "dijkstra", "HybridRRTConnect", "HybridRRTstar"):
        for scenario in ("paper/slide", "paper/regrasp"):
            small = gm_ompl.load(scenario, SMALL)
            gm_ompl.plan(small, planner, max_iterations=20, time_limit=5.0)
    return {}


TASKS: dict[str, Callable[..., Answer]] = {"plan": plan, "decisions": decisions, "warm": warm}


def main() -> None:
    """Answer until the requests end."""
    for line in sys.stdin:
        request = json.loads(line)
        answer = TASKS[request.pop("task")](**request)
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
