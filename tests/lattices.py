"""Compares what two object graphs have: poses, arcs between them, their segments."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Iterator

import numpy as np

from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import angle_between
from gm_ompl.motion.object_graph import GraphArc, ObjectGraph


def differences(one: ObjectGraph, two: ObjectGraph, size: float, most: int) -> Iterator[str]:
    """Yield how two graphs differ; at most so many nodes are walked, in step.

    Poses are one to 1e-5 of ``size`` and 1e-5 rad: each graph takes the first pose found for all
    within 1e-6, and may have found another one first.
    """
    partner, waiting = {one.start: two.start}, deque([one.start])
    for _ in range(most):
        if not waiting:
            return
        node = waiting.popleft()
        left = list(two.arcs_from(partner[node]))
        for arc in one.arcs_from(node):
            alike = next((other for other in left if _same(arc, other, size)), None)
            if alike is None:
                yield f"only the first has {_words(arc)} from {_place(one.pose(node))}"
                continue
            left.remove(alike)
            if arc.head not in partner:
                partner[arc.head] = alike.head
                waiting.append(arc.head)
            elif partner[arc.head] != alike.head:
                yield f"{_words(arc)} from {_place(one.pose(node))} ends at another node"
        for arc in left:
            yield f"only the second has {_words(arc)} from {_place(two.pose(partner[node]))}"


def leaving(graph: ObjectGraph, most: int) -> Iterator[tuple[int, GraphArc]]:
    """Yield the arcs that leave the first poses of a lattice, with their tails."""
    met = [graph.start]
    for tail in itertools.islice(met, most):
        for arc in graph.arcs_from(tail):
            if arc.head not in met:
                met.append(arc.head)
            yield tail, arc


def _same(a: GraphArc, b: GraphArc, size: float) -> bool:
    if a.parts != b.parts:
        return False
    cuts = zip(a.arc.cuts(a.parts), b.arc.cuts(b.parts), strict=True)
    return all(
        np.linalg.norm(p.position - q.position) <= 1e-5 * size
        and angle_between(p.rotation, q.rotation) <= 1e-5
        for p, q in cuts
    )


def _place(pose: Pose) -> str:
    return f"{np.round(pose.position, 6).tolist()} {np.round(pose.quaternion(), 6).tolist()}"


def _words(arc: GraphArc) -> str:
    return f"an arc to {_place(arc.arc.end)} in {arc.parts}"
