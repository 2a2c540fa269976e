"""The load measurement: its shares add up."""

from __future__ import annotations

from docs.tables.load import lines, measure
from gm_ompl.study.store import RunRecord
from gm_ompl.study.workers import LocalExecutor


def test_shares_are_those_of_the_workers_time() -> None:
    """Two workers for ten seconds have twenty to spend; 18 in hand of which 17 searching."""
    run = RunRecord(
        key="", scenario="", scenario_key="", planner="", parameters={}, seed=0, time_limit=None,
        memory_limit=None, max_iterations=None, code="", status="budget",
        search_s=17.0, wall_s=18.0, cpu_s=16.0,
    )  # fmt: skip
    told = "\n".join(lines([run], 10.0, 20.0, 2))
    for share in ("hand 90.0%", "run 80.0%", "time: 10.0%", "time: 20.0%", "spent 5.6%"):
        assert share in told


def test_runs_search_for_their_time() -> None:
    """A measured comparison's searches fill their time, and fit into what passed.

    What `plan` does before it searches counts as well: some milliseconds.
    """
    records, elapsed, spent = measure("random/small/4", 3, 0.2, LocalExecutor(1))
    searched = sum(record.search_s or 0.0 for record in records)
    assert len(records) == 3 and searched >= 0.9 * 3 * 0.2
    assert searched <= sum(record.wall_s for record in records) <= elapsed
    assert 0.0 < sum(record.cpu_s for record in records) < spent
