"""One search in a process of its own: time, memory and what it did.

``python -m gm_ompl.study.measure '{"scenario": "paper/slide"}'`` prints the measurement as JSON.
"""

from __future__ import annotations

import dataclasses
import json
import math
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gm_ompl import api
from gm_ompl.problem import Problem


@dataclass(frozen=True)
class Measurement:
    """What one search cost.

    Attributes:
        status: how it ended.
        optimal: whether it proved its plan optimal.
        cost: of the plan.
        regrasps: in the plan.
        expanded: nodes (or lanes) expanded.
        decisions: mode decisions computed.
        seconds: CPU time of ``plan``, everything included.
        megabytes: peak resident memory of its process [MiB].
        nodes: of the manipulation-feasibility graph as the paper counts them.
    """

    status: str
    optimal: bool
    cost: float | None
    regrasps: int | None
    expanded: int
    decisions: int
    seconds: float
    megabytes: float
    nodes: int


def measure(
    scenario: str,
    heuristic: str = "lanes",
    overrides: Sequence[str] = (),
    time_limit: float | None = None,
    repeat: bool = True,
) -> Measurement:
    """Measure ``astar`` in a new process.

    Args:
        scenario: a shipped name, or a file.
        heuristic: the planner's parameter.
        overrides: "KEY=VALUE" changes of the scenario.
        time_limit: of the search [s].
        repeat: whether to solve twice and count the second time, compiled code being loaded.
    """
    task = {
        "scenario": scenario,
        "heuristic": heuristic,
        "overrides": list(overrides),
        "time_limit": time_limit,
        "repeat": repeat,
    }
    command = [sys.executable, "-m", "gm_ompl.study.measure", json.dumps(task)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return Measurement(**json.loads(done.stdout))


def measured(task: dict[str, Any]) -> Measurement:
    """Return the measurement of a task, made in this process."""
    scenario = api.load(task["scenario"], task.get("overrides", ()))
    for _ in range(2 if task.get("repeat", True) else 1):
        started = time.process_time()
        plan = api.plan(
            scenario,
            time_limit=task.get("time_limit"),
            parameters={"heuristic": task.get("heuristic", "lanes")},
        )
        seconds = time.process_time() - started
    return Measurement(
        status=plan.status,
        optimal=plan.optimal,
        cost=plan.cost,
        regrasps=plan.regrasps,
        expanded=plan.statistics.expanded,
        decisions=plan.statistics.mode_decisions,
        seconds=seconds,
        megabytes=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        nodes=graph_nodes(scenario.problem),
    )


def graph_nodes(problem: Problem) -> int:
    """Return the number of potential nodes: unordered sets of placements times lattice nodes."""
    placements = len(problem.fingers.placements)
    groups = problem.fingers.groups()
    return math.prod(math.comb(placements, len(group)) for group in groups) * problem.lattice.size


if __name__ == "__main__":
    sys.stdout.write(json.dumps(dataclasses.asdict(measured(json.loads(sys.argv[1])))) + "\n")
