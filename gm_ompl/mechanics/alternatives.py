"""What else Sec. 3.4 could have chosen: other modes nearly as good, and other f_com.

The best combination of modes is often one of several, and the best f_com a point of a range. A
plan may choose among them what is easier to carry out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.state import Instant
from gm_ompl.mechanics import modes
from gm_ompl.mechanics.central import settle_commands
from gm_ompl.mechanics.certificate import into_polar, proven, reach, separates_environment
from gm_ompl.mechanics.equilibrium import balance
from gm_ompl.mechanics.instant import (
    DIRECTIONS,
    as_decision,
    as_mask,
    decide_columns,
    instant_columns,
)
from gm_ompl.mechanics.kelley import force_control
from gm_ompl.mechanics.resistance import new_resistance
from gm_ompl.mechanics.sides import SIDES
from gm_ompl.mechanics.simplex import INFEASIBLE, NO_TAU, TROUBLE
from gm_ompl.mechanics.stability import BELOW, FAILED, REACHED, cut, fill, run_pass
from gm_ompl.mechanics.tableau import NEVER


def margin(
    env: Array, q: Array, tips: Array, f_max: Array, mask: int, below: float, f: Array
) -> tuple[int, float, int]:
    """z of Problem (6) for given modes, the best f_com, and the direction that limits z.

    Args:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale, as all forces here.
        mask: position-controlled fingers as bits.
        below: a threshold; where z is proven smaller, stop with an upper bound on z.
        f: output (n,): f_com for the force-controlled fingers.

    Returns:
        How it ended (see ``modes.decide``), z (or its bound, never below 0), the direction.
    """
    end, z, direction, _ = decide_columns(env, q, tips, f_max, below, f, np.zeros(6), only=mask)
    return end, max(z, 0.0), direction


def commanded_margin(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, f: Array, slopes: Array
) -> tuple[int, float, float]:
    """z of Problem (6) for given modes and given f_com, with a bound on it for every f_com.

    Args:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale, as all forces here.
        force: (n,), who is force-controlled.
        f: (n,), f_com where force-controlled.
        slopes: output (number of force-controlled fingers,).

    Returns:
        REACHED or FAILED (no proof), z (-inf where nothing balances the load), and the constant c
        of the bound z(f_com) <= c + slopes . f_com, sharp at ``f`` where z is finite.
    """
    e, n, s = len(env), len(tips), tips.shape[1]
    m, N = 6 + n, 1 + e + n * s + n
    raw, T, d = np.empty((m, N)), np.empty((m, N + m + SIDES)), np.empty(N + m + SIDES)
    basis, y, w = np.empty(m, dtype=np.int64), np.empty(m), np.zeros(6)
    found = new_resistance(m)
    cost = fill(env, q, tips, f_max, force, f, raw)
    end, _, _, v = run_pass(
        raw, cost, DIRECTIONS, T, d, basis, y, False, np.inf, 0.0, NEVER, y, found
    )
    size = float(np.abs(y[:6]).max())
    wrench = y[:6] / size if size > NO_TAU else np.zeros(6)
    if end == TROUBLE or not into_polar(env, w, separates_environment(env, w), wrench):
        return FAILED, 0.0, 0.0
    h = reach(DIRECTIONS, wrench)
    c = cut(q, tips, f_max, force, wrench, slopes) / h if h > 0.0 else np.inf
    slopes /= h or 1.0
    z = c + float(slopes @ f[force])
    if end == INFEASIBLE:
        return _balanced_margin(env, q, tips, f_max, force, f, z, c, slopes)
    return REACHED if proven(v, z) else FAILED, z, c


def _balanced_margin(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, f: Array, z: float,
    c: float, slopes: Array,
) -> tuple[int, float, float]:  # fmt: skip
    """z of ``commanded_margin`` where some direction cannot be resisted: 0 or -inf.

    ``z`` is what the direction's bound c + slopes . f_com allows; where that is not negative but
    nothing balances the load, a bound that is takes its place.
    """
    w, y = np.zeros(6), np.zeros(6)
    margin = separates_environment(env, w)
    end = balance(env, q, tips, f_max, force, f, DIRECTIONS, w, margin, y, np.empty(len(f)))
    if end == REACHED:
        return REACHED, 0.0, c
    if end == BELOW and z >= 0.0:
        h = reach(DIRECTIONS, y)
        c = cut(q, tips, f_max, force, y, slopes) / h
        slopes /= h
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
        env: (e, 6), the environment's columns.
        q: (6,), the load over force_scale.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale.
    """

    def __init__(self, scale: float, env: Array, q: Array, tips: Array, f_max: Array) -> None:
        self._scale, self._env, self._q, self._tips, self._f_max = scale, env, q, tips, f_max

    @classmethod
    def of(cls, instant: Instant) -> Alternatives:
        """Return the choices at an instant."""
        return cls(instant.force_scale, *instant_columns(instant))

    def modes(self, least: float) -> tuple[ModeDecision, ...]:
        """Return every combination of modes that passes (5) with z >= ``least`` at its best f_com.

        A finger that goes from position to force control can only lower z, so the search goes
        down from the largest passing sets of position-controlled fingers and stops at those below
        ``least``. Combinations for which the kernel finds no proof are left out.
        """
        passed = np.empty(1 << len(self._tips), dtype=np.int64)
        passes, _ = modes.passing_sets(self._env, self._tips, -1, False, passed, np.zeros(6))
        largest = [int(mask) for mask in passed[: max(passes, 0)]]
        return downward(largest, len(self._tips), lambda mask: self._best_command(mask, least))

    def _best_command(self, mask: int, least: float) -> ModeDecision | None:
        f = np.zeros(len(self._tips))
        end, z, direction = margin(
            self._env, self._q, self._tips, self._f_max, mask, max(least / self._scale, 0.0), f
        )
        if end != modes.STABLE or z * self._scale < least:
            return None
        answer = (modes.STABLE, z, direction, mask)
        settle_commands(self._env, self._q, self._tips, self._f_max, answer, DIRECTIONS, f)
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
        force = self._force(as_mask(chosen))
        f, slopes = np.zeros(len(force)), np.zeros(len(f_com))
        f[force] = f_com / self._scale
        end, z, c = commanded_margin(self._env, self._q, self._tips, self._f_max, force, f, slopes)
        return (z * self._scale, c * self._scale, slopes) if end == REACHED else None

    def _force(self, mask: int) -> BoolArray:
        force = np.zeros(len(self._tips), dtype=np.bool_)
        force_control(mask, force)
        return force
