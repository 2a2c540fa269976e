"""The judgements a check rests on: geometry, contact and the reference, remembered."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.check.settings import Tolerances
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import ContactState
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.problem import Placements, Problem
from gm_ompl.reference.internal_force import excessive_internal_force
from gm_ompl.reference.modes import decide_modes, margin
from gm_ompl.reference.statics import statics
from gm_ompl.reference.swept import SweptJudge

Fingers = tuple[int, ...]
Modes = tuple[ControlMode, ...]
Forces = tuple[float | None, ...]

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
        self._scene = Scene(problem.body, bodies, environment.floor)
        self._swept = SweptJudge(problem.body, tuple(bodies), environment.floor)
        self._best: dict[object, ModeDecision] = {}
        self._margin: dict[object, float] = {}
        self._internal: dict[object, bool] = {}

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
            instant = self.problem.instant(contacts, fingers, rows)
            self._margin[key] = margin(instant, modes, f_com)
        return self._margin[key]

    def internal_force(
        self, contacts: ContactState, fingers: Fingers, rows: Placements, modes: Modes
    ) -> bool:
        """Whether Problem (5) finds excessive internal force with these modes."""
        key = (self._key(contacts), fingers, rows, modes)
        if key not in self._internal:
            model = statics(self.problem.instant(contacts, fingers, rows))
            position = [i for i, mode in enumerate(modes) if mode is ControlMode.POSITION]
            self._internal[key] = excessive_internal_force(model, position).excessive
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
