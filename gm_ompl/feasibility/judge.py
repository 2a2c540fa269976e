"""The judge: Sec. 4.2's questions at any continuous coordinates.

Is a node valid, does a segment hold under a direction of motion, do the other fingers hold when
one is lifted. Geometry is asked first, then a ``Backend`` for Sec. 3.4.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import TypeVar, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.environment import (
    EnvironmentContacts,
    contact_state,
    environment_contacts,
)
from gm_ompl.feasibility.backend import Backend
from gm_ompl.feasibility.situation import Situation, Situations
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements, Problem

REMEMBERED_BYTES = 100_000_000
"""Geometry kept, by the size of its masks; beyond, all is dropped and made again on demand."""

REMEMBERED_CONTACTS = 4096
"""Configurations whose contacts are kept: they are asked for again at once, or hardly ever."""

Key = TypeVar("Key")
Value = TypeVar("Value")


@dataclass(frozen=True, eq=False)
class NodeGeometry:
    """What geometry alone says at one configuration of the object.

    Attributes:
        object_free: whether the object penetrates nothing.
        free: per finger, (P,), the placements at which its fingertip penetrates neither
            environment nor object; fingers of equal radius share one array.
    """

    object_free: bool
    free: tuple[BoolArray, ...]

    def admits(self, placements: Placements) -> bool:
        """Whether object and fingertips are free, the fingertips' mutual clearance left aside."""
        return self.object_free and all(
            mask[row] for mask, row in zip(self.free, placements, strict=True)
        )


@final
class Judge:
    """Answers about one problem, remembered where they depend on the object alone.

    Attributes:
        problem: what is judged.
        backend: decides Sec. 3.4.
        clear: clear[i][j], (P, P) or None for i = j: whether fingertip i at a row and fingertip
            j at a column do not penetrate each other. Constant in the object frame.
        configurations: configurations whose geometry was asked for.
    """

    def __init__(self, problem: Problem, backend: Backend) -> None:
        self.problem, self.backend = problem, backend
        self.configurations = 0
        environment = problem.environment
        self._scene = Scene(
            problem.body, [o.body for o in environment.obstacles], environment.floor
        )
        hand = problem.fingers
        self._radii: list[float] = hand.radius.tolist()
        self._centres = {r: hand.placements.centres(r) for r in set(self._radii)}
        self.clear = self._clearances()
        each = 400 + len(hand.placements) * len(self._centres)
        self._limit = max(1000, REMEMBERED_BYTES // each)
        self._situations = Situations(problem)
        self._nodes: dict[Coordinates | Situation, NodeGeometry] = {}
        self._touching: dict[Coordinates, EnvironmentContacts] = {}
        self._environments: dict[Hashable, int] = {}

    def _clearances(self) -> tuple[tuple[BoolArray | None, ...], ...]:
        pairs: dict[tuple[float, float], BoolArray] = {}
        for a in self._centres:
            for b in self._centres:
                pairs[a, b] = self._scene.tips_apart(self._centres[a], a, self._centres[b], b)
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

    def node(self, q: Coordinates) -> NodeGeometry:
        """Return what geometry says at ``q``."""
        known = self._nodes.get(q)
        if known is None:
            self.configurations += 1
            pose = self.problem.motion.pose(q)
            situation = self._situations.of(pose)
            if situation is not None:
                known = self._nodes.get(situation)
            if known is None:
                known = self._geometry(pose)
                if situation is not None:
                    _remember(self._nodes, situation, known, self._limit)
            _remember(self._nodes, q, known, self._limit)
        return known

    def _geometry(self, pose: Pose) -> NodeGeometry:
        table = self.problem.fingers.placements
        object_free = self._scene.object_free(pose)
        masks: dict[float, BoolArray] = {}
        for radius, centres in self._centres.items():
            mask = np.zeros(len(table), dtype=bool)
            if object_free:
                mask = self._scene.free_placements(pose, centres, radius, table.piece)
            mask.flags.writeable = False
            masks[radius] = mask
        return NodeGeometry(object_free, tuple(masks[r] for r in self._radii))

    def apart(self, placements: Placements) -> bool:
        """Whether no two fingertips penetrate each other."""
        for i, row in enumerate(placements):
            for j in range(i):
                clear = self.clear[i][j]
                if clear is not None and not clear[row, placements[j]]:
                    return False
        return True

    def placements_valid(self, q: Coordinates, placements: Placements) -> bool:
        """Whether the node (``q``, ``placements``) is valid (Sec. 4.2): nothing penetrates."""
        return self.node(q).admits(placements) and self.apart(placements)

    def environment(self, q: Coordinates, dq: Coordinates | None) -> int:
        """Return the back end's number for the contact state at ``q``.

        Args:
            q: the object's coordinates.
            dq: the direction of motion; None at rest, where all contacts are static.
        """
        key = (q, dq)
        known = self._environments.get(key)
        if known is None:
            motion = self.problem.motion
            pose, twist = motion.pose(q), None if dq is None else motion.velocity(q, dq)
            known = self._contact_state(q, pose, twist)
            _remember(self._environments, key, known, self._limit)
        return known

    def _contact_state(self, q: Coordinates, pose: Pose, twist: Twist | None) -> int:
        situation = self._situations.of(pose)
        if situation is None:
            return self._register(q, pose, twist)
        moving = None if twist is None else (twist.linear.tobytes(), twist.angular.tobytes())
        known = self._environments.get((situation, moving))
        if known is None:
            known = self._register(q, pose, twist)
            _remember(self._environments, (situation, moving), known, self._limit)
        return known

    def _register(self, q: Coordinates, pose: Pose, twist: Twist | None) -> int:
        state = contact_state(self._contacts(q, pose), pose, twist, self.problem.body)
        return self.backend.environment(state)

    def _contacts(self, q: Coordinates, pose: Pose) -> EnvironmentContacts:
        """Return where the object touches at ``q``, whichever way it moves."""
        known = self._touching.get(q)
        if known is None:
            known = environment_contacts(self.problem.body, self.problem.environment, pose)
            _remember(self._touching, q, known, REMEMBERED_CONTACTS)
        return known

    def segment(
        self, q_mid: Coordinates, dq: Coordinates, placements: Placements, below: float = 0.0
    ) -> Verdict:
        """Judge a motion segment at its midpoint: geometry, then z >= z_min.

        Args:
            q_mid: coordinates of the segment's midpoint.
            dq: the direction of motion.
            placements: per finger.
            below: a margin smaller than this need not be known exactly.
        """
        if not self.placements_valid(q_mid, placements):
            return Verdict(Finding.GEOMETRY)
        fingers = tuple(range(len(placements)))
        environment = self.environment(q_mid, dq)
        decision = self.backend.decide(environment, fingers, placements, below)
        return Verdict.of(decision, self.problem.mechanics.z_min)

    def rest(
        self,
        q: Coordinates,
        fingers: tuple[int, ...],
        placements: Placements,
        below: float = 0.0,
    ) -> ModeDecision:
        """Return the best modes of ``fingers`` alone while the object rests at ``q``.

        Args:
            q: the object's coordinates.
            fingers: the fingers that touch.
            placements: of those fingers (same length).
            below: a margin smaller than this need not be known exactly.
        """
        return self.backend.decide(self.environment(q, None), fingers, placements, below)


def _remember(memo: dict[Key, Value], key: Key, value: Value, limit: int) -> None:
    if len(memo) >= limit:
        memo.clear()
    memo[key] = value
