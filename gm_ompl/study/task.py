"""One run of a comparison: what is planned, by what, under which key, and what it finds."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import gm_ompl
from gm_ompl import limits
from gm_ompl.forks import RunLimits
from gm_ompl.planners.planner import Progress
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.tolerance.measure import common_factor

Json: TypeAlias = dict[str, Any]

WITHOUT_INFLUENCE = ("app", "exploring", "study")
"""Packages whose sources do not change what a run finds, but for what it records of itself."""


@dataclass(frozen=True, eq=False)
class Task:
    """One run."""

    scenario: Json  # as resolved
    planner: str  # its name
    parameters: Json  # the value of every parameter of the planner
    seed: int  # of the run
    limits: RunLimits  # what it may spend
    tolerance: bool = False  # whether to find what its plan tolerates, beyond those limits

    @property
    def scenario_name(self) -> str:
        """The scenario's name."""
        return str(self.scenario["name"])

    @property
    def scenario_key(self) -> str:
        """A hash of the resolved scenario."""
        return _hash(self.scenario)

    def key(self, code: str | None = None) -> str:
        """Return a hash of everything that decides what the run finds, the code included."""
        return _hash({**self.to_dict(), "code": code or code_version()})

    def to_dict(self) -> Json:
        """Return the task as plain values."""
        return asdict(self)

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any]) -> Task:
        """Return the task that ``to_dict`` wrote."""
        return cls(**{**tree, "limits": RunLimits(**tree["limits"])})


def _hash(tree: Any) -> str:
    text = json.dumps(tree, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@cache
def code_version() -> str:
    """Return the package's version and a hash of the sources that plan."""
    digest = hashlib.sha256()
    package = Path(__file__).resolve().parents[1]
    for source in sorted(package.rglob("*.py")):
        place = source.relative_to(package)
        if place.parts[0] not in WITHOUT_INFLUENCE or place.name == "task.py":
            digest.update(f"{place.as_posix()}\0".encode() + source.read_bytes())
    return f"{gm_ompl.__version__}+{digest.hexdigest()[:12]}"


def carry_out(task: Task) -> dict[str, Any]:
    """Plan as ``task`` says and return what a record keeps of the plan.

    Raises:
        InputError: the planner cannot treat the scenario.
    """
    asked = task.limits
    # The search has all of its time, whatever loading takes.
    with limits.holding(asked.time_s, asked.memory_mb):
        scenario = Scenario.from_resolved(task.scenario)
    first: list[Progress] = []

    def watch(progress: Progress) -> None:
        if progress.cost is not None and not first:
            first.append(progress)

    plan = gm_ompl.plan(
        scenario, task.planner, time_limit=asked.time_s, max_iterations=asked.max_iterations,
        memory_limit=asked.memory_mb, seed=task.seed, parameters=task.parameters, report=watch,
    )  # fmt: skip
    spent = plan.statistics
    times = [time for time, cost, _ in spent.history if cost is not None]
    decided = first[0].mode_decisions if first else spent.mode_decisions
    tolerance = None
    if task.tolerance and plan.steps:
        tolerance = common_factor(plan, scenario.problem)
    same = ("status", "cost", "optimal", "lower_bound", "regrasps", "least_z")
    return {
        **{name: getattr(plan, name) for name in same},
        "first_plan_s": None if plan.cost is None else [*times, spent.time_s][0],
        "tolerance": tolerance,
        "search_s": spent.time_s,
        "mode_decisions": spent.mode_decisions,
        "first_plan_decisions": None if plan.cost is None else decided,
        "states": _states(scenario.problem),
        "iterations": spent.expanded,
        "history": [list(entry) for entry in spent.history],
    }


def _states(problem: Problem) -> float | None:
    """Return nodes times one placement for each finger; None where nodes are made on demand."""
    if not problem.lattice.axes:
        return None
    fingers = problem.fingers
    return float(problem.lattice.size) * float(len(fingers.placements)) ** fingers.count
