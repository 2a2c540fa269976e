"""One search in a process of its own: time, memory and what it did.

``python -m gm_ompl.study.measure '{"scenario": "paper/slide"}'`` prints the measurement as JSON.
"""

from __future__ import annotations

import dataclasses
import json
import resource
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gm_ompl import api


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
        seconds: wall time of the search.
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
        plan = api.plan(
            scenario,
            time_limit=task.get("time_limit"),
            parameters={"heuristic": task.get("heuristic", "lanes")},
        )
    return Measurement(
        status=plan.status,
        optimal=plan.optimal,
        cost=plan.cost,
        regrasps=plan.regrasps,
        expanded=plan.statistics.expanded,
        decisions=plan.statistics.mode_decisions,
        seconds=plan.statistics.time_s,
        megabytes=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        nodes=graph_nodes(scenario.problem.fingers.groups(), scenario),
    )


def graph_nodes(groups: Sequence[Sequence[int]], scenario: api.Scenario) -> int:
    """Return the number of potential nodes: unordered sets of placements times lattice nodes."""
    placements = len(scenario.problem.fingers.placements)
    sets = 1
    for group in groups:
        for k in range(len(group)):
            sets = sets * (placements - k) // (k + 1)
    return sets * scenario.problem.lattice.size


if __name__ == "__main__":
    sys.stdout.write(json.dumps(dataclasses.asdict(measured(json.loads(sys.argv[1])))) + "\n")
