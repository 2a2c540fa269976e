"""Commanded forces along a plan: the least total change that costs (almost) no stability.

For given modes z(f_com) is concave, so the f_com that keep it near its best form a convex set per
instant; the total change sum |f_com(k+1) - f_com(k)| over all instants and fingers is a linear
objective. The sets are only known through cuts z <= c + slopes . f_com: one linear program for the
whole plan is solved again and again, a cut added wherever its answer is not stable enough.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.errors import SolverError
from gm_ompl.feasibility.links import Link, failing

if TYPE_CHECKING:
    from scipy import sparse

    from gm_ompl.mechanics.case_alternatives import Choices

ROUNDS = 40
"""Linear programs per plan; instants not settled by then keep the f_com that is best for z."""

INSIDE = 1e-3
"""How far inside its cuts a link is to stay, in thousandths of the largest force."""

TOLERANCES = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-9}
"""Of the linear program."""

SHORT, PRICE = 1e-6, 1e3
"""A cut of a link that is missed by more cannot be met; and what missing it costs."""


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

    alternatives: Choices
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
        """Whether f_com stays.

        At z = 0 no cut tells how far it is from losing equilibrium; z_strong knows of no cuts.
        """
        return self.decision.z <= 0.0 or self.decision.nominal is not None

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
        return self.decision._replace(z=float(z), f_com=commands)


def least_change(
    commands: Sequence[Undecided], links: Sequence[Link] = ()
) -> tuple[list[ModeDecision], list[Link]]:
    """Choose f_com at every instant so that its total change is least.

    Args:
        commands: at the instants, in order.
        links: ramps between them; that they hold comes first.

    Returns:
        A decision per command, and the links that do not hold with them.
    """
    best = [command.decision for command in commands]
    before = np.concatenate([command.best for command in commands])
    program = _Program(commands, links)
    if not len(before) or not (program.changes(before) or failing(links, before)):
        return best, failing(links, before)
    last = None
    for _ in range(ROUNDS):
        f = program.solve()
        if f is None:
            return best, failing(links, before)
        if _settled(commands, program.parts(f)) and program.linked(f):
            break
        if last is not None and np.array_equal(f, last):
            break  # nothing was learnt
        last = f
    chosen = [command.chosen() for command in commands]
    f = np.array([x for decision in chosen for x in decision.f_com if x is not None])
    left = failing(links, f)
    better = program.changes(f) < program.changes(before)
    if left or not better:
        fallen = failing(links, before)
        if (len(fallen), better) <= (len(left), False):
            return best, fallen
    return chosen, left


def _settled(commands: Sequence[Undecided], parts: Sequence[Array]) -> bool:
    """Try f_com at every instant; return whether all are stable enough."""
    for command, part in zip(commands, parts, strict=True):
        if command.fixed or not len(part):
            continue
        if command.settled is None or not np.array_equal(part, command.settled[0]):
            limits.check()
            command.try_at(part)
    return all(command.settled is not None or not command.forced for command in commands)


class _Program:
    """min sum |change| over all f_com, under the cuts known so far.

    Cuts of links may be broken, at a price above any change: a link may have no f_com at all.
    """

    def __init__(self, commands: Sequence[Undecided], links: Sequence[Link]) -> None:
        self._commands, self._links = commands, links
        self._firsts = np.cumsum([0, *(len(command.forced) for command in commands)])
        at = [(c.best, c.best) if c.fixed else (0.0 * c.limits, c.limits) for c in commands]
        self._lowest = np.concatenate([lowest for lowest, _ in at])
        self._limits = np.concatenate([most for _, most in at])
        self._short = np.zeros(len(links))
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

    def linked(self, f: Array) -> bool:
        """Whether every link holds, but for those that no f_com under the cuts would keep."""
        held = np.array([link.holds(f) for link in self._links], dtype=bool)
        return bool(np.all(held | (self._short > SHORT)))

    def _cuts(self, unit: float) -> Iterator[tuple[Array, IntArray, float]]:
        """Yield the cuts as rows of the program: values, columns, upper bound."""
        for k, command in enumerate(self._commands):
            columns = np.arange(*self._firsts[k : k + 2])
            for c, slopes in command.cuts:
                # c + slopes . f >= aim, divided so that the solver's tolerance is one of z.
                size = max(command.aim, 1e-3 * unit)
                yield -slopes * unit / size, columns, (c - command.aim) / size
        first = len(self._limits) + len(self._pairs)
        for k, link in enumerate(self._links):
            for c, slopes, places in link.cuts:
                size, own = 1e-3 * unit, places > 0
                values = np.append(-slopes[own] * unit / size, -1.0)
                yield values, np.append(places[own] - 1, first + k), c / size - INSIDE

    def _rows(self, unit: float) -> tuple[sparse.csc_array, Array]:
        """Return the rows of changes and cuts, forces over ``unit``, and their upper bounds.

        Per pair of commands, both f' - f and f - f' are at most the change.
        """
        from scipy import sparse

        F, M, L = len(self._limits), len(self._pairs), len(self._links)
        pairs = np.column_stack([self._pairs, np.arange(F, F + M)])
        rows = [(np.tile([-1.0, 1.0, -1.0], M), pairs.ravel(), 0.0)]
        rows += [(np.tile([1.0, -1.0, -1.0], M), pairs.ravel(), 0.0), *self._cuts(unit)]
        values, columns, most = zip(*rows, strict=True)
        counts = [3] * (2 * M) + [len(each) for each in values[2:]]
        every = np.concatenate(values), np.concatenate(columns), np.cumsum([0, *counts])
        matrix = sparse.csr_array(every, shape=(len(counts), F + M + L))
        return sparse.csc_array(matrix), np.array([0.0] * (2 * M) + list(most[2:]))

    def solve(self) -> Array | None:
        """Return the f_com of least change under the cuts; None where the solver gives up."""
        # Imported late: most plans need no such program, and HiGHS takes a while to load.
        from gm_ompl.reference.highs import solve
        from gm_ompl.reference.program import LinearProgram

        F, M, L = len(self._limits), len(self._pairs), len(self._links)
        unit = float(self._limits.max()) or 1.0
        matrix, most = self._rows(unit)
        program = LinearProgram(
            cost=np.concatenate([np.zeros(F), np.ones(M), np.full(L, PRICE)]),
            matrix=matrix,
            row_lower=np.full(len(most), -np.inf),
            row_upper=most,
            col_lower=np.concatenate([self._lowest / unit, np.zeros(M + L)]),
            col_upper=np.concatenate([self._limits / unit, np.full(M + L, np.inf)]),
        )
        try:
            x = solve(program, time_limit=limits.left(), **TOLERANCES).x
        except SolverError:
            x = np.zeros(0)
        limits.check()
        if not len(x):
            return None
        self._short = x[F + M :]
        f: Array = np.clip(x[:F] * unit, 0.0, self._limits)
        return f
