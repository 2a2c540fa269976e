"""Limits on time and memory are heard in every phase, by a clock that these tests move."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

import gm_ompl
from gm_ompl import clock, limits
from gm_ompl.app.main import app
from gm_ompl.errors import LimitError
from gm_ompl.geometry import collision, decomposition
from gm_ompl.geometry.mesh import _awaited
from gm_ompl.holds import sets
from gm_ompl.motion.lattice import Goal
from gm_ompl.motion.object_graph import ON_LATTICE, _inside
from gm_ompl.motion.path import path_lattice

TICK = 1e-3
"""What a look at the clock takes, by the clock of these tests [s]."""

LATE = 200
"""Looks at the clock that may follow the end: results are put together, and told."""

DENSE = {"lattice.segments": 3000}
FINE = "lattice.steps={x: 0.01, y: 0.01, yaw: 0.2 deg}"
CROWDED = {"fingers.placements.grid": [12, 12]}


class Ticking:
    """A clock that moves when it is looked at, and counts the looks after an end."""

    def __init__(self) -> None:
        self.time, self.end, self.late = 0.0, np.inf, 0

    def __call__(self) -> float:
        self.time += TICK
        self.late += self.time > self.end
        return self.time


@pytest.fixture
def ticking(monkeypatch: pytest.MonkeyPatch) -> Ticking:
    made = Ticking()
    monkeypatch.setattr(clock, "now", made)
    return made


@pytest.mark.parametrize("looks", [3, 40, 1000])
@pytest.mark.parametrize("planner", ["astar", "dijkstra", "HybridRRTConnect"])
@pytest.mark.parametrize(
    ("name", "change"), [("paper/tumble", DENSE), ("planar/turn", FINE), ("paper/slide", CROWDED)]
)
def test_a_plan_ends_where_its_time_does(
    name: str, change: object, planner: str, looks: int, ticking: Ticking
) -> None:
    """Whatever phase the limit falls into, hardly anything is looked at after it."""
    scenario = gm_ompl.load(name, change)  # type: ignore[arg-type]
    seconds = TICK * looks
    ticking.end = ticking.time + seconds
    plan = gm_ompl.plan(scenario, planner, time_limit=seconds)
    assert ticking.late <= LATE or plan.status == "solved"
    if plan.status == "budget":
        assert "time limit" in plan.statistics.model_extra["ended_by"]  # type: ignore[index]


@pytest.mark.parametrize("looks", [40, 1000])
@pytest.mark.parametrize(
    ("name", "change"), [("paper/tumble", DENSE), ("planar/turn", FINE), ("paper/slide", CROWDED)]
)
def test_an_explanation_ends_where_its_time_does(
    name: str, change: object, looks: int, ticking: Ticking
) -> None:
    """It tells what it knows by then; knowing nothing, it says so by an exception."""
    scenario = gm_ompl.load(name, change)  # type: ignore[arg-type]
    seconds = TICK * looks
    ticking.end = ticking.time + seconds
    with contextlib.suppress(LimitError):
        assert gm_ompl.explain(scenario, time_limit=seconds).verdict
    assert ticking.late <= LATE


@pytest.mark.usefixtures("ticking")
def test_loading_listens_too(tmp_path: Path) -> None:
    """A file that takes long to read, and a mesh that takes long to cut, are given up."""
    file = tmp_path / "ring.stl"
    trimesh.creation.annulus(r_min=1, r_max=2, height=1, sections=24).export(file)
    change = [f"object.shape={{mesh: {file}}}", "motion.start.position.2=rest"]
    for looks in (3, 30, 60):
        decomposition._solid.cache_clear()
        with pytest.raises(LimitError, match="time limit"), limits.holding(TICK * looks):
            gm_ompl.load("paper/slide", change)
    result = CliRunner().invoke(app, ["plan", "paper/slide", "--time-limit", "0.003", "--json"])
    assert result.exit_code == 4
    assert "the time limit of 0.003 s is reached" in result.output


def test_what_cannot_fit_is_refused_at_once_with_the_numbers(ticking: Ticking) -> None:
    """A lattice that is too large for the memory limit: nodes, need, limit, remedy, no work."""
    limit = limits.resident_memory() / limits.MEGABYTE + 300
    change = ["--set", "lattice.segments=1000000"]
    memory = ["--memory-limit", f"{limit:.0f}"]
    result = CliRunner().invoke(app, ["plan", "paper/tumble", *change, *memory])
    assert result.exit_code == 4
    told = " ".join(result.output.split())
    assert "a lattice of 1,000,001 nodes with 294 placements cannot fit" in told
    assert f"the memory limit is {limit:.6g} MB" in told.replace(f"{limit:.0f}", f"{limit:.6g}")
    assert "use a coarser lattice.segments" in told
    assert " 0 nodes expanded, 0 mode decisions" in told
    assert ticking.time < 1.0  # a thousand looks; the lattice has a million nodes


@pytest.mark.parametrize("planner", ["astar", "HybridRRTConnect"])
def test_clearances_that_cannot_fit_are_refused(planner: str) -> None:
    """Whatever the planner: pairs of placements are claimed before they are listed."""
    limit = limits.resident_memory() / limits.MEGABYTE + 100
    scenario = gm_ompl.load("paper/slide", {"fingers.placements.grid": [70, 70]})
    plan = gm_ompl.plan(scenario, planner, memory_limit=limit)
    assert plan.status == "budget"
    assert "29,400 placements" in plan.statistics.model_extra["ended_by"]  # type: ignore[index]


def test_a_plan_in_hand_is_kept(ticking: Ticking) -> None:
    """A limit that is reached after the first plan ends the search with that plan."""
    small = {"fingers.placements.grid": [3, 3], "lattice.segments": 8}
    found = gm_ompl.plan(gm_ompl.load("paper/slide", small), "HybridRRTstar", time_limit=5.0)
    assert found.status == "solved"
    assert ticking.time >= 5.0
    assert gm_ompl.check(found).holds


def test_inner_limits_hold_beside_outer_ones(ticking: Ticking) -> None:
    """The nearest end counts, and with the block its limits are gone."""
    with limits.holding(1.0), limits.holding(100 * TICK):
        assert limits.left() <= 100 * TICK
        ticking.time += 0.2
        with pytest.raises(LimitError, match=r"0\.1 s"):
            limits.check()
        with limits.lifted():
            limits.check()
    limits.check()
    assert limits.left() == np.inf
    assert ticking.time < 1.0


def test_memory_is_claimed_before_it_is_taken() -> None:
    """What fits is allowed, what does not is refused, in numbers."""
    limit = limits.resident_memory() / limits.MEGABYTE + 50
    with limits.holding(None, limit):
        limits.claim(10 * limits.MEGABYTE, "little", "nothing")
        assert limits.fits(10 * limits.MEGABYTE)
        assert not limits.fits(100 * limits.MEGABYTE)
        with pytest.raises(LimitError, match=r"much cannot fit: 100 MB more.*; take less"):
            limits.claim(100 * limits.MEGABYTE, "much", "take less")


@pytest.mark.usefixtures("ticking")
def test_native_work_is_given_up() -> None:
    """While another thread works, the limits are heard; its errors are raised here."""
    held = threading.Event()
    with pytest.raises(LimitError), limits.holding(5 * TICK):
        _awaited(lambda: held.wait(5.0))
    with pytest.raises(ZeroDivisionError):
        _awaited(lambda: 1 // 0)
    assert _awaited(lambda: 7) == 7


def test_parts_do_not_change_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sets of placements and clearances made in small parts are those made at once."""

    def made() -> Iterator[np.ndarray]:
        problem = gm_ompl.load("fingers/three").problem
        judge = gm_ompl.asking.judge_of(problem)
        free = judge.node(problem.motion.pose(problem.start)).free
        found = sets.placement_sets(problem.fingers.groups(), free, judge.clear, 100_000)
        assert found is not None
        yield found
        yield from (pair for row in judge.clear for pair in row if pair is not None)

    whole = list(made())
    monkeypatch.setattr(sets, "CANDIDATES", 100)
    monkeypatch.setattr(collision, "PAIRS", 100)
    assert all(np.array_equal(a, b) for a, b in zip(whole, made(), strict=True))


@pytest.mark.parametrize("goal", [(None, None), (0.25, 0.75), (1 / 3, 1 / 3)])
def test_the_goal_on_an_axis_is_what_the_goal_contains(
    goal: tuple[float | None, float | None],
) -> None:
    """Second opinion on all nodes of an axis at once: node by node."""
    lattice = path_lattice((6, 3))
    assert lattice.axes[0].tolist() == [
        (p + k / n) / 2 for p, n in enumerate((6, 3)) for k in range(n)
    ] + [1.0]
    region = Goal((goal[0],), (goal[1],), (None,))
    one_by_one = [
        k for k, s in enumerate(lattice.axes[0].tolist()) if region.contains((s,), ON_LATTICE)
    ]
    assert _inside(lattice, region, 0).tolist() == one_by_one


def test_an_exact_mesh_is_cut_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seeing whether a mesh can be cut, and using it, take one cut together."""
    calls: list[int] = []
    cut: Callable[..., object] = decomposition._leaves

    def counted(*arguments: object) -> object:
        calls.append(1)
        return cut(*arguments)

    decomposition._solid.cache_clear()
    monkeypatch.setattr(decomposition, "_leaves", counted)
    gm_ompl.load("shapes/l-bracket")
    assert len(calls) == 1


def test_full_memory_stays_full_between_readings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever asks next hears of it, too, and says so."""
    monkeypatch.setattr(limits, "READING_EVERY", 1000.0)
    monkeypatch.setattr(limits, "resident_memory", lambda: 2.0 * limits.MEGABYTE)
    with limits.holding(megabytes=1.0):
        assert limits.reached() == limits.reached() == "the memory limit of 1 MB is reached"
