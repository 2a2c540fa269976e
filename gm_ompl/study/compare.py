"""Planners x scenarios x seeds: the runs of a comparison, made or taken from the store."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from gm_ompl.errors import InputError
from gm_ompl.forks import RunLimits
from gm_ompl.planners.registry import make_planner
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.study.store import RunRecord, Store
from gm_ompl.study.task import Task, code_version
from gm_ompl.study.workers import Executor

EXACT = "astar"  # the planner whose proven optimum costs are compared with
Watch: TypeAlias = Callable[[int, int], None]  # called with (runs done, runs in all)


def make_tasks(
    scenarios: Sequence[Scenario],
    planners: Sequence[str],
    seeds: int,
    limits: RunLimits,
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
    *,
    tolerance: bool = False,
) -> tuple[Task, ...]:
    """Return the runs of a comparison, a seed at a time.

    Args:
        scenarios: what is planned; no two with the same name.
        planners: names.
        seeds: runs per scenario and planner, with the seeds 0, 1, ...; a planner that is not
            randomised runs once.
        limits: of each run.
        parameters: by planner; defaults for the rest.
        tolerance: whether to find what plans tolerate.

    Raises:
        InputError: a planner, a parameter or a number is wrong, or two scenarios share a name.
    """
    if seeds < 1:
        raise InputError(f"seeds: {seeds}: must be a whole number >= 1")
    names = [scenario.name for scenario in scenarios]
    for kind, given in (("scenario", names), ("planner", list(planners))):
        twice = sorted({name for name in given if given.count(name) > 1})
        if twice or not given:
            raise InputError(f"{kind}s: {', '.join(twice) or 'none'}: name each {kind} once")
    made = [make_planner(name, (parameters or {}).get(name)) for name in planners]
    trees = [scenario.resolved() for scenario in scenarios]
    return tuple(
        Task(tree, planner.name, dict(planner.settings), seed, limits, tolerance)
        for seed in range(seeds)
        for tree in trees
        for planner in made
        if seed == 0 or planner.specs.randomised
    )


def compare(
    tasks: Sequence[Task], store: Store, executor: Executor, watch: Watch | None = None
) -> tuple[RunRecord, ...]:
    """Make the runs that the store does not hold yet, each stored when it ends.

    Returns:
        The runs of all tasks, in the tasks' order.
    """
    keys = [task.key() for task in tasks]
    key_of = dict(zip(map(id, tasks), keys, strict=True))
    held = store.get(keys)
    missing = [task for task, key in zip(tasks, keys, strict=True) if key not in held]
    done = len(tasks) - len(missing)
    if watch is not None:
        watch(done, len(tasks))
    for task, outcome in executor.run(missing) if missing else ():
        store.add(_record(key_of[id(task)], task, outcome))
        done += 1
        if watch is not None:
            watch(done, len(tasks))
    found = store.get(keys)
    return tuple(found[key] for key in keys)


def _record(key: str, task: Task, outcome: Mapping[str, Any]) -> RunRecord:
    return RunRecord(
        key=key,
        scenario=task.scenario_name,
        scenario_key=task.scenario_key,
        planner=task.planner,
        parameters=task.parameters,
        seed=task.seed,
        time_limit=task.limits.time_s,
        memory_limit=task.limits.memory_mb,
        max_iterations=task.limits.max_iterations,
        code=code_version(),
        **outcome,
    )


def optima(records: Sequence[RunRecord]) -> dict[str, float]:
    """Return the proven optimal cost per scenario key, where ``astar`` has one."""
    return {
        record.scenario_key: record.cost
        for record in records
        if record.planner == EXACT and record.optimal and record.cost is not None
    }
