"""Free motion: what the object reaches on the contact lattice, and what stops it."""

from __future__ import annotations

import heapq
import itertools
import math
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.deeds import AXES, doing
from gm_ompl.contact.environment import environment_contacts
from gm_ompl.diagnosis.free_values import DeedLine, Explored, Nearest, Place
from gm_ompl.diagnosis.instants import Explainer, parts_alone
from gm_ompl.diagnosis.regions import hit_on
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.geometry.polygon import convex_hull, plane_basis
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Moment
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.motion.screw import Screw
from gm_ompl.planfile.words import direction_in_words, pose_in_words
from gm_ompl.problem import Placements, Problem

POSES = 20_000
"""Poses looked at on geometry alone."""

HELD_POSES = 3000
"""The same where sets of placements must hold."""

RANKS = tuple(Finding)
"""A set that is refused later in this order comes closer; HOLDS is not refused."""


class Refusal(NamedTuple):
    """What blocks a set of placements on an arc.

    Attributes:
        moment: where, and in what motion.
        verdict: why.
    """

    moment: Moment
    verdict: Verdict


def refusal(explainer: Explainer, arc: GraphArc, placements: Placements) -> Refusal | None:
    """Return what blocks a set of placements on an arc first; None where it holds.

    Args:
        explainer: of the problem.
        arc: the arc.
        placements: per finger.
    """
    judge, z_min = explainer.judge, explainer.problem.mechanics.z_min
    if not judge.along(arc.arc).admits(placements):
        hit = arc.arc.moment(hit_on(judge, arc.arc, placements))
        return Refusal(hit, Verdict(Finding.GEOMETRY))
    for moment in arc.middles():
        verdict = judge.segment(moment, placements, z_min)
        if not verdict.holds:
            return Refusal(moment, verdict)
    return None


def place_of(problem: Problem, pose: Pose) -> Place:
    """Return where the object is, also in words."""
    words = pose_in_words(pose, problem.motion.pose(()))
    position, quaternion = pose.position.tolist(), pose.quaternion().tolist()
    return Place(tuple(position), tuple(quaternion), words)


def off_goal(problem: Problem, pose: Pose) -> float:
    """Return how far from the goal a pose is, in D and rad: 0 where the goal begins."""
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    goal = motion.goal
    distance = max(0.0, goal.position_error(pose) - goal.distance) / problem.body.diagonal
    return distance + max(0.0, goal.rotation_error(pose) - goal.angle)


@final
class Roaming:
    """What the object reaches from the start: breadth first and towards the goal by turns.

    Args:
        explainer: of the problem.
        sets: of placements; an arc is taken where one of them holds along it, as though fingers
            could change anywhere. None: the object goes wherever geometry lets it.

    Attributes:
        leaving: the arcs that leave poses looked at, by node.
        whole: whether nothing is left to look at.
    """

    def __init__(self, explainer: Explainer, sets: Sequence[Placements] | None = None) -> None:
        self._explainer, self._problem = explainer, explainer.problem
        self._graph, self._sets = explainer.problem.object_graph, sets
        self._turn: list[Placements] = list(sets or ())
        start = self._graph.start
        self._depths = {start: 0}
        self._broad, self._towards = deque([start]), list[tuple[float, int]]()
        self._blocked: dict[tuple[int, int], Finding] = {}
        self.leaving: dict[int, Sequence[GraphArc]] = {}
        self._push(start)

    @property
    def whole(self) -> bool:
        """Whether all that can be reached was looked at."""
        return len(self.leaving) == len(self._depths)

    def _push(self, node: int) -> None:
        off = off_goal(self._problem, self._graph.pose(node))
        heapq.heappush(self._towards, (off, node))

    def grow(self, most: int, stop: Callable[[], bool]) -> None:
        """Look at poses until so many were looked at, none is left, or ``stop`` says so."""
        try:
            for broad in itertools.cycle((True, False)):
                if len(self.leaving) >= most or stop() or self.whole:
                    return
                node = self._next(broad)
                if node is not None:
                    self._look(node)
        except LimitError:
            return

    def _next(self, broad: bool) -> int | None:
        """Return the next pose to look at, in one of the two orders; None where it has none."""
        while self._broad if broad else self._towards:
            node = self._broad.popleft() if broad else heapq.heappop(self._towards)[1]
            if node not in self.leaving:
                return node
        return None

    def _look(self, node: int) -> None:
        arcs = self._graph.arcs_from(node)
        found = [arc.head for arc in arcs if self._taken(node, arc)]
        self.leaving[node] = arcs
        for head in found:
            if head not in self._depths:
                self._depths[head] = self._depths[node] + 1
                self._broad.append(head)
                self._push(head)

    def _taken(self, node: int, arc: GraphArc) -> bool:
        """Whether some set holds along an arc; remember what blocks the one that comes closest."""
        if self._sets is None:
            return True
        closest = Finding.GEOMETRY
        for k, placements in enumerate(self._turn):
            refused = refusal(self._explainer, arc, placements)
            if refused is None:
                # Who holds here mostly holds on the next arc, too.
                self._turn.insert(0, self._turn.pop(k))
                return True
            closest = max(closest, refused.verdict.finding, key=RANKS.index)
        self._blocked[node, arc.head] = closest
        return False

    def explored(self, stop: Callable[[], bool]) -> Explored:
        """Return what was seen; contacts and deeds of as many poses as there is time for."""
        problem, graph = self._problem, self._graph
        nearest = min(self._depths, key=lambda node: off_goal(problem, graph.pose(node)))
        deeds, changes, contacts = DeedCounts(problem), Counter[str](), dict[int, str]()
        try:
            for node, arcs in self.leaving.items():
                if stop():
                    break
                contacts[node] = contacts_in_words(problem, graph.pose(node))
                for arc in arcs:
                    deeds.add(arc, self._blocked.get((node, arc.head)))
        except LimitError:
            pass
        for node in contacts:
            for arc in self.leaving[node]:
                there = contacts.get(arc.head)
                if (node, arc.head) not in self._blocked and there not in (None, contacts[node]):
                    changes[f"{contacts[node]} > {there}"] += 1
        return Explored(
            fingers=self._sets is not None,
            sets=len(self._turn),
            nodes=len(self._depths),
            arcs=sum(map(len, self.leaving.values())),
            whole=self.whole,
            arrived=graph.in_goal(nearest),
            nearest=_near(problem, graph.pose(nearest), self._depths[nearest]),
            deeds=deeds.lines(self._sets is not None),
            contacts=dict(Counter(contacts.values()).most_common()),
            changes=dict(changes.most_common()),
            borders=tuple(_borders(problem, map(graph.pose, self._depths))),
        )


@final
class DeedCounts:
    """Arcs counted by what the object does.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._names: dict[object, str] = {}
        self._seen = Counter[str]()
        self._blocked: dict[str, Counter[Finding]] = {}

    def add(self, arc: GraphArc, blocked: Finding | None) -> None:
        """Count an arc, and what blocks it."""
        name = self._named(arc)
        self._seen[name] += 1
        if blocked is not None:
            self._blocked.setdefault(name, Counter())[blocked] += 1

    def _named(self, arc: GraphArc) -> str:
        known = None if arc.kind is None else self._names.get(arc.kind)
        if known is None:
            screw, problem = arc.arc, self._problem
            assert isinstance(screw, Screw), "the contact lattice holds screws"
            known = deed_in_words(screw, problem)
            if arc.kind is not None:
                self._names[arc.kind] = known
        return known

    def lines(self, fingers: bool) -> tuple[DeedLine, ...]:
        """Return the counts, the most frequent first."""
        found = []
        for name, count in self._seen.most_common():
            blocked = self._blocked.get(name, Counter[Finding]())
            holding = count - blocked.total() if fingers else 0
            findings = {finding.name.lower(): n for finding, n in blocked.most_common()}
            found.append(DeedLine(name, count, holding, findings))
        return tuple(found)


def deed_in_words(arc: Screw, problem: Problem) -> str:
    """Return "slides along x", "tumbles about y"; whichever way, however far."""
    deed = doing(arc, problem.body, problem.environment).deed
    sweep = arc.sweeps[0]
    way = sweep.axis if sweep.angle else sweep.drift / (np.linalg.norm(sweep.drift) or 1.0)
    k = int(np.argmax(np.abs(way)))
    name = direction_in_words((way * math.copysign(1.0, way[k])).tolist())
    return f"{deed.value} {deed.preposition} {name.lstrip('+')}"


def contacts_in_words(problem: Problem, pose: Pose) -> str:
    """Return what of the object touches what: "floor: face, wall: edge"."""
    parts = []
    for name, part in parts_alone(problem.environment):
        found = environment_contacts(problem.body, part, pose)
        points, normals = found.points[: found.corners], found.normals[: found.corners]
        if len(points):
            parts.append(f"{name}: {_shape(points, normals, problem)}")
    return ", ".join(parts) or "in the air"


def _shape(points: Array, normals: Array, problem: Problem) -> str:
    flat = [(x, y) for x, y in (points @ plane_basis(normals[0]).T).tolist()]
    near = problem.environment.contact_tolerance * problem.body.diagonal
    return ("corner", "edge", "face")[min(len(convex_hull(flat, near)), 3) - 1]


def _near(problem: Problem, pose: Pose, arcs: int) -> Nearest:
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    angle = math.degrees(motion.goal.rotation_error(pose))
    return Nearest(motion.goal.position_error(pose), angle, place_of(problem, pose), arcs)


def _borders(problem: Problem, poses: Iterator[Pose]) -> Iterator[str]:
    """Yield the region's borders, of the listed axes, that poses come nearer to than a step."""
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    positions = np.array([pose.position for pose in poses])
    step, (low, high) = motion.steps.translation, motion.region
    for k in motion.steps.translate:
        if high[k] <= low[k]:
            continue
        if positions[:, k].min() < low[k] + step * (1.0 - 1e-9):
            yield f"{AXES[k]} = {low[k]:g}"
        if positions[:, k].max() > high[k] - step * (1.0 - 1e-9):
            yield f"{AXES[k]} = {high[k]:g}"
