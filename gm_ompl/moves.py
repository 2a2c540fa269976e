"""The two kinds of arc of Sec. 4.2 as a planner returns them, before they become a plan."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements


@dataclass(frozen=True)
class Displacement:
    """One arc for displacement of the object, fingertips fixed on it.

    Attributes:
        arc: the object's motion.
        start: object coordinates at the arc's tail; empty where the motion has none.
        end: at its head, unwrapped.
        placements: per physical finger.
        segments: one decision per equal segment, judged at the segment's midpoint.
        cost: Eq. (9).
    """

    arc: Arc = field(compare=False)  # arcs are equal by their ends
    start: Coordinates
    end: Coordinates
    placements: Placements
    segments: tuple[ModeDecision, ...]
    cost: float


@dataclass(frozen=True)
class Regrasp:
    """One arc for regrasping: a finger changes its placement, the object rests.

    Attributes:
        pose: where the object rests.
        at: the same in object coordinates; empty where the motion has none.
        finger: the physical finger that moves.
        target: its new placement.
        placements: per physical finger, before the move.
        rest: the decision for the other fingers (in finger order, the lifted one left out).
        cost: Eq. (10).
    """

    pose: Pose = field(compare=False)
    at: Coordinates
    finger: int
    target: int
    placements: Placements
    rest: ModeDecision
    cost: float


Move: TypeAlias = Displacement | Regrasp
