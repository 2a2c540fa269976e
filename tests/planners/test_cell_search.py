"""The search over cells of placements, against the search over lanes and the plain search."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

import gm_ompl
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.reach import Reach
from gm_ompl.plain.search import plain_search
from gm_ompl.planners import lane_parts
from gm_ompl.planners.lane_parts import set_count
from gm_ompl.planners.planner import Budget, Progress, SearchResult, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.planners.trace import Expansion, Vertex
from gm_ompl.problem import Problem, Regrasp
from gm_ompl.scenario.load import load

Choose = Callable[[bool], None]


@pytest.fixture
def over_cells(monkeypatch: pytest.MonkeyPatch) -> Choose:
    """``over_cells(yes)``: search over cells, or lane by lane, however many sets there are."""

    def choose(yes: bool) -> None:
        monkeypatch.setattr(lane_parts, "FEW_SETS", -1 if yes else 10**30)

    return choose


def solve(problem: Problem, budget: Budget | None = None) -> SearchResult:
    """Solve with the kernel."""
    judge, rng = Judge(problem, KernelBackend(problem)), np.random.default_rng(0)
    return make_planner("astar").solve(problem, judge, budget or Budget(), rng)


def both(problem: Problem, over_cells: Choose) -> tuple[SearchResult, SearchResult]:
    """Return what the searches over cells and over lanes find; both must agree."""
    over_cells(True)
    cells = solve(problem)
    over_cells(False)
    lanes = solve(problem)
    assert cells.status is lanes.status
    assert cells.optimal == lanes.optimal
    if lanes.cost is None:
        assert cells.lower_bound == lanes.lower_bound == math.inf
    else:
        assert cells.cost == pytest.approx(lanes.cost, rel=1e-6, abs=1e-12)
        assert cells.lower_bound == pytest.approx(lanes.lower_bound, rel=2e-6, abs=1e-12)
    return cells, lanes


@pytest.mark.parametrize(
    ("name", "grid"),
    [
        ("paper/slide", 5), ("paper/push", 5), ("paper/tumble", 7), ("paper/cork", 5),
        ("paper/regrasp", 3), ("fingers/three", 3), ("shapes/hexagon", 4),
        ("shapes/l-bracket", 4), ("free/stairs", 3),
    ],
)  # fmt: skip
def test_shipped_problems_cost_the_same(name: str, grid: int, over_cells: Choose) -> None:
    """Boxes, hulls and meshes, paths and free motion, with regrasps: the same optimum."""
    problem = load(name, [f"fingers.placements.grid=[{grid}, {grid}]"]).problem
    cells, _ = both(problem, over_cells)
    assert cells.status is Status.SOLVED


@pytest.mark.parametrize("seed", [0, 1, 4, 10, 13, 14, 15, 20, 21, 22, 25, 33])
def test_random_problems_agree_with_the_plain_search(seed: int, over_cells: Choose) -> None:
    """Cells, lanes and the reference's plain search find the same optimum or none."""
    problem = load(f"random/small/{seed}").problem
    cells, _ = both(problem, over_cells)
    optimum = plain_search(problem).cost
    if optimum == math.inf:
        assert cells.status is Status.INFEASIBLE
    else:
        assert cells.cost == pytest.approx(optimum, rel=1e-6, abs=1e-12)


def test_given_placements_and_unlike_fingers(over_cells: Choose) -> None:
    """Fingers that must begin or end somewhere, and that are not interchangeable, are heeded."""
    problem = load("paper/regrasp", ["fingers.placements.grid=[3, 3]"]).problem
    best, _ = both(problem, over_cells)
    regrasp = next(move for move in best.moves if isinstance(move, Regrasp))
    there = [list(regrasp.placements), list(regrasp.placements)]
    there[1][regrasp.finger] = regrasp.target
    for start, goal in ((there[0], [None, None]), ([None, None], there[1]), (there[0], there[1])):
        fingers = dataclasses.replace(problem.fingers, start=tuple(start), goal=tuple(goal))
        cells, _ = both(dataclasses.replace(problem, fingers=fingers), over_cells)
        assert cells.cost == pytest.approx(best.cost)
    limits = np.array([10.0, 9.0])
    fingers = dataclasses.replace(problem.fingers, max_normal_force=limits)
    both(dataclasses.replace(problem, fingers=fingers), over_cells)


def test_ways_through_the_air_are_asked_for(
    over_cells: Choose, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A regrasp whose way is refused is not taken; the next best plan is found."""
    problem = load("paper/regrasp", ["fingers.placements.grid=[2, 2]"]).problem
    free, _ = both(problem, over_cells)
    refused = next(move for move in free.moves if isinstance(move, Regrasp))
    joined = Reach.joined

    def refusing(self: Reach, pose, finger, staying, a, b):  # type: ignore[no-untyped-def]
        return b != refused.target and joined(self, pose, finger, staying, a, b)

    monkeypatch.setattr(Reach, "joined", refusing)
    over_cells(True)
    cells = solve(problem)
    assert cells.cost is not None
    assert free.cost is not None
    assert cells.cost >= free.cost
    assert all(m.target != refused.target for m in cells.moves if isinstance(m, Regrasp))


def test_many_placements_are_proven_and_hold() -> None:
    """With 15,606 placements cells are chosen by size; the plan is proven and its check holds."""
    scenario = load("paper/slide", ["fingers.placements.grid=[51, 51]", "lattice.segments=3"])
    assert set_count(scenario.problem) > lane_parts.FEW_SETS
    plan = gm_ompl.plan(scenario)
    assert plan.optimal
    assert gm_ompl.check(plan).holds


def test_four_fingers_with_a_regrasp(over_cells: Choose) -> None:
    """Plans whose fingers travel as far and differ in z alone are told apart; lanes agree."""
    few = load("paper/regrasp", ["fingers.placements.grid=[3, 3]", "fingers.count=4"]).problem
    cells, _ = both(few, over_cells)
    assert sum(isinstance(move, Regrasp) for move in cells.moves) == 1
    over_cells(True)
    scenario = load("paper/regrasp", ["fingers.placements.grid=[5, 5]", "fingers.count=4"])
    plan = gm_ompl.plan(scenario)
    assert plan.optimal
    assert plan.regrasps == 1
    assert gm_ompl.check(plan).holds


def test_finer_grids_that_contain_coarser_ones_cost_no_more(over_cells: Choose) -> None:
    """Every third placement of 9 x 9 is one of 3 x 3: the optimum only falls."""
    over_cells(True)
    costs = [
        solve(load("paper/tumble", [f"fingers.placements.grid=[{m}, {m}]"]).problem).cost
        for m in (3, 9, 27)
    ]
    known = [cost for cost in costs if cost is not None]
    assert len(known) == 3
    assert known == sorted(known, reverse=True)


def test_a_search_that_is_stopped_knows_a_bound(over_cells: Choose) -> None:
    """After few products no plan is claimed optimal; bounds never fall and plans only improve."""
    over_cells(True)
    problem = load("paper/regrasp", ["fingers.placements.grid=[5, 5]"]).problem
    whole = solve(problem)
    assert whole.cost is not None
    before = 0.0
    for most in (1, 50, 500):
        result = solve(problem, Budget(max_iterations=most))
        assert not result.optimal
        assert before <= result.lower_bound <= whole.cost
        before = result.lower_bound
        assert result.cost is None or result.cost >= whole.cost * (1.0 - 1e-9)
    bounds = [bound for _, _, bound in whole.statistics["history"]]
    assert bounds == sorted(bounds)


def test_ctrl_c_ends_it(over_cells: Choose) -> None:
    """Ctrl-C returns what is known, as interrupted."""
    over_cells(True)

    def stop() -> bool:
        raise KeyboardInterrupt

    problem = load("paper/regrasp", ["fingers.placements.grid=[5, 5]"]).problem
    assert solve(problem, Budget(stop=stop)).status is Status.INTERRUPTED


def test_products_are_told(over_cells: Choose) -> None:
    """Who traces the search hears of every product, of placements where they are single."""
    over_cells(True)

    class Listening:
        def __init__(self) -> None:
            self.heard: list[Expansion | Vertex] = []

        def __call__(self, progress: Progress) -> None: ...

        def trace(self, event: Expansion | Vertex) -> None:
            self.heard.append(event)

    report = Listening()
    problem = load("paper/slide", ["fingers.placements.grid=[3, 3]"]).problem
    judge, rng = Judge(problem, KernelBackend(problem)), np.random.default_rng(0)
    make_planner("astar").solve(problem, judge, Budget(), rng, report)
    told = [event for event in report.heard if isinstance(event, Expansion)]
    assert {event.why for event in told} == {"cells bounded", "placements judged"}
    assert all(len(event.placements) in (0, 2) for event in told)
    keys = [event.bound for event in told]
    assert max(keys) <= 16.0


def test_uncertain_problems_stay_with_lanes() -> None:
    """Bounds over cells know one case alone: with uncertainty lanes are taken one by one."""
    problem = load(
        "paper/slide",
        ["fingers.placements.grid=[13, 13]", "uncertainty.finger_friction=10%"],
    ).problem
    assert set_count(problem) > lane_parts.FEW_SETS
    part = lane_parts.part_class(problem)
    assert part is lane_parts.LanePart
