"""Joint paths along moves: inverse kinematics followed along arcs, RRTConnect between them.

A configuration's branch is kept along an arc: each row is where Newton's steps lead from the row
before. Where it ends - a limit, a link in the way, a jump - another branch is tried, from the last
place where there was a choice.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.paths import JointPaths, JointRefusal
from gm_ompl.planners.joint_regrasp import ArmRegrasps
from gm_ompl.planners.joint_torques import MotorJudge
from gm_ompl.planners.joint_transit import Transits
from gm_ompl.problem import Displacement, Move, Placements, Regrasp

STRIDE: Final = 0.03
"""How far fingertips go between two rows at most, in the object's diagonals."""

JUMP: Final = 0.25
"""A hinge that turns further between two rows has left its branch [rad]."""

BRANCHES: Final = 3
"""Configurations tried per finger and placement."""

CHOICES: Final = 24
"""Configurations of the whole hand tried where there is a choice."""


@final
class JointPlanner:
    """Finds joint paths along a problem's moves.

    Args:
        judge: of a problem with a hand.
        rng: of the transits' random numbers.
    """

    def __init__(self, judge: Judge, rng: np.random.Generator) -> None:
        assert judge.hand is not None
        self._judge, self._reach = judge, judge.hand
        self._model, self._solver = judge.hand.model, judge.hand.kinematics
        self._motors = MotorJudge(judge.problem, self._model)
        self._transits = Transits(judge.hand, judge.problem.fingers, rng)
        self._arm = ArmRegrasps(judge.hand, self._transits, rng)
        self._every = np.ones(len(self._model.spec.joints), dtype=bool)
        self._all = tuple(range(self._model.count))
        self._deepest = JointRefusal(-1, 0.0, 0, "")

    def paths(self, moves: Sequence[Move]) -> JointPaths | JointRefusal:
        """Return joint paths along ``moves``, or why there are none."""
        self._deepest = JointRefusal(-1, 0.0, 0, "")
        problem, spec = self._judge.problem, self._model.spec
        first = moves[0]
        pose = first.arc.start if isinstance(first, Displacement) else first.pose
        for q in itertools.islice(self._starts(pose, first.placements), CHOICES):
            rows = self._onward(moves, 0, q)
            if rows is None:
                continue
            short = self._motors.refusal(moves, rows)
            if short is not None:
                self._failed(short)
                continue
            approach = retreat = None
            if len(problem.fingers.standing) == len(self._all):
                approach = q[None]
            else:
                approach = self._transits.home(pose, first.placements, q)
            if approach is None:
                self._failed(JointRefusal(0, 0.0, self._all[-1], "finds no way from home"))
                continue
            where, last = _end(moves[-1])
            retreat = self._transits.home(where, last, rows[-1][-1])
            if retreat is None:
                why = "finds no way home"
                self._failed(JointRefusal(len(moves) - 1, 1.0, self._all[-1], why))
                continue
            return JointPaths(spec.joints, approach, tuple(rows), retreat[::-1])
        if self._deepest.move < 0:
            return JointRefusal(0, 0.0, self._all[-1], "has no configuration beside the others")
        return self._deepest

    def _failed(self, refusal: JointRefusal) -> None:
        if (refusal.move, refusal.share) >= (self._deepest.move, self._deepest.share):
            self._deepest = refusal

    def _starts(self, pose: Pose, placements: Placements) -> Iterator[Array]:
        """Yield configurations with all fingertips on their placements, nothing penetrating."""
        model, home = self._model, self._model.spec.home
        targets = self._targets(pose, placements)
        if all((own == chain).all() for own, chain in zip(model.own, model.chains, strict=True)):
            found = [
                list(itertools.islice(self._solver.solutions(i, targets[i], home), BRANCHES))
                for i in self._all
            ]
            wholes: Iterator[Array] = map(self._merged, itertools.product(*found))
        else:
            wholes = self._together(targets)
        for q in wholes:
            model.place(q, pose)
            if model.hit(self._reach.touch) is None:
                yield q

    def _merged(self, parts: tuple[Array, ...]) -> Array:
        q = self._model.spec.home.copy()
        for chain, part in zip(self._model.chains, parts, strict=True):
            q[chain] = part[chain]
        return q

    def _together(self, targets: Array) -> Iterator[Array]:
        """Yield configurations of fingers that share an arm."""
        for i in self._all:
            for q in self._solver.solutions(i, targets[i], self._model.spec.home):
                whole = self._solver.follow(q, self._all, targets, self._every)
                if whole is not None:
                    yield whole

    def _targets(self, pose: Pose, placements: Placements) -> Array:
        centres = [self._reach.centres[i][row] for i, row in enumerate(placements)]
        return pose.apply(np.array(centres))

    def _onward(self, moves: Sequence[Move], number: int, q: Array) -> list[Array] | None:
        """Return rows per move from ``number`` on, from configuration ``q``."""
        if number == len(moves):
            return []
        limits.check()
        move = moves[number]
        if isinstance(move, Displacement):
            rows = self._along(move, number, q)
            choices: Iterator[Array] = iter(() if rows is None else (rows,))
        else:
            choices = self._regrasps(move, number, q)
        for rows in choices:
            onward = self._onward(moves, number + 1, rows[-1])
            if onward is not None:
                return [rows, *onward]
        return None

    def _along(self, move: Displacement, number: int, q: Array) -> Array | None:
        """Return rows (m, k) along a displacement; None where the branch ends."""
        rows = [q]
        for t in self._instants(move):
            pose = move.arc.pose(t)
            targets = self._targets(pose, move.placements)
            ahead = 2.0 * rows[-1] - rows[-2] if len(rows) > 1 else q
            ahead = np.clip(ahead, self._model.spec.low, self._model.spec.high)
            new = self._solver.follow(ahead, self._all, targets, self._every)
            who, why = self._wrong(rows[-1], new, targets, pose)
            if new is None or why:
                self._failed(JointRefusal(number, t, who, why))
                return None
            rows.append(new)
        return np.array(rows)

    def _instants(self, move: Displacement) -> list[float]:
        """Return where along an arc rows are, the tail left out."""
        centres = np.array([self._reach.centres[i][row] for i, row in enumerate(move.placements)])
        places = [move.arc.pose(t).apply(centres) for t in np.linspace(0.0, 1.0, 9)]
        length = np.linalg.norm(np.diff(places, axis=0), axis=2).sum(axis=0).max()
        stride = STRIDE * self._judge.problem.body.diagonal
        count = max(2, len(move.segments), int(np.ceil(length / stride)))
        return [(k + 1) / count for k in range(count)]

    def _wrong(self, old: Array, new: Array | None, targets: Array, pose: Pose) -> tuple[int, str]:
        """Return who cannot go on from ``old`` to ``new``, and why; no reason where all can."""
        if new is None:
            for i in self._all:
                chain = self._model.chains[i]
                if self._solver.follow(old, (i,), targets[i : i + 1], chain) is None:
                    return i, "is out of reach"
            return self._all[-1], "is out of reach beside the others"
        turned = np.abs(new - old)
        if turned.max() > JUMP:
            joint = int(turned.argmax())
            who = next(i for i in self._all if self._model.chains[i][joint])
            return who, f"has to jump at {self._model.spec.joints[joint]}"
        self._model.place(new, pose)
        hit = self._model.hit(self._reach.touch)
        if hit is None:
            return 0, ""
        return max(hit.first, hit.second, 0), f"has {hit.names[0]} in {hit.names[1]}"

    def _regrasps(self, move: Regrasp, number: int, q: Array) -> Iterator[Array]:
        """Yield rows (m, k) that take the lifted finger to its new placement.

        First with its own hinges alone, then with those of an arm that it shares.
        """
        why = "does not reach it beside the others"
        for rows in itertools.chain(self._alone(move, q), self._arm.ways(move, q)):
            short = None if rows is None else self._motors.regrasp(move, rows)
            if rows is not None and short is None:
                yield rows
            why = short or "finds no way through the air"
        self._failed(JointRefusal(number, 0.0, move.finger, why))

    def _alone(self, move: Regrasp, q: Array) -> Iterator[Array | None]:
        """Yield ways of the lifted finger's own hinges: None where one finds none."""
        i, own = move.finger, self._model.own[move.finger]
        target = move.pose.apply(self._reach.centres[i][move.target])
        ends = self._solver.solutions(i, target, q, own) if own.any() else iter(())
        for end in itertools.islice(ends, BRANCHES):
            self._model.place(end, move.pose)
            if self._model.hit(self._reach.touch) is None:
                yield self._transits.regrasp(move, q, end)


def _end(move: Move) -> tuple[Pose, Placements]:
    """Return where the object and the fingers are after a move."""
    if isinstance(move, Displacement):
        return move.arc.end, move.placements
    i = move.finger
    return move.pose, (*move.placements[:i], move.target, *move.placements[i + 1 :])
