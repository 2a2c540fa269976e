"""The judge: Sec. 4.2's questions about poses, arcs and instants.

Is a node valid, is an arc free throughout, does an instant hold under its motion, do the other
fingers hold when one is lifted. Geometry is asked first, then a ``Backend`` for Sec. 3.4.
"""

from __future__ import annotations

from collections.abc import Hashable
from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray
from gm_ompl.caches import Memo
from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.environment import (
    EnvironmentContacts,
    contact_state,
    environment_contacts,
)
from gm_ompl.feasibility.backends import Backend
from gm_ompl.feasibility.geometry import NodeGeometry, Passages
from gm_ompl.feasibility.keys import PoseClass, PoseClasses
from gm_ompl.feasibility.reach import Reach
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.swept import SweptScene
from gm_ompl.hand.spec import HandSpec
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.problem import Placements, Problem

if TYPE_CHECKING:
    from gm_ompl.hand.reach import HandReach
    from gm_ompl.motion.courses import Courses

LOOKS = (0.25, 0.5, 0.75)
"""Where along an arc, beside its ends, a hand's fingers are asked for; joint paths look closer."""

CONTACT_BYTES = 20_000
"""About what the contacts at a configuration take."""


def hand_reach(problem: Problem, hand: HandSpec) -> HandReach:
    """Return what ``hand`` reaches in a problem's world."""
    from gm_ompl.hand.model import HandModel
    from gm_ompl.hand.reach import HandReach

    environment, fingers = problem.environment, problem.fingers
    obstacles = [obstacle.body for obstacle in environment.obstacles]
    model = HandModel(hand, problem.body, obstacles, environment.floor)
    centres = [fingers.placements.centres(r) for r in fingers.radius.tolist()]
    return HandReach(model, centres, fingers.radius, problem.body.diagonal)


@final
class Judge:
    """Answers about one problem, remembered where they depend on the object alone.

    Attributes:
        problem: what is judged.
        scene: its object and what is fixed.
        backend: decides Sec. 3.4.
        clear: clear[i][j], (P, P) or None for i = j: whether fingertip i at a row and fingertip
            j at a column do not penetrate each other. Constant in the object frame.
        reach: answers about ways through the air.
        hand: answers about the hand's joints; None where there is no hand.
        configurations: poses whose geometry was asked for.
    """

    def __init__(self, problem: Problem, backend: Backend) -> None:
        self.problem, self.backend = problem, backend
        self.configurations = 0
        environment = problem.environment
        obstacles = [o.body for o in environment.obstacles]
        touching = environment.contact_tolerance
        self.scene = Scene(problem.body, obstacles, environment.floor, touching)
        self._swept = SweptScene(self.scene)
        hand = problem.fingers
        self._radii: list[float] = hand.radius.tolist()
        self._centres = {r: hand.placements.centres(r) for r in set(self._radii)}
        self._passages = Passages(problem, self.scene, self._swept, self._centres)
        self.reach = Reach(problem, self._centres)
        self.hand = None if problem.hand is None else hand_reach(problem, problem.hand)
        each = 400 + len(hand.placements) * len(set(hand.shapes))
        self._pose_classes = PoseClasses(problem)
        self._nodes = Memo[bytes | PoseClass, NodeGeometry](each)
        self._arcs = Memo[Hashable, NodeGeometry](each)
        self._touching = Memo[bytes, EnvironmentContacts](CONTACT_BYTES)
        self._environments = Memo[Hashable, int](each)

    def of_hand(self, problem: Problem, backend: Backend) -> Judge:
        """Return a judge of a problem that differs from this one's in the hand alone.

        Args:
            problem: the other problem.
            backend: this judge's, or one in which contact states have the same numbers.
        """
        other = Judge(problem, backend)
        other._touching, other._environments = self._touching, self._environments
        return other

    def least_distances(self) -> Array:
        """Return how far the centres of any two fingertips must be apart (n, n)."""
        return np.array(
            [[self.scene.least_distance(a, b) for b in self._radii] for a in self._radii]
        )

    @cached_property
    def clear(self) -> tuple[tuple[BoolArray | None, ...], ...]:
        """Which fingertips do not penetrate each other, see the class."""
        rows, kinds = len(self.problem.fingers.placements), len(self._centres)
        if len(self._radii) < 2:
            return ((None,),) * len(self._radii)
        limits.claim(
            float(kinds * rows) ** 2,
            f"the clearances of {rows:,} placements from each other",
            "lower fingers.placements.grid or name fewer fingers.placements.faces",
        )
        pairs: dict[tuple[float, float], BoolArray] = {}
        for a in self._centres:
            for b in self._centres:
                pairs[a, b] = self.scene.tips_apart(self._centres[a], a, self._centres[b], b)
        every = range(len(self._radii))
        return tuple(
            tuple(None if i == j else pairs[self._radii[i], self._radii[j]] for j in every)
            for i in every
        )

    @property
    def mode_decisions(self) -> int:
        """Mode decisions that the back end computed so far, for whomever it works."""
        return self.backend.decisions

    def centres(self, finger: int) -> Array:
        """Return the centres (P, 3) of fingertip ``finger`` at every placement, object frame."""
        return self._centres[self._radii[finger]]

    def node(self, pose: Pose) -> NodeGeometry:
        """Return what geometry says at ``pose``."""
        return self._nodes.of(pose.key, lambda: self._node(pose))

    def _node(self, pose: Pose) -> NodeGeometry:
        limits.check()
        self.configurations += 1
        pose_class = self._pose_classes.of(pose)
        if pose_class is None:
            return self._geometry(pose)
        return self._nodes.of(pose_class, lambda: self._geometry(pose))

    def along(self, arc: Arc) -> NodeGeometry:
        """Return what geometry says everywhere along ``arc``, its ends included."""
        return self._arcs.of(arc.key, lambda: self._along(arc))

    def _along(self, arc: Arc) -> NodeGeometry:
        limits.check()
        sweeps, start = arc.sweeps, self.node(arc.start)
        if all(s.keeps_level and self._pose_classes.alone(s) for s in sweeps):
            return start
        end = self.node(arc.end)
        if not (start.object_free and end.object_free):
            return start if end.object_free else end
        if not all(self._swept.object_free(sweep) for sweep in sweeps):
            blocked = np.zeros(len(self.problem.fingers.placements), dtype=bool)
            blocked.flags.writeable = False
            return NodeGeometry(False, (blocked,) * len(self._radii))
        masks: dict[tuple[float, int], BoolArray] = {}
        shapes = self.problem.fingers.shapes
        poses = [arc.pose(t) for t in LOOKS] if self.hand is not None else []
        for i, shape in enumerate(shapes):
            if shape not in masks:
                mask = start.free[i] & end.free[i]
                for sweep in sweeps:
                    rows = np.flatnonzero(mask)
                    centres = self._centres[shape[0]][rows]
                    mask[rows] = self._swept.free_placements(sweep, centres, shape[0])
                if self.hand is not None:
                    mask = self.hand.along(arc.key, poses, i, mask)
                mask.flags.writeable = False
                masks[shape] = mask
        return NodeGeometry(True, tuple(masks[shape] for shape in shapes))

    def passing(self, step: GraphArc, head: Pose) -> NodeGeometry:
        """Return what geometry says along an arc and at the node it leads to."""
        along, there = self.along(step.arc), self.node(head)
        both = tuple(a & b for a, b in zip(along.free, there.free, strict=True))
        return NodeGeometry(along.object_free and there.object_free, both)

    def passing_along(self, courses: Courses) -> tuple[BoolArray, BoolArray]:
        """Return what ``passing`` would of many screws of a hand without joints; not remembered.

        That is whether the object (m,) and which fingertips (m, n, P) are free.

        Raises:
            LimitError: a limit in force is reached.
        """
        self.configurations += len(courses.parts)
        return self._passages.along(courses)

    def refuse(self, arc: Arc | None, pose: Pose, finger: int, row: int) -> None:
        """Take a finger off a placement along an arc and beside a pose: its joints found no way."""
        assert self.hand is not None
        self.hand.refuse(None if arc is None else arc.key, pose, finger, row)
        self._nodes.clear()
        self._arcs.clear()

    def _geometry(self, pose: Pose) -> NodeGeometry:
        table = self.problem.fingers.placements
        object_free = self.scene.object_free(pose)
        masks: dict[float, BoolArray] = {}
        for radius, centres in self._centres.items():
            mask = np.zeros(len(table), dtype=bool)
            if object_free:
                mask = self.scene.free_placements(pose, centres, radius, table.piece)
            mask.flags.writeable = False
            masks[radius] = mask
        free = tuple(masks[r] for r in self._radii)
        if self.hand is not None:
            free = tuple(self.hand.mask(pose, i, mask) for i, mask in enumerate(free))
        return NodeGeometry(object_free, free)

    def apart(self, placements: Placements) -> bool:
        """Whether no two fingertips penetrate each other."""
        for i, row in enumerate(placements):
            for j in range(i):
                clear = self.clear[i][j]
                if clear is not None and not clear[row, placements[j]]:
                    return False
        return True

    def placements_valid(self, pose: Pose, placements: Placements) -> bool:
        """Whether the node (``pose``, ``placements``) is valid (Sec. 4.2): nothing penetrates."""
        return self.node(pose).admits(placements) and self.apart(placements)

    def environment(self, moment: Moment) -> int:
        """Return the back end's number for the contact state at ``moment``.

        At rest all contacts are static.
        """
        limits.check()
        return self._environments.of(moment.key, lambda: self._contact_state(moment))

    def environments(self, step: GraphArc) -> tuple[int, ...]:
        """Return the back end's numbers for the contact states in the middles of an arc."""
        limits.check()
        found = self.backend.environments(step.arc, step.parts)
        return tuple(map(self.environment, step.middles()) if found is None else found)

    def _contact_state(self, moment: Moment) -> int:
        pose_class = self._pose_classes.of_contacts(moment.pose)
        if pose_class is None:
            return self._register(moment)
        moving = None if moment.twist is None else moment.twist.direction
        return self._environments.of((pose_class, moving), lambda: self._register(moment))

    def _register(self, moment: Moment) -> int:
        pose, body = moment.pose, self.problem.body
        contacts = self._touching.of(
            pose.key, lambda: environment_contacts(body, self.problem.environment, pose)
        )
        return self.backend.environment(contact_state(contacts, pose, moment.twist, body))

    def segment(self, moment: Moment, placements: Placements, below: float = 0.0) -> Verdict:
        """Judge an instant, in motion or at rest: geometry there, then z >= z_min.

        Args:
            moment: the middle of a segment, or a rest of the whole hand.
            placements: per finger.
            below: a margin smaller than this need not be known exactly.
        """
        if not self.placements_valid(moment.pose, placements):
            return Verdict(Finding.GEOMETRY)
        fingers = tuple(range(len(placements)))
        decision = self.backend.decide(self.environment(moment), fingers, placements, below)
        return Verdict.of(decision, self.problem.mechanics.z_min)

    def rest(
        self,
        pose: Pose,
        fingers: tuple[int, ...],
        placements: Placements,
        below: float = 0.0,
    ) -> ModeDecision:
        """Return the best modes of ``fingers`` alone while the object rests at ``pose``.

        Args:
            pose: where the object is.
            fingers: the fingers that touch.
            placements: of those fingers (same length).
            below: a margin smaller than this need not be known exactly.
        """
        return self.backend.decide(self.environment(Moment(pose)), fingers, placements, below)
