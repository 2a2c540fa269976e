"""Whether a hand's motors can hold the object where a plan's moves are judged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.environment import contacts_at
from gm_ompl.hand.efforts import Efforts
from gm_ompl.hand.model import HandModel
from gm_ompl.hand.paths import JointRefusal
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Displacement, Move, Problem, Regrasp
from gm_ompl.reference.statics import statics
from gm_ompl.reference.torques import ROOM, Motors, least_share, turned


@final
class MotorJudge:
    """Asks of every segment and of every rest whether some balance leaves motors room.

    Args:
        problem: with a hand.
        model: of the hand.
    """

    def __init__(self, problem: Problem, model: HandModel) -> None:
        self._problem, self._model = problem, model
        self._efforts = Efforts(model, problem.mechanics.gravity)

    def refusal(self, moves: Sequence[Move], rows: Sequence[Array]) -> JointRefusal | None:
        """Return where motors cannot hold along moves with their rows (m, k), or None."""
        for number, (move, part) in enumerate(zip(moves, rows, strict=True)):
            if isinstance(move, Displacement):
                short = self._displacement(number, move, part)
                if short is not None:
                    return short
        return None

    def _displacement(self, number: int, move: Displacement, rows: Array) -> JointRefusal | None:
        cuts, every = move.arc.bounds(len(move.segments)), tuple(range(self._model.count))
        for k, decision in enumerate(move.segments):
            t = (cuts[k] + cuts[k + 1]) / 2.0
            q, hand = between(rows, t), (every, move.placements)
            short = self._short(move.arc.moment(t), decision, q, hand)
            if short is not None:
                return JointRefusal(number, t, *short)
        return None

    def regrasp(self, move: Regrasp, rows: Array) -> str | None:
        """Return why motors cannot hold while one finger is lifted, or None."""
        staying = tuple(i for i in range(self._model.count) if i != move.finger)
        hand = staying, tuple(move.placements[i] for i in staying)
        for q in rows[[0, -1]]:
            short = self._short(Moment(move.pose), move.rest, q, hand)
            if short is not None:
                return short[1]
        return None

    def _short(
        self,
        moment: Moment,
        decision: ModeDecision,
        q: Array,
        hand: tuple[tuple[int, ...], Sequence[int]],
    ) -> tuple[int, str] | None:
        """Return which finger asks too much of a motor, and in words; None where none does."""
        problem, (fingers, rows) = self._problem, hand
        self._model.place(q, moment.pose)
        down, points = list(fingers), np.zeros((self._model.count, 3))
        points[down] = moment.pose.apply(problem.fingers.placements.points[list(rows)])
        levers, weight = self._efforts.levers(points)[down], self._efforts.weight()
        if self._ample(levers, weight, down):
            return None
        contacts = contacts_at(moment, problem.body, problem.environment)
        instant = problem.instant(contacts, fingers, tuple(rows))
        motors = Motors(turned(levers, moment.pose.rotation), weight, self._model.spec.torque)
        force = np.array([mode is ControlMode.FORCE for mode in decision.modes], dtype=bool)
        f_com = np.array([f or 0.0 for f in decision.f_com], dtype=np.float64)
        found = least_share(statics(instant), force, f_com, motors)
        if found is None or found[0] <= ROOM:
            return None
        share, joint = found
        name = self._model.spec.joints[joint]
        far = np.linalg.norm(levers[:, :3, joint], axis=1)
        text = f"has {name} ask for {share:.2f} of its torque; plans count on {ROOM:g}"
        return fingers[int(far.argmax())], text

    def _ample(self, levers: Array, weight: Array, down: Sequence[int]) -> bool:
        """Whether motors have room whatever force within its limits each finger exerts."""
        fingers = self._problem.fingers
        normal, friction = fingers.max_normal_force[down], fingers.friction[down]
        force = normal * np.sqrt(1.0 + friction**2)
        moment = normal * friction * fingers.soft[down]
        arms = np.linalg.norm(levers.reshape(len(down), 2, 3, -1), axis=2)
        most = np.abs(weight) + force @ arms[:, 0] + moment @ arms[:, 1]
        return bool((most <= ROOM * self._model.spec.torque).all())


def between(rows: Array, share: float) -> Array:
    """Return the configuration (k,) after ``share`` of evenly spaced rows (m, k)."""
    at = share * (len(rows) - 1)
    k = min(int(at), len(rows) - 2)
    return np.asarray(rows[k] + (at - k) * (rows[k + 1] - rows[k]))
