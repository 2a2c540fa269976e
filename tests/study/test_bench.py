"""The bench: it measures what it says, on a scenario small enough for a test."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gm_ompl.app.study_verbs import BenchVerb
from gm_ompl.app.studying import bench_command, lines
from gm_ompl.errors import InputError
from gm_ompl.scenario.load import load
from gm_ompl.study.bench import bench, decisions_per_node
from gm_ompl.study.bench_decisions import searched, spread, timed

SMALL = ("lattice.segments=3", "fingers.placements.grid=[2, 2]")


@pytest.fixture(scope="module")
def found() -> dict[str, object]:
    return bench(("paper/tumble",), SMALL, repeat=1, highs=2, search_limit=5.0)


def test_every_figure_is_there(found: dict[str, object]) -> None:
    """Decisions per search and in all, the plan, start-up: plain JSON of positive numbers."""
    again = json.loads(json.dumps(found, allow_nan=False))
    assert [row["search"] for row in again["decisions"]] == ["astar", "dijkstra"] * 2
    for row in again["decisions"]:
        assert 0 < row["kernel_median_ms"] <= row["kernel_p95_ms"]
        assert row["ratio"] > 1 and row["ratio_whole"] > 1
    (plan,) = again["plans"]
    assert plan["optimal"] and plan["plain_is_whole"]
    assert plan["ratio"] == pytest.approx(plan["plain_s"] / plan["seconds"])
    assert sum(plan["profile"].values()) == pytest.approx(1.0)
    assert plan["peak_mb"] > 10
    assert 0 < again["start"]["help_s"] < again["start"]["first_plan_s"]


def test_people_see_the_same(found: dict[str, object]) -> None:
    """The tables name every search and scenario."""
    text = "\n".join(lines(found))
    assert text.count("| paper/tumble |") == 4
    assert text.count("| all |") == 2


def test_decisions_are_those_of_the_search() -> None:
    """Each decision of the whole hand comes once; the kernel and HiGHS are asked the same."""
    problem = load("paper/tumble", SMALL).problem
    search = searched(problem, "dijkstra", 5.0)
    assert search.result.optimal
    assert len(set(search.asked)) == len(search.asked) > 10
    assert all(len(placements) == 2 for _, _, placements in search.asked)
    times = timed(search, 15, 3, 2)
    assert len(times["kernel"]) == 15
    assert {len(times[way]) for way in ("sample", "highs", "whole")} == {3}
    assert spread(range(10), 3) == [0, 4, 9]


def test_the_plain_search_is_counted_arc_by_arc() -> None:
    """One placement per face of a block that slides alone: counted by hand on all nodes."""
    problem = load(
        "paper/slide",
        ["fingers.placements.grid=[1, 1]", "fingers.count=1", "lattice.segments=4"],
    ).problem
    # 5 places are free (not below); inner nodes have two neighbours, the ends one: 8 / 5.
    regrasps, displacements = 4, 3 * 8 / 5
    assert decisions_per_node(problem) == pytest.approx(regrasps + displacements, rel=0.05)


def test_a_problem_without_valid_nodes_counts_nothing() -> None:
    """Where no placement is free there is nothing to expand."""
    problem = load("paper/slide", ["fingers.placements.faces=[-z]"]).problem
    assert decisions_per_node(problem) == 0.0
    assert np.isfinite(decisions_per_node(problem))


@pytest.mark.parametrize(
    ("repeat", "highs", "limit", "named"),
    [(0, 1, 1.0, "--repeat"), (1, 0, 1.0, "--highs"), (1, 1, 0.0, "--search-limit")],
)
def test_senseless_efforts_are_bad_input(repeat: int, highs: int, limit: float, named: str) -> None:
    """The message names the option."""
    with pytest.raises(InputError, match=named):
        bench_command(BenchVerb(None, repeat, highs, limit))
