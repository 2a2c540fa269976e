"""The acceptance tests of Sec. 4.2, stated plainly: valid nodes, feasible arcs, lifted fingers."""

from __future__ import annotations

import enum
import itertools
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import BoolArray
from gm_ompl.contact.decision import ModeDecision, Outcome
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.motion.object_graph import GraphArc, Way
from gm_ompl.problem import Displacement, Placements, Problem, Regrasp
from gm_ompl.reference.modes import Modes, decide_modes
from gm_ompl.reference.swept import SweptJudge

Decide: TypeAlias = Callable[[Instant, Modes | None], ModeDecision]

_MEMO_DIGITS = 10
"""Contact states equal to so many digits, lengths against D, share one decision."""


class Ruling(enum.Enum):
    """What a judgement found; the value is a sentence for the user."""

    HOLDS = "the manipulation is feasible"
    PENETRATION = "the object or a fingertip penetrates something"
    INTERNAL_FORCE = "every choice of modes could build up excessive internal force"
    NO_EQUILIBRIUM = "no choice of modes reaches equilibrium"
    TOO_WEAK = "the stability margin is below z_min"


_FINDINGS = {
    Outcome.INTERNAL_FORCE: Ruling.INTERNAL_FORCE,
    Outcome.NO_EQUILIBRIUM: Ruling.NO_EQUILIBRIUM,
    Outcome.BELOW: Ruling.TOO_WEAK,
}


@dataclass(frozen=True)
class Judgement:
    """The judgement of one segment or one lifted finger.

    Attributes:
        finding: what was found.
        decision: Sec. 3.4's; None where the geometry already fails.
    """

    finding: Ruling
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
        floor, touching = problem.environment.floor, problem.environment.contact_tolerance
        self._scene = Scene(problem.body, obstacles, floor, touching)
        table = problem.fingers.placements
        self._centres = [table.centres(float(r)) for r in problem.fingers.radius]
        self._swept = SweptJudge(problem.body, tuple(obstacles), floor, touching)
        self._object: dict[bytes, bool] = {}
        self._contacts: dict[Hashable, ContactState] = {}
        self._free: dict[tuple[bytes, int], BoolArray] = {}
        self._along: dict[Hashable, bool] = {}
        self._memo: dict[tuple[object, ...], ModeDecision] = {}

    def node_valid(self, pose: Pose, placements: Placements) -> bool:
        """Whether nothing penetrates anything with the object at ``pose``."""
        if not self._object_free(pose):
            return False
        if not all(self._free_placements(pose, i)[p] for i, p in enumerate(placements)):
            return False
        return all(
            self._apart(i, placements[i], j, placements[j])
            for i, j in itertools.combinations(range(len(placements)), 2)
        )

    def arc_free(self, arc: Arc, placements: Placements) -> bool:
        """Whether object and fingertips penetrate no environment anywhere along ``arc``."""
        if arc.key not in self._along:
            self._along[arc.key] = self._swept.object_blocked(arc) is None
        if not self._along[arc.key]:
            return False
        return all(self._tip_free(arc, i, p) for i, p in enumerate(placements))

    def _tip_free(self, arc: Arc, finger: int, placement: int) -> bool:
        radius, key = float(self.problem.fingers.radius[finger]), (arc.key, finger, placement)
        if key not in self._along:
            centre = self._centres[finger][placement]
            self._along[key] = self._swept.tip_blocked(arc, centre, radius) is None
        return self._along[key]

    def segment(
        self, moment: Moment, placements: Placements, prefer: Modes | None = None
    ) -> Judgement:
        """Judge an instant of the object's motion."""
        if not self.node_valid(moment.pose, placements):
            return Judgement(Ruling.PENETRATION, None)
        fingers = tuple(range(len(placements)))
        return self._verdict(self.contacts(moment), fingers, placements, prefer)

    def rest(self, pose: Pose, placements: Placements, lifted: int) -> Judgement:
        """Judge the object at rest at ``pose`` with finger ``lifted`` off it."""
        fingers = tuple(i for i in range(len(placements)) if i != lifted)
        remaining = tuple(placements[i] for i in fingers)
        return self._verdict(self.contacts(Moment(pose)), fingers, remaining, None)

    def contacts(self, moment: Moment) -> ContactState:
        """Return the environment contacts at ``moment``."""
        if moment.key not in self._contacts:
            body, environment = self.problem.body, self.problem.environment
            self._contacts[moment.key] = contacts_at(moment, body, environment)
        return self._contacts[moment.key]

    def decisions_along(
        self, arc: GraphArc, placements: Placements
    ) -> tuple[ModeDecision, ...] | None:
        """Return the decisions of an arc's segments; None where it fails.

        It is swept, and each segment judged at its midpoint; that fingertips are clear of each
        other and of the object is said by the end nodes' validity, which is not part of the arc.
        """
        decisions: list[ModeDecision] = []
        for moment in arc.middles():
            prefer = decisions[-1].modes if decisions else None
            verdict = self.segment(moment, placements, prefer)
            if verdict.finding is not Ruling.HOLDS or verdict.decision is None:
                return None
            decisions.append(verdict.decision)
        return tuple(decisions) if self.arc_free(arc.arc, placements) else None

    def displacement(self, way: Way, k: int, placements: Placements) -> Displacement | None:
        """Return arc ``k`` of a way as a move, or None where it fails."""
        arc = way.arcs[k]
        decisions = self.decisions_along(arc, placements)
        if decisions is None:
            return None
        cost = self.displacement_cost(arc.arc, placements, [d.z for d in decisions])
        ends = way.coordinates[k], way.coordinates[k + 1]
        return Displacement(arc.arc, *ends, placements, decisions, cost)

    def displacement_cost(self, arc: Arc, placements: Placements, z: Sequence[float]) -> float:
        """Return Eq. (9) for an arc whose equal segments have the margins ``z``."""
        X_stab, floor = self.problem.cost.stability, self.problem.z_floor
        weights = [1.0 + X_stab / max(z_j, floor) for z_j in z]
        travels = [
            arc.chords(self._centres[i][p : p + 1], len(z))[:, 0] for i, p in enumerate(placements)
        ]
        return max((float(np.dot(weights, travel)) for travel in travels), default=0.0)

    def regrasp(
        self, way: Way, k: int, placements: Placements, finger: int, target: int
    ) -> Regrasp | None:
        """Return the arc on which ``finger`` goes to ``target`` at place ``k`` of a way, or None.

        The head's validity is not part of the arc.
        """
        pose = way.poses[k]
        verdict = self.rest(pose, placements, finger)
        if verdict.finding is not Ruling.HOLDS or verdict.decision is None:
            return None
        cost = self.problem.cost.regrasp
        at = way.coordinates[k]
        return Regrasp(pose, at, finger, target, placements, verdict.decision, cost)

    def _verdict(
        self, contacts: ContactState, fingers: tuple[int, ...], placements: Placements,
        prefer: Modes | None,
    ) -> Judgement:  # fmt: skip
        decision = self._remembered(contacts, fingers, placements, prefer)
        if decision.outcome is Outcome.STABLE:
            strong = decision.z >= self.problem.mechanics.z_min
            return Judgement(Ruling.HOLDS if strong else Ruling.TOO_WEAK, decision)
        return Judgement(_FINDINGS[decision.outcome], decision)

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

    def _object_free(self, pose: Pose) -> bool:
        if pose.key not in self._object:
            self._object[pose.key] = self._scene.object_free(pose)
        return self._object[pose.key]

    def _free_placements(self, pose: Pose, finger: int) -> BoolArray:
        """Return which placements are free for ``finger`` with the object at ``pose``, (P,)."""
        key = (pose.key, finger)
        if key not in self._free:
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


def _rounded(contacts: ContactState, length: float) -> bytes:
    """Return what the programs see of a contact state, as bytes."""
    parts = (
        contacts.points / length, contacts.normals, contacts.slip, contacts.rotation,
        contacts.surfaces.astype(np.float64),
    )  # fmt: skip
    # Adding 0 turns -0.0 into 0.0, whose bytes differ.
    return b"|".join((np.round(part, _MEMO_DIGITS) + 0.0).tobytes() for part in parts)
