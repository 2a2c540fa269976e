"""The judgements a check rests on: geometry, contact and the reference, remembered."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.check.remembered import Margins, Remembered, bound
from gm_ompl.check.settings import Tolerances
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import ContactState
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.problem import Placements, Problem
from gm_ompl.reference.modes import combinations, decide_modes, margin
from gm_ompl.reference.stability import NEGLIGIBLE, stability
from gm_ompl.reference.statics import Statics, statics
from gm_ompl.reference.swept import SweptJudge

Fingers = tuple[int, ...]
Modes = tuple[ControlMode, ...]
Forces = tuple[float | None, ...]
Hand = tuple[Fingers, Placements]

SAME_STATE = 1e-9
"""Contact states that agree to this (lengths over D) are one: a slide's decisions are equal."""


class Referee:
    """Answers what holds for one problem; every answer about equal contact states is kept.

    Attributes:
        problem: the problem, made from the plan's scenario.
        tolerances: of the check.
    """

    def __init__(self, problem: Problem, tolerances: Tolerances | None = None) -> None:
        self.problem = problem
        self.tolerances = tolerances or Tolerances()
        environment = problem.environment
        bodies = [obstacle.body for obstacle in environment.obstacles]
        floor, touching = environment.floor, environment.contact_tolerance
        self._scene = Scene(problem.body, bodies, floor, touching)
        self._swept = SweptJudge(problem.body, tuple(bodies), floor, touching)
        self._best: dict[object, ModeDecision] = {}
        self._margin: dict[object, float] = {}
        self._internal: dict[object, bool] = {}
        self._unbeaten: dict[object, bool] = {}
        self._guess: dict[object, Forces] = {}
        self._remembered = Remembered()
        self._last_model: tuple[object, Statics] | None = None
        self._last_margins: tuple[Statics, Modes, Forces, Margins | None] | None = None

    @cached_property
    def diagonal(self) -> float:
        """D."""
        return self.problem.body.diagonal

    @property
    def force_scale(self) -> float:
        """The unit that small margins are measured in: M g, or the largest f_max without g."""
        weight = self.problem.mass * self.problem.mechanics.gravity
        return weight or float(self.problem.fingers.max_normal_force.max(initial=0.0))

    def contacts(self, moment: Moment) -> ContactState:
        """Return the environment contacts at ``moment``."""
        return contacts_at(moment, self.problem.body, self.problem.environment)

    def blocked(self, pose: Pose, rows: Placements) -> str | None:
        """Return why the object at ``pose`` is geometrically invalid, or None where it is valid."""
        fingers = self.problem.fingers
        if not self._scene.object_free(pose):
            return "the object penetrates its environment"
        centres, pieces = self.centres(rows), fingers.placements.piece[list(rows)]
        for i in range(len(rows)):
            tip, own = centres[i : i + 1], pieces[i : i + 1]
            if not self._scene.free_placements(pose, tip, fingers.radius[i], own)[0]:
                return f"the fingertip of finger {i} penetrates floor, obstacle or object"
            for j in range(i):
                distance = float(np.linalg.norm(centres[i] - centres[j]))
                least = float(fingers.radius[i] + fingers.radius[j])
                other = centres[j : j + 1]
                if not self._scene.tips_apart(tip, fingers.radius[i], other, fingers.radius[j])[
                    0, 0
                ]:
                    return (
                        f"the fingertips of fingers {j} and {i} penetrate each other: their "
                        f"centres are {distance:.9g} apart, their radii add up to {least:.9g}"
                    )
        return None

    def blocked_along(self, arc: Arc, rows: Placements) -> str | None:
        """Return what penetrates the environment anywhere along ``arc``, or None."""
        at = self._swept.object_blocked(arc)
        if at is not None:
            return f"the object penetrates its environment {at:.1%} along the arc"
        for i, centre in enumerate(self.centres(rows)):
            at = self._swept.tip_blocked(arc, centre, float(self.problem.fingers.radius[i]))
            if at is not None:
                return f"the fingertip of finger {i} penetrates floor or obstacle {at:.1%} along it"
        return None

    def centres(self, placements: Placements) -> Array:
        """Return the fingertip centres (n, 3), object frame, one row per finger."""
        fingers = self.problem.fingers
        rows = np.asarray(placements, dtype=np.int64)
        table = fingers.placements
        outward: Array = table.points[rows] - fingers.radius[:, None] * table.normals[rows]
        return outward

    def chords(self, arc: Arc, placements: Placements, parts: int) -> Array:
        """Return how far each fingertip centre goes in each of an arc's equal parts, (P, n)."""
        return arc.chords(self.centres(placements), parts)

    def best(self, contacts: ContactState, fingers: Fingers, rows: Placements) -> ModeDecision:
        """Return Sec. 3.4's best for ``fingers`` at ``rows``."""
        key = (self._key(contacts), fingers, rows)
        if key not in self._best:
            self._best[key] = decide_modes(self.problem.instant(contacts, fingers, rows))
        return self._best[key]

    def margin(
        self,
        contacts: ContactState,
        fingers: Fingers,
        rows: Placements,
        modes: Modes,
        f_com: Forces,
    ) -> float:
        """Return z of Problem (6) with these modes and this f_com."""
        key = (self._key(contacts), fingers, rows, modes, f_com)
        if key not in self._margin:
            model = self._model(contacts, (fingers, rows))
            found = self._margins(model, (fingers, rows), modes, f_com)
            if found is not None and NEGLIGIBLE < found.z < np.inf:
                self._margin[key] = found.z * model.scale
            else:
                instant = self.problem.instant(contacts, fingers, rows)
                self._margin[key] = margin(instant, modes, f_com)
        return self._margin[key]

    def unbeaten(
        self,
        contacts: ContactState,
        hand: Hand,
        modes: Modes,
        f_com: Forces,
        z: float,
    ) -> bool:
        """Whether it is proven, without solving Sec. 3.4 anew, that no modes have a larger z.

        Of the sets of modes that pass Problem (5) only those with the most position control
        matter: a force-controlled finger's forces are among those of the same finger under
        position control.
        """
        key = (self._key(contacts), hand, modes, f_com, z)
        if key not in self._unbeaten:
            model = self._model(contacts, hand)
            self._unbeaten[key] = self._proven(model, hand, modes, f_com, z / model.scale)
        return self._unbeaten[key]

    def _proven(self, model: Statics, hand: Hand, modes: Modes, f_com: Forces, z: float) -> bool:
        passed: list[frozenset[int]] = []
        failed: list[frozenset[int]] = []
        for others in combinations(len(modes)):
            position = frozenset(i for i, mode in enumerate(others) if mode is ControlMode.POSITION)
            if any(position <= more for more in passed) or any(position >= f for f in failed):
                continue
            if self._remembered.excessive((hand, position), model, position):
                failed.append(position)
                continue
            passed.append(position)
            tried = f_com if others == modes else self._guess.get((hand, others))
            found = None if tried is None else self._margins(model, hand, others, tried)
            if found is not None and bound(model, _force(others), found) <= z:
                continue
            best = stability(model, others)
            if not best.z <= z:
                return False
            if len(best.f_com):
                self._guess[hand, others] = tuple((best.f_com * model.scale).tolist())
        return True

    def _model(self, contacts: ContactState, hand: Hand) -> Statics:
        """Return Sec. 2.2's matrices; the last are kept: one instant is asked about thrice."""
        key = (self._key(contacts), hand)
        if self._last_model is None or self._last_model[0] != key:
            self._last_model = (key, statics(self.problem.instant(contacts, *hand)))
        return self._last_model[1]

    def _margins(self, model: Statics, hand: Hand, modes: Modes, f_com: Forces) -> Margins | None:
        """Return Problem (6) for a claimed f_com; the last answer is kept, likewise."""
        last = self._last_margins
        if last is None or last[0] is not model or last[1:3] != (modes, f_com):
            commanded = np.array([f or 0.0 for f in f_com], dtype=np.float64) / model.scale
            key, force = (hand, modes), _force(modes)
            found = self._remembered.margins(key, model, force, commanded)
            self._last_margins = last = (model, modes, f_com, found)
        return last[3]

    def internal_force(
        self, contacts: ContactState, fingers: Fingers, rows: Placements, modes: Modes
    ) -> bool:
        """Whether Problem (5) finds excessive internal force with these modes."""
        key = (self._key(contacts), fingers, rows, modes)
        if key not in self._internal:
            model = self._model(contacts, (fingers, rows))
            position = frozenset(i for i, mode in enumerate(modes) if mode is ControlMode.POSITION)
            self._internal[key] = self._remembered.excessive(
                ((fingers, rows), position), model, position
            )
        return self._internal[key]

    def _key(self, contacts: ContactState) -> tuple[bytes, ...]:
        arrays = (
            contacts.points / self.diagonal,
            contacts.normals,
            contacts.slip,
            contacts.rotation,
        )
        # Adding zero turns -0.0 into 0.0, whose bytes differ.
        return tuple((np.round(array / SAME_STATE) + 0.0).tobytes() for array in arrays)


def _force(modes: Modes) -> BoolArray:
    return np.array([mode is ControlMode.FORCE for mode in modes], dtype=bool)
