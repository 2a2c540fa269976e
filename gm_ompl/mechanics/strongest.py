"""Modes and commands that are best for z_strong, by trial.

z_strong is neither concave in f_com nor ordered by modes: a commanded force keeps a contact shut
where a position-controlled finger may let go. So every combination of modes that passes Problem
(5) is tried, with all commands of force-controlled fingers that are multiples of f_max /
``COMMANDS``. Ways of giving way that have ruled out some commands are tried on the next ones first.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import ContactState, Instant
from gm_ompl.mechanics import columns, modes
from gm_ompl.mechanics.alternatives import commanded_margin
from gm_ompl.mechanics.deviations import UNTOLD, ContactRows
from gm_ompl.mechanics.instant import DIRECTIONS, instant_columns
from gm_ompl.mechanics.stability import REACHED
from gm_ompl.mechanics.strong import gives_way, least_for

COMMANDS: Final = 8
"""Steps of a commanded force from 0 to f_max."""

BETTER: Final = 1e-7
"""By how much, relatively, later modes and commands must be better."""

KEPT: Final = 6
"""Ways of giving way that are tried first."""

PLAIN: Final = 1e-12
"""Friction up to this is none."""


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


@final
class StrongHand:
    """A hand at an instant whose modes and commands are chosen for z_strong.

    Args:
        around: the environment's contacts.
        env: (e, 6), its columns, of unit length.
        q: (6,), the load over force_scale, as all forces here.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,).
        friction: (n,), of the fingers.

    Attributes:
        lost: whether something that matters could not be proven.
    """

    def __init__(
        self, around: EnvironmentRows, env: Array, q: Array, tips: Array, f_max: Array,
        friction: Array,
    ) -> None:  # fmt: skip
        self._around, self._env, self._q, self._tips = around, env, q, tips
        self._f_max, self._friction = f_max, friction
        self.lost = False

    @classmethod
    def of(cls, instant: Instant) -> StrongHand:
        """Return the hand of an instant with point fingertips in a certain world."""
        env, q, tips, f_max = instant_columns(instant)
        U = columns.wrench_norm(instant.mass, instant.inertia)
        friction = np.asarray(instant.friction_at_contacts, dtype=np.float64)
        around = environment_rows(instant.contacts, friction, env, U)
        return cls(around, env, q, tips, f_max, np.asarray(instant.friction, dtype=np.float64))

    def held(self, mask: int, f: Array, z: float, enough: float = -1.0) -> tuple[float, IntArray]:
        """Return z_strong of modes and commands f (n,), and what contacts do there.

        ``z`` is that of Problem (6); up to ``enough``, z_strong need not be known any better.
        """
        force = self._force(mask)
        rows = together(self._around, self._tips, self._friction, force)
        found = np.full(len(rows.normal), UNTOLD)
        limits_ = np.where(force, f, self._f_max)
        t = gives_way(rows, len(f), self._q, limits_, DIRECTIONS, z, enough, found)
        return t, found

    def best(self, below: float) -> tuple[float, float, int, Array] | None:
        """Return the largest z_strong, z, mask of modes and commands (n,) that have it.

        None where z_strong stays below ``below``, or no modes pass Problem (5).
        """
        best, enough = None, np.nextafter(below, -np.inf)
        for mask in self._passing():
            trial = _Trial(self, mask)
            for f in self._commands(mask):
                limits.check()
                found = trial.beyond(f, enough)
                if found is not None:
                    best = (*found, mask, f)
                    enough = found[0] * (1.0 + BETTER)
        return best

    def _passing(self) -> list[int]:
        """Return the combinations of modes that pass Problem (5), most position control first."""
        n = len(self._tips)
        largest = np.empty(1 << n, dtype=np.int64)
        count, _ = modes.passing_sets(self._env, self._tips, -1, False, largest, np.zeros(6))
        self.lost = self.lost or count < 0
        return [
            mask
            for mask in modes.preference(n, -1).tolist()
            if any(mask & whole == mask for whole in largest[: max(count, 0)].tolist())
        ]

    def _commands(self, mask: int) -> Iterator[Array]:
        """Yield commands (n,), large ones first; 0 stands for position control."""
        steps = np.arange(COMMANDS, -1, -1) / COMMANDS
        force = self._force(mask)
        for chosen in itertools.product(*(steps if f else (0.0,) for f in force)):
            yield np.array(chosen) * self._f_max

    def _force(self, mask: int) -> BoolArray:
        n = len(self._tips)
        return np.array([not (mask >> i) & 1 for i in range(n)], dtype=np.bool_)


@final
class _Trial:
    """Tries one combination of modes."""

    def __init__(self, hand: StrongHand, mask: int) -> None:
        self._hand, self._mask, self._force = hand, mask, hand._force(mask)
        self._rows = together(hand._around, hand._tips, hand._friction, self._force)
        self._killers: list[IntArray] = []
        self._cuts: list[tuple[float, Array]] = []

    def beyond(self, f: Array, enough: float) -> tuple[float, float] | None:
        """Return z_strong and z with commands f (n,), None where z_strong is not above enough."""
        hand, n, own = self._hand, len(f), f[self._force]
        if any(c + float(slopes @ own) <= enough for c, slopes in self._cuts):
            return None
        limits_ = np.where(self._force, f, hand._f_max)
        for ways in self._killers:
            t = least_for(self._rows, n, hand._q, limits_, DIRECTIONS, ways, np.inf)
            if t <= enough:
                return None
        slopes = np.zeros(len(own))
        end, z, c = commanded_margin(
            hand._env, hand._q, hand._tips, hand._f_max, self._force, f, slopes
        )
        if end != REACHED:
            hand.lost = True
            return None
        self._cuts.append((c, slopes))
        if z <= enough:
            return None
        found = np.full(len(self._rows.normal), UNTOLD)
        t = gives_way(self._rows, n, hand._q, limits_, DIRECTIONS, z, enough, found)
        if found[0] != UNTOLD:
            self._killers = [found, *self._killers][:KEPT]
        return (t, z) if t > enough else None


def strongest(instant: Instant, below: float = 0.0) -> ModeDecision:
    """Return the decision at an instant whose z_strong is largest.

    Where none reaches ``below`` it is BELOW.
    """
    scale = instant.force_scale
    return as_strong(StrongHand.of(instant).best(below / scale), scale, below)


def as_strong(
    best: tuple[float, float, int, Array] | None, scale: float, below: float
) -> ModeDecision:
    """Return the decision that an answer of ``StrongHand.best`` is, in units of ``scale``."""
    if best is None or best[0] * scale < below:
        return ModeDecision(Outcome.BELOW, float(np.nextafter(below, -np.inf)))
    t, z, mask, f = best
    held = tuple(
        ControlMode.POSITION if (mask >> i) & 1 else ControlMode.FORCE for i in range(len(f))
    )
    forces = tuple(
        None if mode is ControlMode.POSITION else float(x) * scale
        for mode, x in zip(held, f, strict=True)
    )
    return ModeDecision(Outcome.STABLE, t * scale, held, forces, -1, z * scale)


def contact_rows(instant: Instant, position: tuple[bool, ...]) -> tuple[ContactRows, Array]:
    h = StrongHand.of(instant)
    return together(h._around, h._tips, h._friction, ~np.array(position, dtype=bool)), h._q
