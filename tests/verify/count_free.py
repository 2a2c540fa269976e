"""Free motion: two lattices built by different code, three searches."""

from __future__ import annotations

import itertools

from gm_ompl.motion.object_graph import ObjectGraph
from gm_ompl.planners.planner import Status
from gm_ompl.reference.contact_lattice import object_graph
from gm_ompl.reference.search import plain_search
from gm_ompl.scenario.load import load
from tests.lattices import differences
from tests.verify.count_searches import AGREE, gap, solve
from tests.verify.counting import Result, count

NODES = 60
"""Walked of each lattice; the plain search walks no larger ones."""


def _name(instance: int) -> str:
    return f"random/{'free-clutter' if instance % 2 else 'free'}/{instance // 2}"


@count(instances=200)
def lattices_agree(instance: int) -> Result:
    """Planner and reference find the same poses and arcs, 60 poses deep."""
    problem = load(_name(instance)).problem
    two = object_graph(problem)
    found = list(
        itertools.islice(differences(problem.object_graph, two, problem.body.diagonal, NODES), 3)
    )
    return Result(holds=not found, worst=float(len(found)), note=f"{_name(instance)}: {found}")


@count(instances=200)
def free_agreement(instance: int) -> Result:
    """Astar and dijkstra find the same optimum (1e-6); so does the plain search, where small."""
    problem = load(_name(instance)).problem
    one, other = solve(problem, "astar"), solve(problem, "dijkstra")
    optimum = float("inf") if other.status is Status.INFEASIBLE else float(other.cost or 0.0)
    gaps = [gap(one, optimum)]
    if len(_nodes(problem.object_graph)) <= NODES:
        gaps.append(gap(one, plain_search(problem).cost))
    return Result(holds=max(gaps) <= AGREE, worst=max(gaps), note=f"{_name(instance)}: {gaps}")


def _nodes(graph: ObjectGraph) -> set[int]:
    """Return the nodes of a graph, no more than a few beyond NODES."""
    found, waiting = {graph.start}, [graph.start]
    while waiting and len(found) <= NODES:
        for arc in graph.arcs_from(waiting.pop(0)):
            if arc.head not in found:
                found.add(arc.head)
                waiting.append(arc.head)
    return found
