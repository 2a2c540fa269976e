"""Comparisons: keys, the store, isolated runs, and that nothing is lost."""

from __future__ import annotations

import os
import signal
import sqlite3
import threading
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import gm_ompl
from gm_ompl.errors import InputError
from gm_ompl.forks import RunLimits
from gm_ompl.study.compare import compare, make_tasks, optima
from gm_ompl.study.store import RunRecord, Store
from gm_ompl.study.task import Task
from gm_ompl.study.workers import LocalExecutor

SMALL = ("lattice.segments=3", "fingers.placements.grid=[2, 2]")
LIMITS = RunLimits(time_s=60.0, max_iterations=3000)
MEASURED = (
    "wall_s", "cpu_s", "peak_mb", "first_plan_s", "first_plan_decisions", "search_s", "history",
)  # fmt: skip
"""What the clock decides; astar reports now and then, so its decisions at the first plan, too."""


def small_tasks(seeds: int = 4, limits: RunLimits = LIMITS) -> tuple[Task, ...]:
    scenarios = [gm_ompl.load(name, SMALL) for name in ("paper/slide", "paper/regrasp")]
    return make_tasks(scenarios, ("astar", "RRT"), seeds, limits)


def what_was_found(records: Sequence[RunRecord]) -> list[RunRecord]:
    nothing: dict[str, Any] = dict.fromkeys(MEASURED)
    return [replace(record, **nothing) for record in records]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunRecord, ...]:
    path = tmp_path_factory.mktemp("undisturbed") / "runs.sqlite"
    with Store(path) as store, closing(LocalExecutor()) as executor:
        return compare(small_tasks(), store, executor)


class Interrupted:
    """Runs here until ``after`` runs have ended, then behaves like Ctrl-C."""

    def __init__(self, after: int) -> None:
        self.after, self.begun = after, 0

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, dict[str, Any]]]:
        self.begun = len(tasks)
        with closing(LocalExecutor()) as executor:
            for done, pair in enumerate(executor.run(tasks)):
                if done == self.after:
                    raise KeyboardInterrupt
                yield pair

    def close(self) -> None:
        pass


def test_a_planner_without_randomness_runs_once() -> None:
    """Further seeds would repeat the same search."""
    tasks = small_tasks(3)
    assert sum(task.planner == "astar" for task in tasks) == 2
    assert sorted(task.seed for task in tasks if task.planner == "RRT") == [0, 0, 1, 1, 2, 2]


def test_keys_are_stable_and_tell_every_difference() -> None:
    """Same run, same key, also through JSON; anything that changes the result changes the key."""
    task, again = small_tasks()[0], small_tasks()[0]
    assert task.key() == again.key() == Task.from_dict(task.to_dict()).key()
    fixed = replace(task, scenario={"name": "a"}, parameters={"b": 1.0})
    # Computed once with this format: a change would make users' stored runs unreachable.
    assert fixed.key("0") == FIXED_KEY
    others = [
        replace(task, scenario={**task.scenario, "name": "other"}),
        replace(task, planner="dijkstra"),
        replace(task, parameters={**task.parameters, "heuristic": "none"}),
        replace(task, seed=1),
        replace(task, limits=replace(LIMITS, time_s=61.0)),
        replace(task, limits=replace(LIMITS, memory_mb=1000.0)),
        replace(task, limits=replace(LIMITS, max_iterations=3001)),
    ]
    keys = {other.key() for other in others} | {task.key(), task.key("another code")}
    assert len(keys) == len(others) + 2


FIXED_KEY = "656993eda27f79fb5ceff04de619fc97"


def test_runs_are_those_of_the_planner(undisturbed: tuple[RunRecord, ...]) -> None:
    """What is recorded is what planning here finds; astar's costs are its optima."""
    tasks = small_tasks()
    assert [record.key for record in undisturbed] == [task.key() for task in tasks]
    for record, task in list(zip(undisturbed, tasks, strict=True))[:3]:
        scenario = gm_ompl.load(task.scenario_name, SMALL)
        plan = gm_ompl.plan(scenario, task.planner, seed=task.seed, max_iterations=3000)
        assert (record.status, record.optimal) == (plan.status, plan.optimal)
        assert record.cost == pytest.approx(plan.cost, rel=1e-12)
        assert record.regrasps == plan.regrasps
    best = optima(undisturbed)
    for record in undisturbed:
        if record.cost is not None:
            assert record.peak_mb > 10 and record.least_z is not None
            if record.planner == "astar":
                assert record.optimal and record.cost == best[record.scenario_key]


def test_a_resumed_comparison_equals_an_undisturbed_one(
    undisturbed: tuple[RunRecord, ...], tmp_path: Path
) -> None:
    """After an interruption, what was finished is not made again and the rest is the same."""
    tasks, first, second = small_tasks(), Interrupted(3), Interrupted(1000)
    with Store(tmp_path / "runs.sqlite") as store:
        with pytest.raises(KeyboardInterrupt):
            compare(tasks, store, first)
        stored = store.all()
    assert len(stored) == 3
    with Store(tmp_path / "runs.sqlite") as store:
        records = compare(tasks, store, second)
        assert second.begun == len(tasks) - 3
        assert store.all()[:3] == stored
        third = Interrupted(1000)
        assert compare(tasks, store, third) == records
        assert third.begun == 0
    assert what_was_found(records) == what_was_found(undisturbed)


def test_killed_workers_lose_only_their_run(
    undisturbed: tuple[RunRecord, ...], tmp_path: Path
) -> None:
    """With runs killed at random, and once the server, the results are the same, each once."""
    executor, killed, over = LocalExecutor(), [0, 0], threading.Event()

    def kill() -> None:
        while not over.wait(0.005):
            running = executor.server
            if running is None:
                continue
            children = _children(running.pid)
            if children and killed[0] < 2:
                killed[0] += _killed(children[0])
            elif children and killed[1] < 1:
                killed[1] += _killed(running.pid)

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        with Store(tmp_path / "runs.sqlite") as store:
            records = compare(small_tasks(), store, executor)
            assert len(store.all()) == len(records)
    finally:
        executor.close()
        over.set()
        killer.join()
    assert killed == [2, 1]
    assert what_was_found(records) == what_was_found(undisturbed)


def _children(pid: int) -> list[int]:
    try:
        text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    except OSError:
        return []
    return [int(word) for word in text.split()]


def _killed(pid: int) -> int:
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return 0
    return 1


def test_the_server_is_kept_warm_between_calls() -> None:
    """A second call has the first one's server; after an interruption there is another."""
    tasks = small_tasks(1)
    with closing(LocalExecutor()) as executor:
        assert len(list(executor.run(tasks[:1]))) == 1
        kept = executor.server
        assert kept is not None
        assert len(list(executor.run(tasks))) == len(tasks)
        assert executor.server is kept
        running = executor.run(tasks)
        next(running)
        running.close()  # type: ignore[attr-defined]
        assert executor.server is None and kept.poll() is not None


def test_a_strange_file_is_no_store(tmp_path: Path) -> None:
    """A file that is no database, or one of other columns, is refused by name."""
    (tmp_path / "text").write_text("no database, but long enough to be taken for one" * 30)
    with pytest.raises(InputError, match="text"):
        Store(tmp_path / "text")
    with sqlite3.connect(tmp_path / "old") as old:
        old.execute("CREATE TABLE runs (key TEXT)")
    old.close()
    with pytest.raises(InputError, match="another version"):
        Store(tmp_path / "old")


def test_wrong_requests_are_refused() -> None:
    """Unknown planners and parameters, no seeds, and the same name twice."""
    scenario = gm_ompl.load("paper/slide", SMALL)
    for planners, seeds, parameters in (
        (["nonsense"], 1, {}),
        (["astar"], 0, {}),
        (["astar", "astar"], 1, {}),
        ([], 1, {}),
        (["astar"], 1, {"astar": {"nonsense": 1}}),
    ):
        with pytest.raises(InputError):
            make_tasks([scenario], planners, seeds, LIMITS, parameters)
    with pytest.raises(InputError, match="paper/slide"):
        make_tasks([scenario, scenario], ["astar"], 1, LIMITS)


def test_every_planner_is_compared_on_free_motion() -> None:
    """A scenario of free motion beside one of a path: no planner is refused."""
    scenarios = [gm_ompl.load(name) for name in ("free/around", "paper/slide")]
    assert len(make_tasks(scenarios, ("astar", "KPIECE1", "RRT", "HybridRRT"), 3, LIMITS)) == 20
