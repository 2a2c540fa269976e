"""The load measurement: its shares add up."""

from __future__ import annotations

from docs.tables.load import Load, measure


def test_shares_are_those_of_the_workers_time() -> None:
    """Two workers for ten seconds have twenty to spend; 18 in hand of which 17 searching."""
    load = Load(17, 2, 10.0, 17.0, 18.0, 16.0, 4.0)
    told = "\n".join(load.lines())
    for share in ("hand 90.0%", "run 80.0%", "time: 10.0%", "time: 20.0%", "spent 5.6%"):
        assert share in told


def test_runs_search_for_their_time() -> None:
    """A measured comparison's searches fill at least the asked time, and fit into what passed."""
    load = measure("random/small/4", 3, 0.2, 1)
    assert load.runs == 3 and load.search_s >= 3 * 0.2
    assert load.search_s <= load.in_hand_s <= load.elapsed_s
    assert load.runs_cpu_s > 0.0 and load.others_cpu_s > 0.0
    assert any("3 runs on 1 workers" in line for line in load.lines())
