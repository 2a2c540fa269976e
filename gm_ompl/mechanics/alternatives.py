"""What else Sec. 3.4 could have chosen: other modes nearly as good, and other f_com.

The best combination of modes is often one of several, and the best f_com a point of a range. A
plan may choose among them what is easier to carry out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.state import Instant
from gm_ompl.direct import direct
from gm_ompl.mechanics import modes
from gm_ompl.mechanics.central import settle_commands
from gm_ompl.mechanics.certificate import (
    NO_RECORD,
    into_polar,
    proven,
    reach,
    separates_environment,
)
from gm_ompl.mechanics.equilibrium import balance
from gm_ompl.mechanics.instant import as_decision, as_mask, instant_program, touching
from gm_ompl.mechanics.kelley import force_control
from gm_ompl.mechanics.program import Program
from gm_ompl.mechanics.simplex import INFEASIBLE, NO_TAU, TROUBLE, Target
from gm_ompl.mechanics.stability import BELOW, FAILED, REACHED, cut, run_pass
from gm_ompl.mechanics.tableau import NEVER
from gm_ompl.mechanics.tau import fill, new_tableau


def margin(program: Program, mask: int, below: float, f: Array) -> tuple[int, float, int]:
    """z of Problem (6) for given modes, the best f_com, and the direction that limits z.

    Args:
        program: what acts, and the fingers.
        mask: position-controlled fingers as bits.
        below: a threshold; where z is proven smaller, stop with an upper bound on z.
        f: output (n,): f_com for the force-controlled fingers.

    Returns:
        How it ended (see ``modes.decide``), z (or its bound, never below 0), the direction.
    """
    end, z, direction, _ = modes.decide(
        touching(program), below, -1, mask, NO_RECORD, f, np.zeros(6)
    )
    return end, max(z, 0.0), direction


_run_pass = direct(run_pass)


class Commanded:
    """z of Problem (6) for given modes and given f_com; room and what is known are kept.

    Args:
        program: what acts, and the fingers.
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        self._tableau = new_tableau(len(program.tips), len(program.env), program.tips.shape[1])
        self._separation = separates_environment(program.env)

    def margin(self, force: BoolArray, f: Array, slopes: Array) -> tuple[int, float, float]:
        """z for modes and commands, with a bound on it for every f_com.

        Args:
            force: (n,), who is force-controlled.
            f: (n,), f_com where force-controlled.
            slopes: output (number of force-controlled fingers,).

        Returns:
            REACHED or FAILED (no proof), z (-inf where nothing balances the load), and the
            constant c of the bound z(f_com) <= c + slopes . f_com, sharp at ``f`` where z is
            finite.
        """
        program, y = self._program, self._tableau.y
        cost, exactly = fill(program, force, f, self._tableau.raw), Target(np.inf, 0.0, NEVER)
        y[:] = 0.0
        end, _, _, v = _run_pass(self._tableau, cost, program.L, y, False, exactly)
        size = float(np.abs(y[:6]).max())
        wrench = y[:6] / size if size > NO_TAU else np.zeros(6)
        if end == TROUBLE or not into_polar(program.env, self._separation, wrench):
            return FAILED, 0.0, 0.0
        h = reach(program.L, wrench)
        c = cut(program, force, wrench, slopes) / h if h > 0.0 else np.inf
        slopes /= h or 1.0
        z = c + float(slopes @ f[force])
        if end == INFEASIBLE:
            return self._without_margin(force, f, (z, c), slopes)
        return REACHED if proven(v, z) else FAILED, z, c

    def equilibrium(self, force: BoolArray, f: Array, slopes: Array) -> tuple[int, float]:
        """Whether any forces balance the load under modes and commands, as for ``margin``.

        Returns:
            REACHED, BELOW or FAILED, as ``equilibrium.balance``; and where nothing does, the
            constant of 0 <= c + slopes . f_com, which holds wherever something does, and not here.
        """
        program, y = self._program, np.zeros(6)
        end = balance(program, self._separation, force, f, y, np.empty(len(f)))
        if end != BELOW:
            return end, np.inf
        h = reach(program.L, y)
        c = cut(program, force, y, slopes) / h
        slopes /= h
        return end, c

    def _without_margin(
        self, force: BoolArray, f: Array, allowed: tuple[float, float], slopes: Array
    ) -> tuple[int, float, float]:
        """z of ``margin`` where some direction cannot be resisted: 0 or -inf.

        ``allowed`` is z by the direction's bound c + slopes . f_com, and c; where that z is not
        negative but nothing balances the load, a bound by which it is takes its place.
        """
        (z, c), other = allowed, np.zeros_like(slopes)
        end, least = self.equilibrium(force, f, other)
        if end == REACHED:
            return REACHED, 0.0, c
        if end == BELOW and z >= 0.0:
            c, slopes[:] = least, other
        return (REACHED, -np.inf, c) if end == BELOW or z < 0.0 else (FAILED, 0.0, c)


def downward(
    largest: Sequence[int], n: int, decide: Callable[[int], ModeDecision | None]
) -> tuple[ModeDecision, ...]:
    """Return what ``decide`` finds, from the largest sets of position-controlled fingers down.

    A set for which it finds nothing has none below it.
    """
    waiting, met, found = list(largest), set(largest), []
    while waiting:
        mask = waiting.pop()
        decision = decide(mask)
        if decision is None:
            continue
        found.append(decision)
        for i in range(n):
            smaller = mask & ~(1 << i)
            if smaller not in met:
                met.add(smaller)
                waiting.append(smaller)
    return tuple(found)


@final
class Alternatives:
    """The choices at one instant; forces in the scenario's units.

    Args:
        scale: the kernel's unit of force, force_scale.
        program: what acts, and the fingers.
    """

    def __init__(self, scale: float, program: Program) -> None:
        self._scale, self._program = scale, program

    @cached_property
    def _commanded(self) -> Commanded:
        return Commanded(self._program)

    @classmethod
    def of(cls, instant: Instant) -> Alternatives:
        """Return the choices at an instant."""
        return cls(instant.force_scale, instant_program(instant))

    def modes(self, least: float) -> tuple[ModeDecision, ...]:
        """Return every combination of modes that passes (5) with z >= ``least`` at its best f_com.

        A finger that goes from position to force control can only lower z, so the search goes
        down from the largest passing sets of position-controlled fingers and stops at those below
        ``least``. Combinations for which the kernel finds no proof are left out.
        """
        env, _, tips, _, _ = self._program
        passed = np.empty(1 << len(tips), dtype=np.int64)
        passes, _ = modes.passing_sets(env, tips, -1, False, passed)
        largest = [int(mask) for mask in passed[: max(passes, 0)]]
        return downward(largest, len(tips), lambda mask: self._best_command(mask, least))

    def _best_command(self, mask: int, least: float) -> ModeDecision | None:
        f = np.zeros(len(self._program.tips))
        end, z, direction = margin(self._program, mask, max(least / self._scale, 0.0), f)
        if end != modes.STABLE or z * self._scale < least:
            return None
        answer = (modes.STABLE, z, direction, mask)
        settle_commands(self._program, answer, f)
        return as_decision(*answer, f.tolist(), self._scale)

    def at(
        self, chosen: tuple[ControlMode, ...], f_com: Array
    ) -> tuple[float, float, Array] | None:
        """Return (z, c, slopes) for given modes and f_com; None where the kernel gives up.

        Args:
            chosen: per finger.
            f_com: (number of force-controlled fingers,).

        Returns:
            z at ``f_com``, and the bound z <= c + slopes . f_com that holds for every f_com.
        """
        force, f, slopes = self._asked(chosen, f_com)
        end, z, c = self._commanded.margin(force, f, slopes)
        return (z * self._scale, c * self._scale, slopes) if end == REACHED else None

    def balanced(
        self, chosen: tuple[ControlMode, ...], f_com: Array
    ) -> tuple[bool, float, Array] | None:
        """Return (whether anything balances the load, c, slopes), likewise.

        Where nothing does, 0 <= c + slopes . f_com fails at ``f_com`` alone, and where nothing
        does.
        """
        force, f, slopes = self._asked(chosen, f_com)
        end, c = self._commanded.equilibrium(force, f, slopes)
        return None if end == FAILED else (end == REACHED, c * self._scale, slopes)

    def _asked(
        self, chosen: tuple[ControlMode, ...], f_com: Array
    ) -> tuple[BoolArray, Array, Array]:
        """Return who is force-controlled (n,), f_com (n,) as the kernel has it, and slopes."""
        force = np.zeros(len(self._program.tips), dtype=np.bool_)
        force_control(as_mask(chosen), force)
        f = np.zeros(len(force))
        f[force] = f_com / self._scale
        return force, f, np.zeros(len(f_com))
