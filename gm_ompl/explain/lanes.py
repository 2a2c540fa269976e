"""One set of placements along a path: where it first fails, from the start and from the goal."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np

from gm_ompl.explain.instants import Explainer
from gm_ompl.explain.values import InstantLine, SetLine, Stretch
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.motion.arc import Moment
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.problem import Placements, Problem

LOOKS = (16, 128, 1024)
"""Places looked at on an arc that is blocked between its midpoints."""


def names(problem: Problem, placements: Placements) -> tuple[str, ...]:
    """Return "FACE:[i, j]" per finger."""
    table = problem.fingers.placements
    return tuple(
        f"{table.labels[int(table.face[row])]}:{table.cell[row].tolist()}" for row in placements
    )


def ends(problem: Problem) -> tuple[int, int]:
    """Return the start's node and the goal's nearest node of a path.

    Raises:
        InputError: the start or the goal is off the lattice.
    """
    graph = problem.object_graph
    goals, start = graph.goal_nodes, graph.start
    assert goals, "a path's goal is on its lattice"
    return start, min(goals, key=lambda node: abs(node - start))


def scan(
    explainer: Explainer, placements: Placements, backwards: bool, quick: bool = True
) -> Iterator[tuple[Coordinates, Coordinates, Verdict]]:
    """Yield (q, direction, verdict) from the start to the goal, or in the other order.

    Nodes and arcs are judged by geometry, arcs throughout, and segments at their midpoints. The
    motion is always the one from start to goal.

    Args:
        explainer: of the problem.
        placements: per finger.
        backwards: whether to come back from the goal.
        quick: whether margins below z_min may be bounds.
    """
    problem, judge = explainer.problem, explainer.judge
    start, goal = ends(problem)
    P, axis = problem.cost.samples_per_arc, problem.lattice.axes[0]
    step = 1 if goal >= start else -1
    below = problem.mechanics.z_min if quick else 0.0
    places: list[tuple[Coordinates, Moment | None]] = [((float(axis[start]),), None)]
    direction: Coordinates = (float(step),)
    for k in range(start, goal, step):
        tail, head = (float(axis[k]),), (float(axis[k + step]),)
        direction = (head[0] - tail[0],)
        hit = blocked_at(explainer, tail, head, placements)
        if hit is not None:
            places.append((hit, None))
        middles = problem.motion.arc(tail, head).middles(P)
        places += [(between(tail, head, (2 * j + 1) / (2 * P)), m) for j, m in enumerate(middles)]
        places.append((head, None))
    for q, moment in reversed(places) if backwards else places:
        if moment is not None:
            yield q, direction, judge.segment(moment, placements, below)
        elif not judge.placements_valid(problem.motion.pose(q), placements):
            yield q, direction, Verdict(Finding.GEOMETRY)


def blocked_at(
    explainer: Explainer, tail: Coordinates, head: Coordinates, placements: Placements
) -> Coordinates | None:
    """Return where something penetrates on an arc that no node and no midpoint shows.

    None where the arc is free, or where its ends or midpoints tell already.
    """
    problem, judge = explainer.problem, explainer.judge
    arc, P = problem.motion.arc(tail, head), problem.cost.samples_per_arc
    if judge.along(arc).admits(placements):
        return None
    shown = (arc.start, arc.end, *(moment.pose for moment in arc.middles(P)))
    if not all(judge.placements_valid(pose, placements) for pose in shown):
        return None
    for count in LOOKS:
        for k in range(count):
            t = (k + 0.5) / count
            if not judge.placements_valid(arc.pose(t), placements):
                return between(tail, head, t)
    return between(tail, head, 0.5)


def first_failure(
    explainer: Explainer, placements: Placements, backwards: bool
) -> InstantLine | None:
    """Return the first instant that fails, z exact; None where all hold."""
    for q, direction, verdict in scan(explainer, placements, backwards):
        if not verdict.holds:
            if verdict.decision is not None:
                verdict = explainer.verdict(q, direction, placements)
            return explainer.line(q, direction, placements, verdict)
    return None


def whole_lane(explainer: Explainer, placements: Placements) -> SetLine:
    """Return all that blocks a set of placements along the path."""
    lines = []
    for q, direction, verdict in scan(explainer, placements, backwards=False, quick=False):
        lines.append(explainer.line(q, direction, placements, verdict))
    failing = [line for line in lines if line.finding is not Finding.HOLDS]
    ratios = [line.ratio for line in lines if line.ratio is not None]
    return SetLine(
        placements=names(explainer.problem, placements),
        holds=not failing,
        forward=failing[0] if failing else None,
        backward=failing[-1] if failing else None,
        stretches=tuple(_stretches(lines)),
        ratio=min(ratios, default=None),
        lifts=_lifts(explainer, placements, failing[0]) if failing else (),
    )


def _stretches(lines: list[InstantLine]) -> Iterator[Stretch]:
    for (finding, blocked), group in groupby(lines, key=lambda g: (g.finding, g.blocked_by)):
        if finding is Finding.HOLDS:
            continue
        part = list(group)
        ratios = [line.ratio for line in part if line.ratio is not None]
        yield Stretch(part[0].q[0], part[-1].q[0], finding, blocked, min(ratios, default=None))


def _lifts(
    explainer: Explainer, placements: Placements, failure: InstantLine
) -> tuple[float | None, ...]:
    """Return per finger z / z_min of the others at rest, at the last node before a failure."""
    problem = explainer.problem
    start, goal = ends(problem)
    axis = problem.lattice.axes[0]
    before = axis[min(start, goal) : max(start, goal) + 1]
    before = before[before <= failure.q[0]] if goal >= start else before[before >= failure.q[0]]
    if not len(before):
        return ()
    at: Coordinates = (float(before[-1] if goal >= start else before[0]),)
    pose = problem.motion.pose(at)
    if not explainer.judge.placements_valid(pose, placements):
        return ()
    found = []
    for i in range(len(placements)):
        others = tuple(j for j in range(len(placements)) if j != i)
        rows = tuple(placements[j] for j in others)
        decision = explainer.judge.rest(pose, others, rows)
        found.append(explainer.ratio(Verdict.of(decision, problem.mechanics.z_min)))
    return tuple(found)


def progress(problem: Problem, line: InstantLine | None, backwards: bool) -> float:
    """Return the part of the path (0 to 1) that holds before a failure."""
    if line is None:
        return 1.0
    axis = problem.lattice.axes[0]
    start, goal = ends(problem)
    origin = float(axis[goal] if backwards else axis[start])
    length = abs(float(axis[goal] - axis[start])) or 1.0
    return float(np.clip(abs(line.q[0] - origin) / length, 0.0, 1.0))
