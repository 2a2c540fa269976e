"""What is left to travel where no margin is asked for: never more than it is."""

from __future__ import annotations

import heapq
from collections.abc import Iterable

import numpy as np
import pytest

from gm_ompl.contact.environment import environment_contacts
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.closure import lifts
from gm_ompl.graph.kept_bounds import PlanarBounds
from gm_ompl.graph.kept_graph import KeptGraph
from gm_ompl.graph.kept_tables import EMPTY, STATES
from gm_ompl.graph.regrasp_graph import RegraspGraph
from gm_ompl.holds.sets import LIFTED
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load

MORE = 1.1
"""The true way is looked for among ways that are dearer by so much."""

SETS = 4

CASES = (
    ("tasks/reorient", ("fingers.placements.grid=[1, 2]",), (1.0, 2.0, 2.8)),
    ("free/stairs", (), (8.0, 11.5)),
    ("free/out-of-the-corner", (), (8.0, 10.5)),
)


def regrasping(problem: Problem) -> tuple[Judge, RegraspGraph]:
    """States of plans that regrasp once."""
    judge = Judge(problem, KernelBackend(problem))
    kept = KeptGraph(judge)
    assert isinstance(kept.planar, PlanarBounds)
    return judge, RegraspGraph(judge, kept, kept.planar)


def touches(problem: Problem, moments: Iterable[Moment]) -> bool:
    """Whether the object touches something at each of some moments."""
    world = problem.body, problem.environment
    return all(len(environment_contacts(*world, moment.pose).points) for moment in moments)


def true_ways(
    problem: Problem, judge: Judge, members: list[tuple[int, ...]], most: float
) -> dict[int, float]:
    """What nodes have left to travel by arcs on which one of some hubs is free.

    Nodes are those that a way of at most ``most`` leads to.
    """
    graph, fingers = problem.object_graph, [i for i, r in enumerate(members[0]) if r != LIFTED]
    tips = np.array([judge.centres(i)[members[0][i]] for i in fingers])
    reached, queue, back = (
        {graph.start: 0.0},
        [(0.0, graph.start)],
        dict[int, list[tuple[int, float]]](),
    )
    done = set[int]()
    while queue:
        cost, node = heapq.heappop(queue)
        if node in done:
            continue
        done.add(node)
        for arc in graph.arcs_from(node):
            if not lifts(problem) and not touches(problem, arc.middles()):
                continue
            free = judge.passing(arc, graph.pose(arc.head)).free
            if not any(all(free[i][m[i]] for i in fingers) for m in members):
                continue
            length = float(arc.lengths(tips).max(axis=0).sum())
            back.setdefault(arc.head, []).append((node, length))
            if cost + length <= most and cost + length < reached.get(arc.head, np.inf):
                reached[arc.head] = cost + length
                heapq.heappush(queue, (cost + length, arc.head))
    left = {node: 0.0 for node in reached if graph.in_goal(node)}
    queue = [(0.0, node) for node in left]
    while queue:
        cost, node = heapq.heappop(queue)
        for tail, length in back.get(node, []) if cost <= left[node] else []:
            if cost + length < left.get(tail, np.inf):
                left[tail] = cost + length
                heapq.heappush(queue, (cost + length, tail))
    return left


@pytest.mark.parametrize(("name", "changes", "limits"), CASES)
def test_it_is_never_more_than_it_is(
    name: str, changes: tuple[str, ...], limits: tuple[float, ...]
) -> None:
    """At every state that was reached."""
    problem = load(name, changes).problem
    judge, once = regrasping(problem)
    for limit in limits:
        while once._relaxed.seen.reached < limit:
            assert once._relaxed.reach(limit, once.object)
    book, seen, hubs = once._relaxed.tables.book, once._relaxed.seen, once._first[0]
    states, told = int(book.counts[STATES]), 0
    assert len(seen.after) == states
    stand = once.tables.relaxed.rows[hubs : once._first[1]]
    for one in np.unique(stand[stand != EMPTY])[:SETS].tolist():
        members = [once.placements(hubs + k) for k in np.flatnonzero(stand == one).tolist()]
        left = true_ways(problem, judge, members, MORE * limits[-1])
        for state in np.flatnonzero(book.hand[:states] == one).tolist():
            if (pose := int(book.pose[state])) in left:
                assert seen.after[state] <= left[pose] + 1e-9
                told += seen.after[state] > 0.5 * left[pose]
    assert told
