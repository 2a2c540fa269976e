"""What is possible at any coordinates: displacements and regrasps, judged in their direction."""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.reach import Staying
from gm_ompl.geometry.pose import Pose
from gm_ompl.holds.cost import displacement_cost
from gm_ompl.holds.goals import fits
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Displacement, Placements, Problem, Regrasp
from gm_ompl.sampling.lines import RouteLine, same, split, strides_needed

UNPLACED = -1
"""Stands for the placement of a finger that was not placed yet; start states alone have it."""

LINES = 2000
"""Straight motions kept; beyond, all are dropped and made again on demand."""


class HybridState(NamedTuple):
    """A state of the hybrid space.

    Attributes:
        q: the object's coordinates.
        placements: per finger, its row in the placement table, or UNPLACED.
    """

    q: Coordinates
    placements: Placements


class HybridModel(ABC):
    """What is possible anywhere, but for displacements; what ``q`` means is left open.

    Args:
        problem: what is planned.
        judge: answers about ``problem``; its memos are shared with everybody who uses it.
    """

    def __init__(self, problem: Problem, judge: Judge) -> None:
        self.problem, self.judge = problem, judge
        self._fingers = tuple(range(problem.fingers.count))
        self._z_min = problem.mechanics.z_min

    @property
    @abstractmethod
    def start(self) -> Coordinates:
        """Where the object is at the start."""

    @abstractmethod
    def pose(self, q: Coordinates) -> Pose:
        """Return the pose at ``q``."""

    @abstractmethod
    def noted(self, q: Coordinates) -> Coordinates:
        """Return what a move says of ``q``: empty where the motion has no coordinates."""

    @abstractmethod
    def where(self, move: Regrasp) -> Coordinates:
        """Return where the object rests during a regrasp."""

    @abstractmethod
    def same(self, a: Coordinates, b: Coordinates) -> bool:
        """Whether the object is at the same place at ``a`` and ``b``."""

    @abstractmethod
    def arrived(self, q: Coordinates) -> bool:
        """Whether the object is in the goal."""

    def start_state(self) -> HybridState:
        """Return the start: fingers with a given start placement there, the others UNPLACED."""
        given = self.problem.fingers.start
        return HybridState(self.start, tuple(UNPLACED if row is None else row for row in given))

    def in_goal(self, state: HybridState) -> bool:
        """Whether the object is in the goal and the fingers are where the goal wants them."""
        fitting = fits(state.placements, self.problem.fingers.goal)
        return fitting and self.arrived(state.q) and self.leaves(state)

    def lands(self, placements: Placements) -> bool:
        """Whether the fingers can touch the object at the start, one after the other."""
        pose, standing = self.pose(self.start), self.problem.fingers.standing
        return self.judge.reach.landing(pose, placements, standing) is not None

    def leaves(self, state: HybridState) -> bool:
        """Whether the fingers can leave the object, one after the other, where they must."""
        if not self.problem.fingers.leave:
            return True
        pose = self.pose(state.q)
        return self.judge.reach.landing(pose, state.placements) is not None

    def state_valid(self, q: Coordinates, placements: Placements) -> bool:
        """Whether nothing penetrates at ``q``; fingers that are UNPLACED touch nothing."""
        placed = [i for i in self._fingers if placements[i] != UNPLACED]
        node, clear = self.judge.node(self.pose(q)), self.judge.clear
        if not node.object_free or not all(node.free[i][placements[i]] for i in placed):
            return False
        for k, i in enumerate(placed):
            for j in placed[:k]:
                pair = clear[i][j]
                if pair is not None and not pair[placements[i], placements[j]]:
                    return False
        return True

    def regrasp(
        self, q: Coordinates, placements: Placements, finger: int, target: int
    ) -> Regrasp | None:
        """Return the regrasp of ``finger`` to ``target`` at ``q``, or None if it fails."""
        after = (*placements[:finger], target, *placements[finger + 1 :])
        if target in placements or not self.state_valid(q, after):
            return None
        if not self.state_valid(q, placements):
            return None
        pose, staying = self.pose(q), self._staying(placements, finger)
        rest = self._rest(pose, staying)
        if not rest.z >= self._z_min:
            return None
        if not self.judge.reach.joined(pose, finger, staying, placements[finger], target):
            return None
        cost = self.problem.cost.regrasp
        return Regrasp(pose, self.noted(q), finger, target, placements, rest, cost)

    def rests(self, q: Coordinates, placements: Placements, finger: int) -> bool:
        """Whether the object rests at ``q`` on all placements but that of ``finger``."""
        pose = self.pose(q)
        return self._rest(pose, self._staying(placements, finger)).z >= self._z_min

    def _staying(self, placements: Placements, finger: int) -> Staying:
        return tuple((i, placements[i]) for i in self._fingers if i != finger)

    def _rest(self, pose: Pose, staying: Staying) -> ModeDecision:
        fingers, rows = tuple(i for i, _ in staying), tuple(row for _, row in staying)
        return self.judge.rest(pose, fingers, rows, self._z_min)

    def least_cost(self, state_from: HybridState, state_to: HybridState) -> float:
        """Return a lower bound on the cost of every plan from one state to another.

        A finger whose placement differs is regrasped at least once. Where none differs, either no
        finger is regrasped and each travels at least the straight line between its places, or at
        least one regrasp is paid for: the first case of Eq. (11), limited to X_regr. A finger
        without placement gets its first one free of charge.
        """
        price = self.problem.cost.regrasp
        pairs = list(zip(state_from.placements, state_to.placements, strict=True))
        changed = sum(UNPLACED not in pair and pair[0] != pair[1] for pair in pairs)
        if changed or any(UNPLACED in pair for pair in pairs):
            return changed * price
        return min(self.least_travel(state_from.q, state_to.q, state_to.placements), price)

    def least_travel(self, q_from: Coordinates, q_to: Coordinates, placements: Placements) -> float:
        """Return the longest straight way of a fingertip between two poses of the object."""
        centres = [
            self.judge.centres(i)[row] for i, row in enumerate(placements) if row != UNPLACED
        ]
        if not centres:
            return 0.0
        points, pose = np.array(centres), self.pose
        ways = pose(q_to).apply(points) - pose(q_from).apply(points)
        return float(np.linalg.norm(ways, axis=1).max())


class PointsOfWay:
    """Points of a passage at which a model judges rests and regrasps.

    Args:
        model: the model.
        points: where the passage's arcs begin and end.
    """

    def __init__(self, model: HybridModel, points: Sequence[Coordinates]) -> None:
        self._judging, self._points = model, points

    @property
    def arcs(self) -> int:
        """How many arcs there are."""
        return len(self._points) - 1

    def rests(self, point: int, placements: Placements, finger: int) -> bool:
        """Whether the object rests at a point while ``finger`` is lifted."""
        return self._judging.rests(self._points[point], placements, finger)

    def regrasped(
        self, point: int, placements: Placements, finger: int, target: int
    ) -> Regrasp | None:
        """Return a regrasp at a point, or None where it fails."""
        return self._judging.regrasp(self._points[point], placements, finger, target)


@final
class CoordinateModel(HybridModel):
    """What is possible between the lattice's nodes, at any coordinates.

    Args:
        problem: what is planned.
        judge: answers about ``problem``; its memos are shared with everybody who uses it.
    """

    def __init__(self, problem: Problem, judge: Judge) -> None:
        super().__init__(problem, judge)
        self._lines: dict[tuple[Coordinates, Coordinates], RouteLine] = {}

    @property
    def start(self) -> Coordinates:
        """The coordinates of the start."""
        return self.problem.start

    def pose(self, q: Coordinates) -> Pose:
        """Return the pose at coordinates ``q``."""
        return self.problem.motion.pose(q)

    def noted(self, q: Coordinates) -> Coordinates:
        """Return ``q``."""
        return q

    def where(self, move: Regrasp) -> Coordinates:
        """Return the coordinates during a regrasp."""
        return move.at

    def same(self, a: Coordinates, b: Coordinates) -> bool:
        """Whether ``a`` and ``b`` are equal, whole periods and rounding apart."""
        return same(self.problem, a, b)

    def arrived(self, q: Coordinates) -> bool:
        """Whether ``q`` is in the goal."""
        return self.problem.goal.contains(q)

    def displacement(
        self, q_from: Coordinates, q_to: Coordinates, placements: Placements
    ) -> tuple[Displacement, ...] | None:
        """Return the straight displacement from ``q_from`` to ``q_to``, or None if it fails.

        Args:
            q_from: where it starts.
            q_to: where it ends; coordinates that wrap are taken as they are, not the short way.
            placements: per finger, all placed.

        Returns:
            One move per piece that it passes through; none where the ends are the same.
        """
        if q_from == q_to:
            return () if self.state_valid(q_from, placements) else None
        if not (self.state_valid(q_to, placements) and self.state_valid(q_from, placements)):
            return None
        points = split(self.problem, q_from, q_to)
        lines = [self.line(a, b) for a, b in itertools.pairwise(points)]
        if not all(line.admits(placements) for line in lines):
            return None
        moves = []
        for line in reversed(lines):  # what lies furthest ahead fails most often
            move = self._along(line, placements)
            if move is None:
                return None
            moves.append(move)
        return tuple(reversed(moves))

    def line(self, start: Coordinates, end: Coordinates) -> RouteLine:
        """Return the straight motion between two points of one piece, as densely as required."""
        known = self._lines.get((start, end))
        if known is None:
            strides = strides_needed(self.problem, start, end)
            known = RouteLine(self.judge, start, end, strides * self.problem.cost.samples_per_arc)
            if len(self._lines) >= LINES:
                self._lines.clear()
            self._lines[start, end] = known
        return known

    def _along(self, line: RouteLine, placements: Placements) -> Displacement | None:
        decisions = line.decisions(placements)
        if decisions is None:
            return None
        z = [decision.z for decision in decisions]
        lengths = line.lengths(placements).tolist()
        cost = displacement_cost(lengths, z, self.problem.cost.stability, self.problem.z_floor)
        return Displacement(line.arc, line.start, line.end, placements, decisions, cost)
