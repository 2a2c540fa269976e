"""One set of placements: where it fails along a path, and the nodes that it reaches."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from itertools import groupby
from typing import final

import numpy as np

from gm_ompl.diagnosis.instants import Explainer
from gm_ompl.diagnosis.values import InstantLine, SetLine, Stretch
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.motion.arc import Arc, Moment
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
    explainer: Explainer, placements: Placements
) -> Iterator[tuple[Coordinates, Coordinates, Verdict]]:
    """Yield (q, direction, verdict) from the start to the goal.

    Nodes and arcs are judged by geometry, arcs throughout, and segments at their midpoints.
    """
    problem, judge = explainer.problem, explainer.judge
    start, goal = ends(problem)
    P, axis = problem.cost.samples_per_arc, problem.lattice.axes[0]
    step = 1 if goal >= start else -1
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
    for q, moment in places:
        if moment is not None:
            yield q, direction, judge.segment(moment, placements)
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
    return between(tail, head, hit_on(judge, arc, placements))


def hit_on(judge: Judge, arc: Arc, placements: Placements) -> float:
    """Return t where something penetrates on an arc that is blocked; its middle if none shows."""
    ends = (0.0, 1.0)
    looks = ((k + 0.5) / count for count in LOOKS for k in range(count))
    hits = (t for t in (*ends, *looks) if not judge.placements_valid(arc.pose(t), placements))
    return next(hits, 0.5)


def whole_lane(explainer: Explainer, placements: Placements) -> SetLine:
    """Return all that blocks a set of placements along the path."""
    lines = []
    for q, direction, verdict in scan(explainer, placements):
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
    )


def _stretches(lines: list[InstantLine]) -> Iterator[Stretch]:
    for (finding, blocked), group in groupby(lines, key=lambda g: (g.finding, g.blocked_by)):
        if finding is Finding.HOLDS:
            continue
        part = list(group)
        ratios = [line.ratio for line in part if line.ratio is not None]
        yield Stretch(part[0].q[0], part[-1].q[0], finding, blocked, min(ratios, default=None))


NODES = 1500
"""Nodes visited per set and end."""


@final
class Region:
    """What one set of placements reaches from the start, or what reaches the goal with it.

    Args:
        explainer: of the problem.
        placements: per finger.
        backwards: whether to go against the arcs, from the goal's nodes.

    Attributes:
        nodes: those visited.
        blocked: the failing instant nearest to the other end; None where nothing failed.
        arrived: whether the other end was reached.
        cut_short: whether the visit stopped at ``NODES``, or was stopped.
    """

    def __init__(self, explainer: Explainer, placements: Placements, backwards: bool) -> None:
        problem = explainer.problem
        self._explainer, self._placements, self._backwards = explainer, placements, backwards
        goals, start = problem.object_graph.goal_nodes, problem.object_graph.start
        assert goals, "a lattice's goal lies on it"
        sources, ends = (goals, (start,)) if backwards else ((start,), goals)
        self._ends = np.array([problem.lattice.coordinates(node) for node in ends])
        self._extent = np.array([float(np.ptp(axis)) or 1.0 for axis in problem.lattice.axes])
        self._failure: tuple[float, Coordinates, Coordinates, Verdict] | None = None
        self.nodes = self._valid(sources)
        queue = deque(self.nodes)
        while queue and len(self.nodes) < NODES and not explainer.stop():
            for node in self._next(queue.popleft()):
                self.nodes.add(node)
                queue.append(node)
        self.cut_short = bool(queue)
        self.arrived = any(node in self.nodes for node in ends)

    def _valid(self, sources: tuple[int, ...]) -> set[int]:
        lattice, judge = self._explainer.problem.lattice, self._explainer.judge
        valid = set()
        for node in sources:
            q = lattice.coordinates(node)
            if judge.placements_valid(self._explainer.problem.motion.pose(q), self._placements):
                valid.add(node)
            else:
                self._note(q, q, Verdict(Finding.GEOMETRY))
        return valid

    def _next(self, node: int) -> Iterator[int]:
        """Yield the new nodes that an arc joins to ``node``; remember failures."""
        lattice = self._explainer.problem.lattice
        here = lattice.coordinates(node)
        for other, there in lattice.neighbours(node):
            tail, head = (there, here) if self._backwards else (here, there)
            if other not in self.nodes and self._holds(tail, head, there):
                yield other

    def _holds(self, tail: Coordinates, head: Coordinates, new: Coordinates) -> bool:
        problem, judge = self._explainer.problem, self._explainer.judge
        direction = tuple(b - a for a, b in zip(tail, head, strict=True))
        P = problem.cost.samples_per_arc
        if not judge.placements_valid(problem.motion.pose(new), self._placements):
            self._note(new, direction, Verdict(Finding.GEOMETRY))
            return False
        hit = blocked_at(self._explainer, tail, head, self._placements)
        if hit is not None:
            self._note(hit, direction, Verdict(Finding.GEOMETRY))
            return False
        for j, moment in enumerate(problem.motion.arc(tail, head).middles(P)):
            q = between(tail, head, (2 * j + 1) / (2 * P))
            verdict = judge.segment(moment, self._placements, problem.mechanics.z_min)
            if not verdict.holds:
                self._note(q, direction, verdict)
                return False
        return True

    def _note(self, q: Coordinates, direction: Coordinates, verdict: Verdict) -> None:
        distance = self.distance(q)
        if self._failure is None or distance < self._failure[0]:
            self._failure = (distance, q, direction, verdict)

    def distance(self, q: Coordinates) -> float:
        """Return how far ``q`` is from the other end, in parts of the axes' extents."""
        steps = np.abs(self._ends - np.array(q)) / self._extent
        for d, period in enumerate(self._explainer.problem.lattice.periods):
            if period is not None:
                turn = period / self._extent[d]
                steps[:, d] = np.minimum(steps[:, d] % turn, turn - steps[:, d] % turn)
        return float(steps.max(axis=1).min())

    @property
    def nearest(self) -> float:
        """How far the nearest node visited is from the other end; +inf where there is none."""
        lattice = self._explainer.problem.lattice
        return min(
            (self.distance(lattice.coordinates(node)) for node in self.nodes), default=np.inf
        )

    def failure(self) -> InstantLine | None:
        """Return the failing instant nearest to the other end; None where it was reached."""
        if self.arrived or self._failure is None:
            return None
        _, q, direction, verdict = self._failure
        if verdict.decision is not None:
            verdict = self._explainer.verdict(q, direction, self._placements)
        return self._explainer.line(q, direction, self._placements, verdict)


def whole_region(explainer: Explainer, placements: Placements) -> SetLine:
    """Return what blocks a set of placements in the plane, from the start and from the goal."""
    ahead = Region(explainer, placements, backwards=False)
    back = Region(explainer, placements, backwards=True)
    forward, backward = ahead.failure(), back.failure()
    ratios = [x.ratio for x in (forward, backward) if x is not None and x.ratio is not None]
    return SetLine(
        placements=names(explainer.problem, placements),
        holds=ahead.arrived,
        forward=forward,
        backward=backward,
        ratio=min(ratios, default=None),
        nodes_from_start=len(ahead.nodes),
        nodes_to_goal=len(back.nodes),
        cut_short=ahead.cut_short and not ahead.arrived,
    )
