"""From two states to the moves between them: one expansion for validity, cost and plan.

A motion between two states is regrasps at its start, in a deterministic order, followed by one
straight displacement of the object. It is one-way: the reverse must be judged by itself.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple, final

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.cost import displacement_cost
from gm_ompl.holds.goals import fits
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Displacement, Move, Placements, Problem, Regrasp
from gm_ompl.sampling.lines import Line, same, split, strides_needed, unwrapped

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


@final
class ContinuousModel:
    """What is possible between the lattice's nodes, at any coordinates.

    Args:
        problem: what is planned.
        judge: answers about ``problem``; its memos are shared with everybody who uses it.
    """

    def __init__(self, problem: Problem, judge: Judge) -> None:
        self.problem, self.judge = problem, judge
        self._fingers = tuple(range(problem.fingers.count))
        self._z_min = problem.mechanics.z_min
        self._lines: dict[tuple[Coordinates, Coordinates], Line] = {}

    def start_state(self) -> HybridState:
        """Return the start: fingers with a given start placement there, the others UNPLACED."""
        given = self.problem.fingers.start
        return HybridState(
            self.problem.start, tuple(UNPLACED if row is None else row for row in given)
        )

    def in_goal(self, state: HybridState) -> bool:
        """Whether the object is in the goal and the fingers are where the goal wants them."""
        problem = self.problem
        fitting = problem.goal.contains(state.q) and fits(state.placements, problem.fingers.goal)
        return fitting and self.leaves(state)

    def lands(self, placements: Placements) -> bool:
        """Whether the fingers can touch the object at the start, one after the other."""
        pose, standing = self.problem.motion.pose(self.problem.start), self.problem.fingers.standing
        return self.judge.reach.landing(pose, placements, standing) is not None

    def leaves(self, state: HybridState) -> bool:
        """Whether the fingers can leave the object, one after the other, where they must."""
        if not self.problem.fingers.leave:
            return True
        pose = self.problem.motion.pose(state.q)
        return self.judge.reach.landing(pose, state.placements) is not None

    def state_valid(self, q: Coordinates, placements: Placements) -> bool:
        """Whether nothing penetrates at ``q``; fingers that are UNPLACED touch nothing."""
        placed = [i for i in self._fingers if placements[i] != UNPLACED]
        node, clear = self.judge.node(self.problem.motion.pose(q)), self.judge.clear
        if not node.object_free or not all(node.free[i][placements[i]] for i in placed):
            return False
        for k, i in enumerate(placed):
            for j in placed[:k]:
                pair = clear[i][j]
                if pair is not None and not pair[placements[i], placements[j]]:
                    return False
        return True

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

    def line(self, start: Coordinates, end: Coordinates) -> Line:
        """Return the straight motion between two points of one piece, as densely as required."""
        known = self._lines.get((start, end))
        if known is None:
            strides = strides_needed(self.problem, start, end)
            known = Line(self.judge, start, end, strides * self.problem.cost.samples_per_arc)
            if len(self._lines) >= LINES:
                self._lines.clear()
            self._lines[start, end] = known
        return known

    def _along(self, line: Line, placements: Placements) -> Displacement | None:
        decisions = line.decisions(placements)
        if decisions is None:
            return None
        z = [decision.z for decision in decisions]
        lengths = line.lengths(placements).tolist()
        cost = displacement_cost(lengths, z, self.problem.cost.stability, self.problem.z_floor)
        return Displacement(line.arc, line.start, line.end, placements, decisions, cost)

    def regrasp(
        self, q: Coordinates, placements: Placements, finger: int, target: int
    ) -> Regrasp | None:
        """Return the regrasp of ``finger`` to ``target`` at ``q``, or None if it fails."""
        after = (*placements[:finger], target, *placements[finger + 1 :])
        if target in placements or not self.state_valid(q, after):
            return None
        if not self.state_valid(q, placements):
            return None
        others = tuple(i for i in self._fingers if i != finger)
        rows = tuple(placements[i] for i in others)
        pose = self.problem.motion.pose(q)
        rest = self.judge.rest(pose, others, rows, self._z_min)
        if not rest.z >= self._z_min:
            return None
        staying = tuple(zip(others, rows, strict=True))
        if not self.judge.reach.joined(pose, finger, staying, placements[finger], target):
            return None
        cost = self.problem.cost.regrasp
        return Regrasp(pose, q, finger, target, placements, rest, cost)

    def expand(self, state_from: HybridState, state_to: HybridState) -> list[Move] | None:
        """Return the moves from one state to another, or None where they fail.

        Fingers that are UNPLACED in ``state_from`` go to where ``state_to`` has them for free;
        they never become UNPLACED again. Coordinates that wrap go the shorter way.
        """
        if UNPLACED in state_to.placements:
            return None
        here = zip(state_from.placements, state_to.placements, strict=True)
        placements = tuple(b if a == UNPLACED else a for a, b in here)
        if UNPLACED in state_from.placements and not self.lands(placements):
            return None
        q_from = state_from.q
        q_to = unwrapped(self.problem, state_to.q, q_from)
        if not self.state_valid(q_to, state_to.placements):
            return None
        regrasps = self._regrasps(q_from, placements, state_to.placements)
        if regrasps is None:
            return None
        if same(self.problem, q_from, q_to):
            return list(regrasps) if self.state_valid(q_from, state_to.placements) else None
        path = self.displacement(q_from, q_to, state_to.placements)
        return None if path is None else [*regrasps, *path]

    def _regrasps(
        self, q: Coordinates, placements: Placements, wanted: Placements
    ) -> tuple[Regrasp, ...] | None:
        """Return the first order of regrasps that works, in the fingers' lexicographic order."""
        changed = [i for i in self._fingers if placements[i] != wanted[i]]
        if not changed:
            return ()
        return next(self._orders(q, placements, wanted, tuple(changed)), None)

    def _orders(
        self, q: Coordinates, placements: Placements, wanted: Placements, left: tuple[int, ...]
    ) -> Iterator[tuple[Regrasp, ...]]:
        if not left:
            yield ()
            return
        for finger in left:
            move = self.regrasp(q, placements, finger, wanted[finger])
            if move is None:
                continue
            after = (*placements[:finger], wanted[finger], *placements[finger + 1 :])
            rest = tuple(i for i in left if i != finger)
            for others in self._orders(q, after, wanted, rest):
                yield (move, *others)

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
        points, pose = np.array(centres), self.problem.motion.pose
        ways = pose(q_to).apply(points) - pose(q_from).apply(points)
        return float(np.linalg.norm(ways, axis=1).max())
