"""Modes and commands that are best for z_strong, by trial.

z_strong is neither concave in f_com nor ordered by modes: a commanded force keeps a contact shut
where a position-controlled finger may let go. So every combination of modes that passes Problem
(5) is tried, with all commands that ``command_steps`` offers. Ways of giving way that have ruled
out some commands are tried on the next ones first.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Final, NamedTuple, TypeAlias, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome, command_steps
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.errors import SolverError
from gm_ompl.mechanics import columns, modes
from gm_ompl.mechanics.alternatives import Commanded
from gm_ompl.mechanics.deviations import UNTOLD, ContactRows, deviates
from gm_ompl.mechanics.instant import instant_program
from gm_ompl.mechanics.program import Program
from gm_ompl.mechanics.stability import REACHED
from gm_ompl.mechanics.strong import gives_way, least_for

BETTER: Final = 1e-7
"""By how much, relatively, later modes and commands must be better."""

KEPT: Final = 6
"""Ways of giving way that are tried first."""

PLAIN: Final = 1e-12
"""Friction up to this is none."""


Met: TypeAlias = dict[tuple[int, bytes, bytes], list[IntArray]]


class EnvironmentRows(NamedTuple):
    """The environment's part of ``ContactRows``.

    Attributes:
        columns: (C, 6).
        sizes: (m,), columns per contact.
        normal: (m, 6).
        plain: (m,).
    """

    columns: Array
    sizes: IntArray
    normal: Array
    plain: BoolArray


def environment_rows(
    contacts: ContactState, friction: Array, env: Array, U: Array
) -> EnvironmentRows:
    """Return the environment's part; ``friction`` (m,), ``env`` its columns of unit length."""
    slides = np.abs(contacts.slip).sum(axis=1) > 0
    m = len(contacts.points)
    edges = (len(env) - int(slides.sum())) // max(1, int((~slides).sum()))
    sizes = np.where(slides, 1, edges).astype(np.int64)
    each = np.repeat(np.sqrt(1.0 + friction**2), sizes)
    normal = columns.wrenches(contacts.points, contacts.normals, U) if m else np.zeros((0, 6))
    return EnvironmentRows(env * each[:, None], sizes, normal, slides | (friction < PLAIN))


def together(
    around: EnvironmentRows, tips: Array, friction: Array, force: BoolArray
) -> ContactRows:
    """Return all contacts, fingertips (n, s, 6) first; ``force`` says who is force-controlled."""
    n, s = tips.shape[:2]
    m = len(around.sizes)
    sizes = np.concatenate([np.full(n, s), around.sizes])
    return ContactRows(
        np.ascontiguousarray(np.concatenate([tips.reshape(-1, 6), around.columns])),
        np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        np.ascontiguousarray(np.concatenate([tips.mean(axis=1), around.normal])),
        np.concatenate([~force, np.ones(m, dtype=np.bool_)]),
        np.concatenate([friction < PLAIN, around.plain]),
    )


class Best(NamedTuple):
    """What is best for z_strong; forces over force_scale.

    Attributes:
        z_strong: the largest.
        z: of Problem (6), with the same modes and commands.
        mask: the position-controlled fingers, as bits.
        steps: (n,), commands over f_max; 0 under position control.
    """

    z_strong: float
    z: float
    mask: int
    steps: Array


@final
class StrongHand:
    """A hand at an instant whose modes and commands are chosen for z_strong.

    Args:
        around: the environment's contacts.
        program: what acts, and the fingers.
        friction: (n,), of the fingers.
        met: how contacts gave way before, for like contacts, with modes: tried first, and kept.

    Attributes:
        program: as given.
        lost: whether something that matters could not be proven.
        bound: of all modes and commands that were given up, z_strong is at most this.
    """

    def __init__(
        self, around: EnvironmentRows, program: Program, friction: Array, met: Met | None = None
    ) -> None:
        self._around, self.program, self._friction = around, program, friction
        self.lost, self.bound = False, -np.inf
        self.met: Met = {} if met is None else met

    @classmethod
    def of(cls, instant: Instant) -> StrongHand:
        """Return the hand of an instant with point fingertips in a certain world."""
        program = instant_program(instant)
        U = columns.wrench_norm(instant.mass, instant.inertia)
        friction = np.asarray(instant.friction_at_contacts, dtype=np.float64)
        around = environment_rows(instant.contacts, friction, program.env, U)
        return cls(around, program, np.asarray(instant.friction, dtype=np.float64))

    def best(self, below: float, only: int = -1) -> Best | None:
        """Return what is best for z_strong; None where it stays below ``below``.

        ``only`` names one combination of modes by its mask; -1 stands for all that pass (5).
        """
        best, enough = None, float(np.nextafter(below, -np.inf))
        for mask in self.passing() if only < 0 else [only]:
            trial = _Trial(self, mask)
            for steps in self._steps(mask):
                limits.check()
                found = trial.beyond(steps * self.program.f_max, enough)
                if found is not None:
                    best = Best(*found, mask, steps)
                    enough = best.z_strong * (1.0 + BETTER)
        return best

    def passing(self) -> list[int]:
        """Return the combinations of modes that pass Problem (5), most position control first."""
        env, _, tips, _, _ = self.program
        n = len(tips)
        largest = np.empty(1 << n, dtype=np.int64)
        count, _ = modes.passing_sets(env, tips, -1, False, largest)
        self.lost = self.lost or count < 0
        return [
            mask
            for mask in modes.preference(n, -1).tolist()
            if any(mask & whole == mask for whole in largest[: max(count, 0)].tolist())
        ]

    def contacts(self, mask: int) -> ContactRows:
        """Return all contacts under these modes."""
        return together(self._around, self.program.tips, self._friction, self.force(mask))

    def _steps(self, mask: int) -> Iterator[Array]:
        """Yield commands over f_max (n,), large ones first; 0 under position control."""
        force = self.force(mask)
        steps = command_steps(int(force.sum()))
        for chosen in itertools.product(*(steps if f else (0.0,) for f in force)):
            yield np.array(chosen)

    def force(self, mask: int) -> BoolArray:
        """Return who is force-controlled (n,)."""
        return np.array([not (mask >> i) & 1 for i in range(len(self._friction))], dtype=np.bool_)


@final
class _Trial:
    """Tries one combination of modes of a hand."""

    def __init__(self, hand: StrongHand, mask: int) -> None:
        self._hand, self._force, self._rows = hand, hand.force(mask), hand.contacts(mask)
        key = (mask, self._rows.first.tobytes(), self._rows.plain.tobytes())
        known = hand.met.setdefault(key, [])
        self._killers = known
        known[:] = [ways for ways in known if deviates(self._rows, ways)]
        self._cuts: list[tuple[float, Array]] = []

    def beyond(self, f: Array, enough: float) -> tuple[float, float] | None:
        """Return z_strong and z with commands f (n,); None where z_strong is at most enough."""
        bound, found = self._tried(f, enough)
        if found is None:
            self._hand.bound = max(self._hand.bound, bound)
        return found

    def _tried(self, f: Array, enough: float) -> tuple[float, tuple[float, float] | None]:
        """Return an upper bound on z_strong, and what ``beyond`` does."""
        hand, program, own = self._hand, self._hand.program, f[self._force]
        for c, slopes in self._cuts:
            if c + float(slopes @ own) <= enough:
                return c + float(slopes @ own), None
        limit, least = np.where(self._force, f, program.f_max), np.inf
        for ways in self._killers:
            t = least_for(self._rows, program.q, limit, program.L, ways, least)
            if t <= enough:
                return t, None
            least = min(least, t)
        slopes = np.zeros(len(own))
        end, z, c = Commanded(program).margin(self._force, f, slopes)
        if end != REACHED:
            hand.lost = True
            return np.inf, None
        self._cuts.append((c, slopes))
        if z <= enough:
            return z, None
        ways = np.full(len(self._rows.normal), UNTOLD)
        t = gives_way(self._rows, program.q, limit, program.L, min(z, least), enough, ways)
        if len(ways) and ways[0] != UNTOLD:
            self._killers.insert(0, ways)
            del self._killers[KEPT:]
        return t, (t, z) if t > enough else None


def strongest(instant: Instant, below: float = 0.0) -> ModeDecision:
    """Return the decision at an instant whose z_strong is largest.

    Where none reaches ``below`` it is BELOW.

    Raises:
        SolverError: the kernel found no proof.
    """
    hand = StrongHand.of(instant)
    best = hand.best(below / instant.force_scale)
    if hand.lost:
        raise SolverError("the mechanics kernel found no strong margin that it can prove")
    return as_strong(best, hand.bound, instant.force_scale, instant.max_normal_force, below)


def strongly_held(instant: Instant, decision: ModeDecision) -> float:
    """Return z_strong of a decision: of its modes, its commands and its z."""
    hand, scale = StrongHand.of(instant), instant.force_scale
    mask = sum(1 << i for i, m in enumerate(decision.modes) if m is ControlMode.POSITION)
    rows = hand.contacts(mask)
    pairs = zip(decision.f_com, instant.max_normal_force, strict=True)
    f = np.array([most if f is None else f for f, most in pairs], dtype=np.float64) / scale
    found = np.zeros(len(rows.normal), dtype=np.int64)
    _, q, _, _, L = hand.program
    return scale * gives_way(rows, q, f, L, decision.z / scale, -1.0, found)


def strong_choices(instant: Instant) -> tuple[ModeDecision, ...]:
    """Return per combination of modes that passes (5) what is best for z_strong, if proven."""
    hand, scale = StrongHand.of(instant), instant.force_scale
    best = [hand.best(0.0, mask) for mask in hand.passing()]
    limits_ = instant.max_normal_force
    return tuple(as_strong(one, 0.0, scale, limits_, 0.0) for one in best if one is not None)


def as_strong(
    best: Best | None, bound: float, scale: float, f_max: Array, below: float
) -> ModeDecision:
    """Return the decision that an answer of ``StrongHand.best`` is, in units of ``scale``.

    ``bound`` is what z_strong stays within without an answer; ``f_max`` (n,) in those units.
    """
    if best is None or best.z_strong * scale < below:
        bound = min(max(bound, 0.0) * scale, float(np.nextafter(below, -np.inf)))
        return ModeDecision(Outcome.BELOW, bound)
    held = tuple(
        ControlMode.POSITION if (best.mask >> i) & 1 else ControlMode.FORCE
        for i in range(len(f_max))
    )
    forces = tuple(
        None if mode is ControlMode.POSITION else float(x)
        for mode, x in zip(held, best.steps * f_max, strict=True)
    )
    return ModeDecision(Outcome.STABLE, best.z_strong * scale, held, forces, -1, best.z * scale)
