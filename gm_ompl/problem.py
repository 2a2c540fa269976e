"""A manipulation problem, and the moves that solve it: values only."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, TypeAlias

import numpy as np

from gm_ompl.arrays import Array, fix
from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.environment import Environment
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.geometry.patches import Anywhere
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.hand.spec import HandSpec
from gm_ompl.motion.arc import Arc, Motion
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.lattice import Coordinates, Goal, Lattice
from gm_ompl.motion.object_graph import LatticeGraph, ObjectGraph
from gm_ompl.uncertainty.ranges import Uncertainty

Placements = tuple[int, ...]
"""Per finger, its row in the placement table."""


Z_FLOOR: Final = 0.01
"""What a smaller margin counts as in Eq. (9), over M g."""


@dataclass(frozen=True, eq=False)
class Fingers:
    """The hand: n fingertips and where each may be placed.

    Attributes:
        radius: (n,), fingertip radius.
        max_normal_force: (n,), f_max.
        friction: (n,), Coulomb coefficient against the object.
        soft: (n,), length L of a soft fingertip's moment mu L about the normal; 0 is a point.
        placements: the placements, common to all fingers.
        start: per finger, its placement in the start state, or None for any.
        goal: likewise in the goal state.
        clearance: (n,), how much wider than the fingertip a gap is that must count as open.
        transit: whether a finger needs a way through the air to where it first touches and to
            where it is regrasped.
        leave: whether, at the goal, every finger needs a way off.
        named: whether each is a finger of a certain hand, which no other can stand in for.
        anywhere: where they may be placed beside ``placements``; None: nowhere.
    """

    radius: Array
    max_normal_force: Array
    friction: Array
    soft: Array
    placements: PlacementTable
    start: tuple[int | None, ...]
    goal: tuple[int | None, ...]
    clearance: Array
    transit: bool = True
    leave: bool = False
    named: bool = False
    anywhere: Anywhere | None = None

    def __post_init__(self) -> None:
        n = len(self.start)
        fix(self, radius=(n,), max_normal_force=(n,), friction=(n,), soft=(n,), clearance=(n,))

    @property
    def count(self) -> int:
        """Number of fingers n."""
        return len(self.start)

    @property
    def standing(self) -> tuple[int, ...]:
        """The fingers that touch before the plan begins."""
        return tuple(i for i, row in enumerate(self.start) if row is not None)

    def centres(self, placements: Placements) -> Array:
        """Return the fingertips' centres (n, 3), object frame, one row per finger."""
        table, rows = self.placements, list(placements)
        outward: Array = table.points[rows] - self.radius[:, None] * table.normals[rows]
        return outward

    @property
    def reach(self) -> float:
        """How far a fingertip may be from the object's centre of mass."""
        table, farthest = self.placements, 0.0
        for radius in set(self.radius.tolist()):
            centres = np.linalg.norm(table.centres(radius), axis=1)
            farthest = max(farthest, float(centres.max(initial=0.0)) + radius)
        return farthest

    @property
    def shapes(self) -> tuple[tuple[float, int], ...]:
        """Per finger, equal where geometry leaves two the same placements."""
        return tuple((r, i if self.named else 0) for i, r in enumerate(self.radius.tolist()))

    def groups(self) -> tuple[tuple[int, ...], ...]:
        """Return the groups of interchangeable fingers, each in increasing order.

        Fingers are interchangeable when radius, limit, friction, soft, start and goal are equal
        and no hand tells them apart.
        """
        groups: dict[tuple[object, ...], list[int]] = {}
        for i in range(self.count):
            key = (
                float(self.radius[i]), float(self.max_normal_force[i]), float(self.friction[i]),
                float(self.soft[i]), self.start[i], self.goal[i], float(self.clearance[i]),
                self.shapes[i],
            )  # fmt: skip
            groups.setdefault(key, []).append(i)
        return tuple(tuple(group) for group in groups.values())


@dataclass(frozen=True)
class MechanicsSettings:
    """Settings of Sec. 3; defaults are the paper's.

    Attributes:
        gravity: g, along the world's -z.
        cone_edges: s.
        z_min: the threshold on the stability margin; 0 asks for equilibrium alone.
        backend: "kernel" (compiled) or "highs" (the reference).
        margin: "nominal": z of Problem (6) counts; or "strong": z_strong in its place.
    """

    gravity: float = 9.8
    cone_edges: int = 6
    z_min: float = 0.5
    backend: str = "kernel"
    margin: str = "nominal"

    @property
    def strong(self) -> bool:
        """Whether z_strong counts."""
        return self.margin == "strong"


@dataclass(frozen=True)
class CostSettings:
    """Settings of Sec. 4.3; defaults are the paper's.

    Attributes:
        regrasp: X_regr of Eq. (10).
        stability: X_stab of Eq. (9).
        samples_per_arc: P of Eq. (9).
        samples_at: "middles" of P equal parts of an arc, or "ends": evenly from end to end.
        z_floor: what a smaller margin counts as in Eq. (9); None stands for 0.01 M g.
    """

    regrasp: float = 100.0
    stability: float = 0.01
    samples_per_arc: int = 3
    samples_at: str = "middles"
    z_floor: float | None = None


@dataclass(frozen=True, eq=False)
class Problem:
    """Everything a planner needs; made from a scenario.

    Attributes:
        name: the scenario's name.
        body: the object, object frame (origin at the centre of mass).
        mass: M.
        inertia: (3, 3), J about the centre of mass, object frame.
        environment: floor and obstacles.
        fingers: the hand.
        motion: the object's degrees of freedom.
        lattice: the object's lattice nodes, or None where only continuous planners apply.
        start: coordinates of the start.
        goal: where the object must end.
        mechanics: settings of Sec. 3.
        cost: settings of Sec. 4.3.
        uncertainty: what is not known exactly; z is then the least of all cases.
        hand: the robot hand behind the fingertips; None where fingertips are all there is.
    """

    name: str
    body: Body
    mass: float
    inertia: Array
    environment: Environment
    fingers: Fingers
    motion: Motion
    lattice: Lattice
    start: Coordinates
    goal: Goal
    mechanics: MechanicsSettings = field(default_factory=MechanicsSettings)
    cost: CostSettings = field(default_factory=CostSettings)
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    hand: HandSpec | None = None

    def __post_init__(self) -> None:
        fix(self, inertia=(3, 3))

    @property
    def force_scale(self) -> float:
        """M g; without gravity the largest f_max, else 1."""
        weight = self.mass * self.mechanics.gravity
        return weight or float(self.fingers.max_normal_force.max(initial=0.0)) or 1.0

    @property
    def z_floor(self) -> float:
        """What a smaller margin counts as in Eq. (9): at most z_min where that is positive."""
        given, z_min = self.cost.z_floor, self.mechanics.z_min
        floor = Z_FLOOR * self.force_scale if given is None else given
        return min(floor, z_min) if z_min > 0.0 else floor

    @cached_property
    def object_graph(self) -> ObjectGraph:
        """What searches on the lattice walk.

        Raises:
            InputError: the start or the goal is off the lattice.
        """
        parts = self.cost.samples_per_arc
        if isinstance(self.motion, FreeMotion):
            from gm_ompl.contact.lattice import ContactLattice  # brings the compiler

            return ContactLattice(
                self.motion, self.body, self.environment, parts, self.fingers.reach
            )
        return LatticeGraph(self.motion, self.lattice, self.start, self.goal, parts)

    def instant(
        self, contacts: ContactState, fingers: tuple[int, ...], placements: Placements
    ) -> Instant:
        """Return the mode decision's input for ``fingers`` at ``placements`` (same length)."""
        rows = np.asarray(placements, dtype=np.int64)
        hand = np.asarray(fingers, dtype=np.int64)
        table = self.fingers.placements
        return Instant(
            contacts=contacts,
            points=table.points[rows],
            normals=table.normals[rows],
            friction=self.fingers.friction[hand],
            max_normal_force=self.fingers.max_normal_force[hand],
            environment_friction=self.environment.friction,
            mass=self.mass,
            inertia=self.inertia,
            gravity=self.mechanics.gravity,
            cone_edges=self.mechanics.cone_edges,
            soft=self.fingers.soft[hand],
            uncertainty=self.uncertainty.of(fingers),
        )


@dataclass(frozen=True)
class Displacement:
    """One arc for displacement of the object, fingertips fixed on it.

    Attributes:
        arc: the object's motion.
        start: object coordinates at the arc's tail; empty where the motion has none.
        end: at its head, unwrapped.
        placements: per physical finger.
        segments: one decision per segment, where the arc has it judged.
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
        way: (k, 3), corners of the fingertip's way through the air, its centre, world frame; None
            where it is not planned.
    """

    pose: Pose = field(compare=False)
    at: Coordinates
    finger: int
    target: int
    placements: Placements
    rest: ModeDecision
    cost: float
    way: Array | None = field(default=None, compare=False)


Move: TypeAlias = Displacement | Regrasp
