"""Free motion: two lattices built by different code, three searches."""

from __future__ import annotations

import itertools
import math

from gm_ompl.motion.object_graph import ObjectGraph
from gm_ompl.plain.contact_lattice import object_graph
from gm_ompl.plain.search import plain_search
from gm_ompl.planners.planner import Status
from gm_ompl.problem import Displacement
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from tests.free_laws import CHANGES, Tree, square
from tests.freed import free_path, free_plane, one_piece, small_plane
from tests.lattices import differences
from tests.verify.count_searches import AGREE, cost_of, gap, solve
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


@count(instances=100)
def free_laws(instance: int) -> Result:
    """Moved, turned, mirrored, in other units, renumbered: the optimum of free motion is as it was.

    Worst: the greatest relative difference.
    """
    name = _name(instance)
    tree = square(name)
    cost = _optimum(tree)
    gaps = {}
    for change, (changed, scale) in CHANGES.items():
        other = _optimum(changed(tree)) / scale
        both = math.isinf(cost) and math.isinf(other)
        gaps[change] = 0.0 if both else abs(other - cost) / max(cost, 1e-12)
    worst = max(gaps.values())
    return Result(holds=worst <= AGREE, worst=worst, note=f"{name}: {gaps}")


@count(instances=100)
def free_paths(instance: int) -> Result:
    """A region and axes that leave one path give the optimum of the path scenario.

    Worst: the greatest relative difference.
    """
    path = one_piece(instance)
    if path is None:
        return Result(holds=True, outcome="two pieces")
    return _alike(_optimum(free_path(path)), _optimum(path), f"random/small/{instance}")


@count(instances=100)
def free_planes(instance: int) -> Result:
    """Left in the plane, free motion has the planar optimum; with walls at most that.

    Worst: the greatest relative difference on a bare floor.
    """
    plane = small_plane(instance)
    if plane is None:
        return Result(holds=True, outcome="blocked")
    found, name = solve(Scenario.from_resolved(plane).problem, "astar"), f"random/planar/{instance}"
    cost, free = cost_of(found), free_plane(plane)
    if not plane["environment"]["obstacles"]:
        return _alike(_optimum(free), cost, name)
    if math.isinf(cost):
        return Result(holds=True, note=name, outcome="no plan among walls")
    # Along walls there are ever new ways to lie askew; the planar plan has so many arcs.
    free["lattice"]["depth"] = sum(isinstance(move, Displacement) for move in found.moves)
    least = _optimum(free)
    outcome = "cheaper" if least < cost * (1.0 - AGREE) else "the same"
    note = f"{name}: {least}, {cost}"
    return Result(holds=least <= cost * (1.0 + AGREE), note=note, outcome=outcome)


def _alike(one: float, other: float, name: str) -> Result:
    both = math.isinf(one) and math.isinf(other)
    worst = 0.0 if both else abs(one - other) / max(other, 1e-12)
    outcome = "no plan" if both else "the same"
    return Result(
        holds=worst <= AGREE, worst=worst, note=f"{name}: {one}, {other}", outcome=outcome
    )


def _optimum(tree: Tree) -> float:
    """Return the optimal cost, +inf where there is no plan."""
    return cost_of(solve(Scenario.from_resolved(tree).problem, "astar"))
