"""Commanded forces along a plan: the least total change that costs (almost) no stability.

For given modes z(f_com) is concave, so the f_com that keep it near its best form a convex set per
instant; the total change sum |f_com(k+1) - f_com(k)| over all instants and fingers is a linear
objective. The sets are only known through cuts z <= c + slopes . f_com: one linear program for the
whole plan is solved again and again, a cut added wherever its answer is not stable enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.mechanics.alternatives import Alternatives

PerFinger = tuple[ControlMode | None, ...]
"""Modes per finger of the whole hand; None for a finger in the air."""


def spread(decision: ModeDecision, fingers: Sequence[int], count: int) -> PerFinger:
    """Return the modes of ``decision``, made for ``fingers``, per finger of a hand of ``count``."""
    modes: list[ControlMode | None] = [None] * count
    for finger, mode in zip(fingers, decision.modes, strict=True):
        modes[finger] = mode
    return tuple(modes)


def switches(before: PerFinger, after: PerFinger) -> int:
    """Return how many fingers change their mode; lifting and touching down are no switches."""
    return sum(
        a is not None and b is not None and a is not b for a, b in zip(before, after, strict=True)
    )


def fewest_switches(
    options: Sequence[Sequence[ModeDecision]], fingers: Sequence[Sequence[int]], count: int
) -> list[ModeDecision]:
    """Choose one decision per instant so that modes switch as rarely as can be.

    A shortest path over the instants. Of paths with equally few switches the one with more
    position control is taken, then the one with the earlier fingers under position control.

    Args:
        options: per instant, in order, at least one decision.
        fingers: per instant, the fingers that its decisions are made for.
        count: fingers of the hand.
    """
    layers = [
        [(spread(option, touching, count), option) for option in choices]
        for choices, touching in zip(options, fingers, strict=True)
    ]
    best = [_taste(modes) for modes, _ in layers[0]]
    comes_from: list[list[int]] = []
    for before, after in pairwise(layers):
        costs, parents = [], []
        for modes, _ in after:
            ways = [
                (cost[0] + switches(earlier, modes), cost[1], cost[2], k)
                for k, (cost, (earlier, _)) in enumerate(zip(best, before, strict=True))
            ]
            least, taste = min(ways), _taste(modes)
            costs.append((least[0], least[1] + taste[1], least[2] + taste[2]))
            parents.append(least[3])
        best = costs
        comes_from.append(parents)
    k = min(range(len(best)), key=best.__getitem__)
    chosen = [layers[-1][k][1]]
    for layer, parents in zip(layers[-2::-1], comes_from[::-1], strict=True):
        k = parents[k]
        chosen.append(layer[k][1])
    return chosen[::-1]


def _taste(modes: PerFinger) -> tuple[int, int, int]:
    """Return (0 switches, force-controlled fingers, their place among combinations)."""
    forces = [i for i, mode in enumerate(modes) if mode is ControlMode.FORCE]
    return 0, len(forces), sum(1 << (len(modes) - 1 - i) for i in forces)


ROUNDS = 40
"""Linear programs per plan; instants not settled by then keep the f_com that is best for z."""


@dataclass(eq=False)
class Undecided:
    """f_com at an instant (or at a run of equal ones), to be chosen.

    Attributes:
        alternatives: of the instant.
        decision: the modes, and the best f_com for them.
        fingers: of the hand, those that touch.
        least: z must not fall below this.
        aim: the cuts ask for this, a little more.
        limits: f_max of the force-controlled fingers.
    """

    alternatives: Alternatives
    decision: ModeDecision
    fingers: tuple[int, ...]
    least: float
    aim: float
    limits: Array
    cuts: list[tuple[float, Array]] = field(default_factory=list)
    settled: tuple[Array, float] | None = None

    @property
    def forced(self) -> tuple[int, ...]:
        """The fingers of the hand that are force-controlled."""
        return tuple(
            finger
            for finger, mode in zip(self.fingers, self.decision.modes, strict=True)
            if mode is ControlMode.FORCE
        )

    def __post_init__(self) -> None:
        if self.fixed:
            self.settled = self.best, self.decision.z

    @property
    def fixed(self) -> bool:
        """Whether f_com stays: at z = 0 no cut tells how far it is from losing equilibrium."""
        return self.decision.z <= 0.0

    @property
    def best(self) -> Array:
        """The best f_com of the force-controlled fingers."""
        return np.array([f for f in self.decision.f_com if f is not None], dtype=np.float64)

    def try_at(self, f_com: Array) -> None:
        """Settle on ``f_com`` where it is stable enough, else learn a cut."""
        self.settled = None
        found = self.alternatives.at(self.decision.modes, f_com)
        if found is None:
            return
        z, c, slopes = found
        if z >= self.least:
            self.settled = f_com, z
        else:
            self.cuts.append((c, slopes))

    def chosen(self) -> ModeDecision:
        """Return the decision with the f_com settled on; the best one where there is none."""
        if self.settled is None:
            return self.decision
        f_com, z = self.settled
        left = iter(f_com.tolist())
        commands = tuple(None if f is None else float(next(left)) for f in self.decision.f_com)
        return ModeDecision(
            self.decision.outcome, float(z), self.decision.modes, commands, self.decision.direction
        )


def least_change(commands: Sequence[Undecided]) -> list[ModeDecision]:
    """Choose f_com at every instant so that its total change is least."""
    best = [command.decision for command in commands]
    program = _Program(commands)
    if not program.changes(np.concatenate([command.best for command in commands])):
        return best
    for _ in range(ROUNDS):
        f = program.solve()
        if f is None:
            return best
        for command, part in zip(commands, program.parts(f), strict=True):
            if command.fixed or not len(part):
                continue
            if command.settled is None or not np.array_equal(part, command.settled[0]):
                limits.check()
                command.try_at(part)
        if all(command.settled is not None or not command.forced for command in commands):
            break
    chosen = [command.chosen() for command in commands]
    f = np.array([x for decision in chosen for x in decision.f_com if x is not None])
    before = np.concatenate([command.best for command in commands])
    return chosen if program.changes(f) < program.changes(before) else best


class _Program:
    """min sum |change| over all f_com, under the cuts known so far."""

    def __init__(self, commands: Sequence[Undecided]) -> None:
        self._commands = commands
        self._firsts = np.cumsum([0, *(len(command.forced) for command in commands)])
        at = [(c.best, c.best) if c.fixed else (0.0 * c.limits, c.limits) for c in commands]
        self._lowest = np.concatenate([lowest for lowest, _ in at])
        self._limits = np.concatenate([most for _, most in at])
        pairs = []
        for k in range(len(commands) - 1):
            before, after = commands[k].forced, commands[k + 1].forced
            pairs += [
                (self._firsts[k] + before.index(i), self._firsts[k + 1] + after.index(i))
                for i in before
                if i in after
            ]
        self._pairs = np.array(pairs, dtype=np.int64).reshape(-1, 2)

    def changes(self, f: Array) -> float:
        """Return the total change."""
        return float(np.abs(f[self._pairs[:, 1]] - f[self._pairs[:, 0]]).sum())

    def parts(self, f: Array) -> list[Array]:
        """Return f_com per instant."""
        return [f[a:b] for a, b in zip(self._firsts, self._firsts[1:], strict=False)]

    def _cuts(self, unit: float) -> tuple[tuple[Array, IntArray, IntArray], list[float]]:
        """Return the rows of all cuts as (values, columns, ends), and their bounds."""
        slopes_of, columns = [np.zeros(0)], [np.zeros(0, dtype=np.int64)]
        bounds: list[float] = []
        for k, command in enumerate(self._commands):
            for c, slopes in command.cuts:
                # c + slopes . f >= aim, divided so that the solver's tolerance is one of z.
                size = max(command.aim, 1e-3 * unit)
                slopes_of.append(-slopes * unit / size)
                columns.append(np.arange(self._firsts[k], self._firsts[k + 1]))
                bounds.append((c - command.aim) / size)
        ends = np.cumsum([len(part) for part in columns])
        return (np.concatenate(slopes_of), np.concatenate(columns), ends), bounds

    def _bounds(self, unit: float, changes: int) -> Array:
        """Return the bounds on all f_com over ``unit``, then on the changes, one pair each."""
        lowest = np.concatenate([self._lowest / unit, np.zeros(changes)])
        most = np.concatenate([self._limits / unit, np.full(changes, np.inf)])
        return np.stack([lowest, most], axis=1)

    def solve(self) -> Array | None:
        """Return the f_com of least change under the cuts; None where the solver gives up."""
        # Imported late: most plans need no such program, and scipy takes a while to load.
        from scipy import sparse
        from scipy.optimize import linprog

        F, M = len(self._limits), len(self._pairs)
        unit = float(self._limits.max()) or 1.0
        step = sparse.csr_array(
            (
                np.tile([1.0, -1.0], M),
                (np.repeat(np.arange(M), 2), self._pairs[:, ::-1].ravel()),
            ),
            shape=(M, F),
        )
        eye = sparse.eye_array(M)
        values = [sparse.hstack([step, -eye]), sparse.hstack([-step, -eye])]
        cuts, bounds = self._cuts(unit)
        if bounds:
            values.append(sparse.csr_array(cuts, shape=(len(bounds), F + M)))
        result = linprog(
            np.concatenate([np.zeros(F), np.ones(M)]),
            A_ub=sparse.csr_array(sparse.vstack(values)),
            b_ub=np.concatenate([np.zeros(2 * M), np.array(bounds)]),
            bounds=self._bounds(unit, M),
            options={
                "primal_feasibility_tolerance": 1e-10,
                "dual_feasibility_tolerance": 1e-9,
                "time_limit": limits.left(),
            },
        )
        limits.check()
        if result.x is None:
            return None
        f: Array = np.clip(result.x[:F] * unit, 0.0, self._limits)
        return f
