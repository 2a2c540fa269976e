"""The manipulation-feasibility graph of one degree of freedom, as lanes joined by hubs.

With one coordinate a set of placements is a line of nodes, and the rest of its path is known. A
hub (one finger lifted, the object at rest) joins the lanes that share the other placements.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.feasibility.judge import Judge, NodeGeometry
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.lane_bounds import UNASKED, LaneTables
from gm_ompl.graph.watch import Stop, watched
from gm_ompl.motion.object_graph import GraphArc, ObjectGraph
from gm_ompl.problem import Problem


def lane_tables(problem: Problem, judge: Judge, backend: KernelBackend, stop: Stop) -> LaneTables:
    """Return what all lanes of a problem of one coordinate share, geometry tested throughout.

    Raises:
        Stopped: ``stop`` said so.
    """
    graph, P = problem.object_graph, problem.cost.samples_per_arc
    arcs = _row(graph)
    N = len(arcs)
    nodes = range(N + 1)
    node_free = _masks(judge, [judge.node(graph.pose(c)) for c in watched(nodes, stop)])
    free = _masks(judge, [judge.along(arc.arc) for arc in watched(arcs, stop)])
    free &= node_free[:, :, :-1] & node_free[:, :, 1:]
    lengths = _lengths(problem, judge, arcs)
    goal = np.array([graph.in_goal(c) for c in nodes])
    forward = np.array(
        [[judge.environment(moment) for moment in arc.middles()] for arc in watched(arcs, stop)],
        dtype=np.int64,
    ).reshape(N, P)
    travel = lengths.sum(axis=3)
    # Each arc by whatever placement is shortest there: a plan that regrasps again may change.
    shortest = np.where(free, travel, np.inf).min(axis=1, keepdims=True, initial=np.inf)
    least = _ahead(shortest, np.isfinite(shortest), goal)[:, 0].max(axis=0)
    tables = LaneTables(
        forward=forward,
        backward=np.full((N, P), UNASKED),
        lengths=lengths,
        free=free,
        node_free=node_free,
        goal=goal,
        wanted=np.array([-1 if g is None else g for g in problem.fingers.goal], dtype=np.int64),
        ahead=_ahead(travel, free, goal),
        least=least,
        z_min=problem.mechanics.z_min / backend.scale,
        X_stab=problem.cost.stability / backend.scale,
        X_regr=float(problem.cost.regrasp),
    )
    backend.pool.reserve(1 + int(forward.max(initial=0)))
    return tables


def ask_backward(tables: LaneTables, problem: Problem, judge: Judge, span: slice) -> int:
    """Find contact states of backward arcs, which most searches hardly need; return of how many."""
    backward, graph = tables.backward, problem.object_graph
    unasked = [i for i in range(span.start, span.stop) if backward[i, 0] == UNASKED]
    for i in unasked:
        arc = next(arc for arc in graph.arcs_from(i + 1) if arc.head == i)
        backward[i] = [judge.environment(moment) for moment in arc.middles()]
    return len(unasked)


def _row(graph: ObjectGraph) -> list[GraphArc]:
    """Return the arcs c -> c + 1 of a graph whose nodes are a row of them from 0 on."""
    arcs: list[GraphArc] = []
    while ahead := [a for a in graph.arcs_from(len(arcs)) if a.head == len(arcs) + 1]:
        arcs += ahead
    return arcs


def _masks(judge: Judge, places: Sequence[NodeGeometry]) -> BoolArray:
    """Return (n, placements, len(places)): which fingertips are free at each place."""
    n, rows = judge.problem.fingers.count, len(judge.problem.fingers.placements)
    if not places or not n:
        return np.zeros((n, rows, len(places)), dtype=bool)
    return np.ascontiguousarray(np.stack([np.stack(p.free) for p in places], axis=2))


def _lengths(problem: Problem, judge: Judge, arcs: Sequence[GraphArc]) -> Array:
    """Return the chords (n, placements, N, P) of Eq. (9)."""
    P, radii = problem.cost.samples_per_arc, problem.fingers.radius.tolist()
    known: dict[float, Array] = {}
    for i, radius in enumerate(radii):
        if radius not in known:
            centres = judge.centres(i)
            each = [arc.lengths(centres) for arc in arcs]
            known[radius] = np.stack(each, axis=1) if each else np.zeros((len(centres), 0, P))
    return np.ascontiguousarray(np.stack([known[radius] for radius in radii]))


def _ahead(travel: Array, free: BoolArray, goal: BoolArray) -> Array:
    """Return (n, placements, N + 1): travel to the nearest goal node; +inf where blocked."""
    n, rows, N = travel.shape
    cost = np.where(free, travel, np.inf)
    ahead = np.full((n, rows, N + 1), np.inf)
    run = np.full((n, rows), np.inf)
    for c in range(N, -1, -1):
        run = np.zeros((n, rows)) if goal[c] else (run + cost[:, :, c] if c < N else run)
        ahead[:, :, c] = run
    run = np.full((n, rows), np.inf)
    for c in range(N + 1):
        run = np.zeros((n, rows)) if goal[c] else (run + cost[:, :, c - 1] if c else run)
        ahead[:, :, c] = np.minimum(ahead[:, :, c], run)
    return ahead
