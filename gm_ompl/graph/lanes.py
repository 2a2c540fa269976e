"""All arcs of an object graph as one table: what the search over lanes goes by.

A set of placements along all of them is a lane. A hub (one finger lifted, the object at rest) joins
the lanes that share the other placements.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose
from gm_ompl.holds.tables import ArcTable, Frame
from gm_ompl.holds.watch import Stop, watched
from gm_ompl.motion.object_graph import GraphArc, ObjectGraph

Leaving: TypeAlias = Mapping[int, Sequence[GraphArc]]
"""Arcs of an object graph by their tails."""


def lane_table(
    judge: Judge, stop: Stop, leaving: Leaving | None = None
) -> tuple[tuple[int, ...], ArcTable]:
    """Return the graph's nodes in the order of the table's, and the table of all arcs.

    With ``leaving`` the nodes are those in it, and the arcs what it says. Geometry is tested
    throughout. On a row of nodes contact states are found of arcs that lead towards the goal; most
    searches hardly need those of the others, and of a larger graph only a few.

    Raises:
        LimitError: ``stop`` said so.
    """
    graph = judge.problem.object_graph
    leaving = _explored(graph, stop) if leaving is None else leaving
    nodes = tuple(sorted(leaving))
    limits.check()
    frame, nearer = _frame(graph, nodes, leaving)
    table = ArcTable(judge, frame, stop)
    for a in watched(nearer if frame.one_pass else (), stop):
        table.ask(a)
    return nodes, table


def _explored(graph: ObjectGraph, stop: Stop) -> dict[int, Sequence[GraphArc]]:
    """Return the arcs leaving each node that the start leads to."""
    waiting = [graph.start]
    leaving: dict[int, Sequence[GraphArc]] = dict.fromkeys(waiting, ())
    for node in watched(waiting, stop):
        leaving[node] = graph.arcs_from(node)
        new = [arc.head for arc in leaving[node] if arc.head not in leaving]
        waiting += new
        leaving |= dict.fromkeys(new, ())
    return leaving


def _frame(
    graph: ObjectGraph, nodes: Sequence[int], leaving: Mapping[int, Sequence[GraphArc]]
) -> tuple[Frame, list[int]]:
    """Return all arcs, those to larger nodes first, and which of them lead nearer to the goal."""
    number = {node: c for c, node in enumerate(nodes)}
    found = [
        (c, arc.leading_to(number[arc.head]))
        for c, node in enumerate(nodes)
        for arc in leaving[node]
    ]
    found.sort(key=lambda pair: (pair[1].head < pair[0], min(pair[0], pair[1].head)))
    tail = np.array([c for c, _ in found], dtype=np.int64)
    head = np.array([arc.head for _, arc in found], dtype=np.int64)
    goal = np.array([graph.in_goal(node) for node in nodes])
    hops = _hops(tail, head, goal)
    nearer = np.flatnonzero(hops[head] < hops[tail])
    row = bool((np.abs(head - tail) == 1).all())
    if row:  # first what leads back, from the first node on, then what leads ahead, from the last
        order = np.lexsort((np.where(head < tail, head, -tail), head > tail))
    else:
        order = np.argsort(hops[head], kind="stable")
    arcs = [arc for _, arc in found]
    poses = list(_poses(graph, nodes))
    return Frame(poses, tail, arcs, order, row, goal), nearer.tolist()


def _poses(graph: ObjectGraph, nodes: Sequence[int]) -> Iterator[Pose]:
    for node in nodes:
        limits.check()
        yield graph.pose(node)


def _hops(tail: IntArray, head: IntArray, goal: np.ndarray) -> IntArray:
    """Return how many arcs each node is from the goal; a large number where there is no way."""
    into: list[list[int]] = [[] for _ in goal]
    for a, b in zip(tail.tolist(), head.tolist(), strict=True):
        into[b].append(a)
    hops = np.where(goal, 0, len(goal)).tolist()
    waiting = deque(np.flatnonzero(goal).tolist())
    while waiting:
        here = waiting.popleft()
        for node in into[here]:
            if hops[node] > hops[here] + 1:
                hops[node] = hops[here] + 1
                waiting.append(node)
    return np.array(hops, dtype=np.int64)
