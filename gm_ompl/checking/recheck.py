"""The judgements a check rests on: geometry, contact and the reference, remembered."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from gm_ompl.arrays import BoolArray
from gm_ompl.checking.remembered import Mechanics, Remembered, bound, mechanics
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.plain.air_judge import AirJudge
from gm_ompl.problem import Placements, Problem
from gm_ompl.reference.bases import Margins
from gm_ompl.reference.cases import Case, margins_in, stability_in
from gm_ompl.reference.junction import equilibrium
from gm_ompl.reference.modes import combinations, decide_modes, margin
from gm_ompl.reference.stability import NEGLIGIBLE
from gm_ompl.reference.strong import strong_margin
from gm_ompl.reference.swept import SweptJudge


@dataclass(frozen=True)
class Tolerances:
    """How far a claim may be from what holds.

    Attributes:
        coordinate: of object coordinates, relative to the coordinate's range; far above the
            rounding of s = k / n, far below any lattice step.
        length: of positions and contact points, relative to D.
        direction: of unit vectors and quaternions, absolute.
        count: of lattice steps spanned, before rounding up; a planner may allow less.
        rounding: of the same; no planner counts a step for so little.
        z: of margins, relative to max(z, z_floor M g): what two LP solvers agree to.
        z_floor: see ``z``.
        z_min: by how much z may miss z_min, relative.
        force: of 0 <= f_com <= f_max, relative to f_max.
        cost: of costs, relative; sums of products of square roots agree to far less.
        optimal: of a proven optimum, relative.
        balance: of equilibrium where z is 0: what may be missing, over M g.
        way: of where a way through the air begins and ends, relative to D.
    """

    coordinate: float = 1e-9
    length: float = 1e-9
    direction: float = 1e-9
    count: float = 1e-6
    rounding: float = 1e-8
    z: float = 1e-6
    z_floor: float = 1e-3
    z_min: float = 1e-6
    force: float = 1e-9
    cost: float = 1e-7
    optimal: float = 1e-6
    balance: float = 1e-8
    way: float = 1e-9


Fingers = tuple[int, ...]
Modes = tuple[ControlMode, ...]
Forces = tuple[float | None, ...]
T = TypeVar("T")

SAME_STATE = 1e-9
"""Contact states that agree to this (lengths over D) are one: a slide's decisions are equal."""


@dataclass(frozen=True)
class Hold:
    """What the plan claims of an instant.

    Attributes:
        contacts: the environment contacts.
        fingers: the fingers that touch.
        rows: their placements.
        modes: their modes.
        f_com: their commanded forces.
        z: the claimed margin.
        segment: number of the segment, or None for a regrasp.
        z_strong: how much of it is claimed to be strongly held; None where nothing is said.
    """

    contacts: ContactState
    fingers: Fingers
    rows: Placements
    modes: Modes
    f_com: Forces
    z: float = 0.0
    segment: int | None = None
    z_strong: float | None = None

    @property
    def hand(self) -> tuple[Fingers, Placements]:
        """The fingers that touch, and where."""
        return self.fingers, self.rows


class Recheck:
    """Answers what holds for one problem; every answer about equal contact states is kept.

    Attributes:
        problem: the problem, made from the plan's scenario.
        tolerances: of the check.
        air: ways through the air.
    """

    def __init__(self, problem: Problem, tolerances: Tolerances | None = None) -> None:
        self.problem = problem
        self.tolerances = tolerances or Tolerances()
        environment = problem.environment
        bodies = [obstacle.body for obstacle in environment.obstacles]
        floor, touching = environment.floor, environment.contact_tolerance
        self._scene = Scene(problem.body, bodies, floor, touching)
        self._swept = SweptJudge(problem.body, tuple(bodies), floor, touching)
        self.air = AirJudge(problem)
        self._known: dict[Hashable, Any] = {}
        self._guess: dict[object, Forces] = {}
        self._remembered = Remembered()
        self._last_model: tuple[object, Mechanics] | None = None
        self._last_margins: (
            tuple[tuple[Case, ...], Modes, Forces, tuple[Margins, ...] | None] | None
        ) = None

    @cached_property
    def diagonal(self) -> float:
        """D."""
        return self.problem.body.diagonal

    @property
    def force_scale(self) -> float:
        """The unit that small margins are measured in: M g, or the largest f_max without g."""
        return self.problem.force_scale

    def contacts(self, moment: Moment) -> ContactState:
        """Return the environment contacts at ``moment``."""
        return contacts_at(moment, self.problem.body, self.problem.environment)

    def blocked(self, pose: Pose, rows: Placements) -> str | None:
        """Return why the object at ``pose`` is geometrically invalid, or None where it is valid."""
        fingers = self.problem.fingers
        if not self._scene.object_free(pose):
            return "the object penetrates its environment"
        centres, pieces = fingers.centres(rows), fingers.placements.piece[list(rows)]
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
        for i, centre in enumerate(self.problem.fingers.centres(rows)):
            at = self._swept.tip_blocked(arc, centre, float(self.problem.fingers.radius[i]))
            if at is not None:
                return f"the fingertip of finger {i} penetrates floor or obstacle {at:.1%} along it"
        return None

    def best(self, hold: Hold) -> ModeDecision:
        """Return Sec. 3.4's best for the fingers of ``hold`` where they are."""
        return self._once("best", hold, (), lambda: decide_modes(self._instant(hold)))

    def margin(self, hold: Hold) -> float:
        """Return z of Problem (6) with the modes and the f_com of ``hold``, in the worst case."""

        def solved() -> float:
            among = self._mechanics(hold).cases
            found = self._margins(among, hold, hold.modes, hold.f_com)
            least = min((each.z for each in found or ()), default=0.0)
            if NEGLIGIBLE < least < np.inf:
                return least * among[0].model.scale
            allowed = self.tolerances.balance
            return margin(self._instant(hold), hold.modes, hold.f_com, allowed)

        return self._once("margin", hold, (hold.modes, hold.f_com), solved)

    def strong(self, hold: Hold, z: float) -> float:
        """Return z_strong with the modes and the f_com of ``hold``, at most ``z``."""
        claim = (hold.modes, hold.f_com)
        found = lambda: strong_margin(self._instant(hold), *claim, z).z  # noqa: E731
        return self._once("strong", hold, (*claim, z), found)

    def unbeaten(self, hold: Hold, z: float) -> bool:
        """Whether it is proven, without solving Sec. 3.4 anew, that no modes have a larger z.

        Of the sets of modes that pass Problem (5) only those with the most position control
        matter: a force-controlled finger's forces are among those of the same finger under
        position control.
        """
        claim = (hold.modes, hold.f_com, z)
        return self._once("unbeaten", hold, claim, lambda: self._proven(hold, z))

    def balanced(self, hold: Hold) -> bool:
        """Whether forces balance the load with the modes and the f_com of ``hold``."""

        def found() -> bool:
            return equilibrium(self._instant(hold), hold.modes, hold.f_com)

        return self._once("balanced", hold, (hold.modes, hold.f_com), found)

    def internal_force(self, hold: Hold) -> bool:
        """Whether Problem (5) finds excessive internal force with the modes of ``hold``."""
        position = _position(hold.modes)

        def found() -> bool:
            key = (hold.hand, position)
            return self._remembered.excessive(key, self._mechanics(hold).squeezed, position)

        return self._once("internal force", hold, position, found)

    def _once(self, question: str, hold: Hold, claim: Hashable, answer: Callable[[], T]) -> T:
        """Return the answer to a question about a hand's contact state, asked for once."""
        key = (question, self._key(hold.contacts), hold.hand, claim)
        if key not in self._known:
            self._known[key] = answer()
        known: T = self._known[key]
        return known

    def _proven(self, hold: Hold, z: float) -> bool:
        (among, squeezing), passed = self._mechanics(hold), list[frozenset[int]]()
        failed = list[frozenset[int]]()
        scale = among[0].model.scale
        least = z / scale
        for modes in combinations(len(hold.modes)):
            position = _position(modes)
            if any(position <= more for more in passed) or any(position >= f for f in failed):
                continue
            if self._remembered.excessive((hold.hand, position), squeezing, position):
                failed.append(position)
                continue
            passed.append(position)
            tried = hold.f_com if modes == hold.modes else self._guess.get((hold.hand, modes))
            found = None if tried is None else self._margins(among, hold, modes, tried)
            if found is not None and bound(among, _force(modes), found) <= least:
                continue
            best = stability_in(among, modes)
            if not best.z <= least:
                return False
            if len(best.f_com):
                self._guess[hold.hand, modes] = tuple((best.f_com * scale).tolist())
        return True

    def _instant(self, hold: Hold) -> Instant:
        return self.problem.instant(hold.contacts, *hold.hand)

    def _mechanics(self, hold: Hold) -> Mechanics:
        """Return Sec. 2.2's matrices; the last are kept: one instant is asked about thrice."""
        key = (self._key(hold.contacts), hold.hand)
        if self._last_model is None or self._last_model[0] != key:
            self._last_model = (key, mechanics(self._instant(hold)))
        return self._last_model[1]

    def _margins(
        self, among: tuple[Case, ...], hold: Hold, modes: Modes, f_com: Forces
    ) -> tuple[Margins, ...] | None:
        """Return Problem (6) per case for a claimed f_com; the last answer is kept, likewise."""
        last = self._last_margins
        if last is None or last[0] is not among or last[1:3] != (modes, f_com):
            commanded = np.array([f or 0.0 for f in f_com], dtype=np.float64) / among[0].model.scale
            key, bases = (hold.hand, modes), self._remembered.bases
            found = margins_in(among, _force(modes), commanded, bases, key)
            self._last_margins = last = (among, modes, f_com, found)
        return last[3]

    def _key(self, contacts: ContactState) -> tuple[bytes, ...]:
        points = contacts.points / self.diagonal
        arrays = (points, contacts.normals, contacts.slip, contacts.rotation, contacts.surfaces)
        # Adding zero turns -0.0 into 0.0, whose bytes differ.
        return tuple((np.round(array / SAME_STATE) + 0.0).tobytes() for array in arrays)


def _position(modes: Modes) -> frozenset[int]:
    """Return the fingers under position control."""
    return frozenset(i for i, mode in enumerate(modes) if mode is ControlMode.POSITION)


def _force(modes: Modes) -> BoolArray:
    return np.array([mode is ControlMode.FORCE for mode in modes], dtype=bool)
