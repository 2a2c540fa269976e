"""The acceptance tests of Sec. 4.2, stated plainly: valid nodes, feasible arcs, lifted fingers."""

from __future__ import annotations

import enum
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ModeDecision, Outcome
from gm_ompl.contact.environment import contact_state, environment_contacts
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.moves import Displacement, Regrasp
from gm_ompl.problem import Placements, Problem
from gm_ompl.reference.modes import Modes, decide_modes

Decide: TypeAlias = Callable[[Instant, Modes | None], ModeDecision]

_MEMO_DIGITS = 10
"""Contact states equal to so many digits, lengths against D, share one decision."""


class Finding(enum.Enum):
    """What a judgement found; the value is a sentence for the user."""

    HOLDS = "the manipulation is feasible"
    PENETRATION = "the object or a fingertip penetrates something"
    INTERNAL_FORCE = "every choice of modes could build up excessive internal force"
    NO_EQUILIBRIUM = "no choice of modes reaches equilibrium"
    TOO_WEAK = "the stability margin is below z_min"


_FINDINGS = {
    Outcome.INTERNAL_FORCE: Finding.INTERNAL_FORCE,
    Outcome.NO_EQUILIBRIUM: Finding.NO_EQUILIBRIUM,
    Outcome.BELOW: Finding.TOO_WEAK,
}


@dataclass(frozen=True)
class Verdict:
    """The judgement of one segment or one lifted finger.

    Attributes:
        finding: what was found.
        decision: Sec. 3.4's; None where the geometry already fails.
    """

    finding: Finding
    decision: ModeDecision | None


class ReferenceJudge:
    """Judges the nodes and arcs of one problem.

    Args:
        problem: whose nodes and arcs.
        decide: Sec. 3.4; the reference's own by default.
    """

    def __init__(self, problem: Problem, decide: Decide = decide_modes) -> None:
        self.problem = problem
        self.decisions = 0
        self._decide = decide
        obstacles = [obstacle.body for obstacle in problem.environment.obstacles]
        self._scene = Scene(problem.body, obstacles, problem.environment.floor)
        table = problem.fingers.placements
        self._centres = [table.centres(float(r)) for r in problem.fingers.radius]
        self._object: dict[Coordinates, bool] = {}
        self._contacts: dict[tuple[Coordinates, Coordinates | None], ContactState] = {}
        self._free: dict[tuple[Coordinates, int], BoolArray] = {}
        self._memo: dict[tuple[object, ...], ModeDecision] = {}

    def node_valid(self, q: Sequence[float], placements: Placements) -> bool:
        """Whether nothing penetrates anything with the object at ``q`` (d,)."""
        at = tuple(float(x) for x in q)
        if not self._object_free(at):
            return False
        if not all(self._free_placements(at, i)[p] for i, p in enumerate(placements)):
            return False
        return all(
            self._apart(i, placements[i], j, placements[j])
            for i, j in itertools.combinations(range(len(placements)), 2)
        )

    def segment(
        self, q: Sequence[float], dq: Sequence[float], placements: Placements,
        prefer: Modes | None = None,
    ) -> Verdict:  # fmt: skip
        """Judge the instant at ``q`` (d,) while the object moves in the direction ``dq`` (d,)."""
        if not self.node_valid(q, placements):
            return Verdict(Finding.PENETRATION, None)
        fingers = tuple(range(len(placements)))
        return self._verdict(self.contacts(q, dq), fingers, placements, prefer)

    def rest(self, q: Sequence[float], placements: Placements, lifted: int) -> Verdict:
        """Judge the object at rest at ``q`` (d,) with finger ``lifted`` off it."""
        fingers = tuple(i for i in range(len(placements)) if i != lifted)
        remaining = tuple(placements[i] for i in fingers)
        return self._verdict(self.contacts(q, None), fingers, remaining, None)

    def contacts(self, q: Sequence[float], dq: Sequence[float] | None) -> ContactState:
        """Return the environment contacts at ``q``, in motion along ``dq`` or at rest (None)."""
        key = (tuple(q), None if dq is None else tuple(dq))
        if key not in self._contacts:
            motion, body = self.problem.motion, self.problem.body
            pose = motion.pose(q)
            touching = environment_contacts(body, self.problem.environment, pose)
            twist = None if dq is None else motion.velocity(q, dq)
            self._contacts[key] = contact_state(touching, pose, twist, body)
        return self._contacts[key]

    def displacement(
        self, start: Coordinates, end: Coordinates, placements: Placements, segments: int
    ) -> Displacement | None:
        """Return the arc from ``start`` to ``end``, judged in equal segments, or None.

        Each segment is judged at its midpoint; the end nodes' validity is not part of the arc.
        """
        decisions: list[ModeDecision] = []
        dq = np.subtract(end, start)
        for j in range(segments):
            prefer = decisions[-1].modes if decisions else None
            q = start + dq * ((j + 0.5) / segments)
            verdict = self.segment(q.tolist(), dq.tolist(), placements, prefer)
            if verdict.finding is not Finding.HOLDS or verdict.decision is None:
                return None
            decisions.append(verdict.decision)
        cost = self.displacement_cost(start, end, placements, [d.z for d in decisions])
        return Displacement(start, end, placements, tuple(decisions), cost)

    def displacement_cost(
        self, start: Coordinates, end: Coordinates, placements: Placements, z: Sequence[float]
    ) -> float:
        """Return Eq. (9) for an arc whose equal segments have the margins ``z``."""
        dq = np.subtract(end, start)
        poses = [self.problem.motion.pose(start + dq * (j / len(z))) for j in range(len(z) + 1)]
        weights = [1.0 + _penalty(self.problem.cost.stability, z_j) for z_j in z]
        travels = [self._travel(poses, i, p) for i, p in enumerate(placements)]
        return max((float(np.dot(weights, travel)) for travel in travels), default=0.0)

    def regrasp(
        self, q: Coordinates, placements: Placements, finger: int, target: int
    ) -> Regrasp | None:
        """Return the arc on which ``finger`` goes to ``target``, or None.

        The head's validity is not part of the arc.
        """
        verdict = self.rest(q, placements, finger)
        if verdict.finding is not Finding.HOLDS or verdict.decision is None:
            return None
        cost = self.problem.cost.regrasp
        return Regrasp(q, finger, target, placements, verdict.decision, cost)

    def _verdict(
        self, contacts: ContactState, fingers: tuple[int, ...], placements: Placements,
        prefer: Modes | None,
    ) -> Verdict:  # fmt: skip
        decision = self._remembered(contacts, fingers, placements, prefer)
        if decision.outcome is Outcome.STABLE:
            strong = decision.z >= self.problem.mechanics.z_min
            return Verdict(Finding.HOLDS if strong else Finding.TOO_WEAK, decision)
        return Verdict(_FINDINGS[decision.outcome], decision)

    def _remembered(
        self, contacts: ContactState, fingers: tuple[int, ...], placements: Placements,
        prefer: Modes | None,
    ) -> ModeDecision:  # fmt: skip
        key = (_rounded(contacts, self.problem.body.diagonal), fingers, placements)
        plain = self._ask(contacts, fingers, placements, key, None)
        # Preferred modes matter in a tie alone, and then only if they did not win anyway.
        if prefer is None or plain.modes == prefer:
            return plain
        return self._ask(contacts, fingers, placements, key, prefer)

    def _ask(
        self, contacts: ContactState, fingers: tuple[int, ...], placements: Placements,
        key: tuple[object, ...], prefer: Modes | None,
    ) -> ModeDecision:  # fmt: skip
        full = (*key, prefer)
        if full not in self._memo:
            instant = self.problem.instant(contacts, fingers, placements)
            self._memo[full] = self._decide(instant, prefer)
            self.decisions += 1
        return self._memo[full]

    def _object_free(self, q: Coordinates) -> bool:
        if q not in self._object:
            self._object[q] = self._scene.object_free(self.problem.motion.pose(q))
        return self._object[q]

    def _free_placements(self, q: Coordinates, finger: int) -> BoolArray:
        """Return which placements are free for ``finger`` with the object at ``q``, (P,)."""
        key = (q, finger)
        if key not in self._free:
            pose = self.problem.motion.pose(q)
            self._free[key] = self._scene.free_placements(
                pose,
                self._centres[finger],
                float(self.problem.fingers.radius[finger]),
                self.problem.fingers.placements.piece,
            )
        return self._free[key]

    def _apart(self, i: int, p: int, j: int, q: int) -> bool:
        radius = self.problem.fingers.radius
        return bool(
            self._scene.tips_apart(
                self._centres[i][p : p + 1], float(radius[i]),
                self._centres[j][q : q + 1], float(radius[j]),
            )[0, 0]
        )  # fmt: skip

    def _travel(self, poses: Sequence[Pose], finger: int, placement: int) -> Array:
        """Return the chords of the fingertip centre's path between ``poses``."""
        path = np.array([pose.apply(self._centres[finger][placement]) for pose in poses])
        chords: Array = np.linalg.norm(np.diff(path, axis=0), axis=1)
        return chords


def _penalty(stability: float, z: float) -> float:
    if z == 0.0:
        return math.inf if stability > 0 else 0.0
    return stability / z


def _rounded(contacts: ContactState, length: float) -> bytes:
    """Return what the programs see of a contact state, as bytes."""
    parts = (contacts.points / length, contacts.normals, contacts.slip, contacts.rotation)
    # Adding 0 turns -0.0 into 0.0, whose bytes differ.
    return b"|".join((np.round(part, _MEMO_DIGITS) + 0.0).tobytes() for part in parts)
