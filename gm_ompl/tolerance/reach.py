"""How far one quantity may go at one site: the largest interval that is proven to hold."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Protocol, TypeAlias, TypeVar

import numpy as np

from gm_ompl.tolerance.forces import Held, held, wider
from gm_ompl.tolerance.quantities import Coordinate, Entrance
from gm_ompl.tolerance.sites import Site
from gm_ompl.tolerance.squeezing import Squeeze, clear_between, squeeze

CLOSE: Final = 0.004
"""The search for an end stops where what holds and what does not are so close, relatively."""

SMALLEST: Final = 1e-7
"""Ends are told apart from 0 from this part of what is looked at on."""


class Look(Protocol):
    """What is found where one has looked."""

    @property
    def x(self) -> float:
        """Where."""

    @property
    def holds(self) -> bool:
        """Whether modes and commands hold there."""

    @property
    def slack(self) -> float:
        """By how much z is large enough; -inf where it does not hold for another reason."""


L = TypeVar("L", bound=Look)


class Looks(Protocol[L]):
    """Something to look along, from 0 on."""

    def at(self, x: float) -> L:
        """Look at ``x``."""

    def certain(self, one: L, other: L) -> bool:
        """Whether it is proven to hold at every value between two at which it holds."""


@dataclass(frozen=True, eq=False)
class Spot:
    """One value of a quantity at a site, and whether modes and commands hold there."""

    x: float
    held: Held
    squeeze: Squeeze | None

    @property
    def holds(self) -> bool:
        """Whether z is large enough and Problem (5) passes."""
        return self.held.slack >= 0.0 and not (self.squeeze is not None and self.squeeze.excessive)

    @property
    def slack(self) -> float:
        """By how much z is large enough; -inf where that says nothing of why it does not hold."""
        return self.held.slack if self.holds or self.held.slack < 0.0 else -math.inf


Trail: TypeAlias = dict[str, list[Spot]]
"""By quantity, what was looked at last: its bases are tried first at the next site."""


class Deviations:
    """A quantity at a site, the values looked at kept.

    Args:
        site: where.
        quantity: what is off.
        nominal: the site with nothing off.
        trail: what the sites before left, and this one leaves.
    """

    def __init__(self, site: Site, quantity: Coordinate, nominal: Held, trail: Trail) -> None:
        self._site, self._quantity = site, quantity
        self._entrance = quantity.entrance(site)
        self._nominal, self._spots = nominal, dict[float, Spot]()
        self._before = trail.get(quantity.label, [])
        self._spots[0.0] = self._spot(0.0, nominal)
        self._left = trail[quantity.label] = [self._spots[0.0]]

    def at(self, x: float) -> Spot:
        """Return whether it holds with the quantity off by ``x``."""
        if x not in self._spots:
            solved = [s for s in (*self._left, *self._before) if s.held.found is not None]
            nearest = min(solved, key=lambda spot: abs(spot.x - x), default=None)
            world = self._quantity.world(x).of(self._site.fingers)
            # Where cones only grow, z cannot fall: the nominal one speaks for it.
            nested = self._entrance is Entrance.NESTED and x > 0.0
            last = None if nearest is None else nearest.held
            site, even = self._site, self._entrance is Entrance.COLUMNS
            found = (
                wider(self._nominal, site, world) if nested else held(site, world, last, even=even)
            )
            self._spots[x] = self._spot(x, found)
            self._left.append(self._spots[x])
        return self._spots[x]

    def _spot(self, x: float, found: Held) -> Spot:
        nested = self._entrance is Entrance.NESTED and x > 0.0
        squeezes = nested or self._entrance is Entrance.COLUMNS
        return Spot(x, found, squeeze(self._site, found.model, found.columns) if squeezes else None)

    def certain(self, one: Spot, other: Spot) -> bool:
        """Whether it is proven to hold at every value between two at which it holds."""
        if self._entrance in (Entrance.LOAD, Entrance.NESTED):
            return True
        if self._entrance is Entrance.TURNS:
            instant = self._site.instant
            weight = instant.mass * instant.gravity / one.held.model.scale
            return _covered(one, other, weight * (other.x - one.x) ** 2 / 2.0)
        assert one.squeeze is not None and other.squeeze is not None
        return _covered(one, other, unresisted(one.held, other.held)) and clear_between(
            one.squeeze, other.squeeze
        )


def unresisted(one: Held, other: Held) -> float:
    """Return E: forces between two worlds leave at most t (1 - t) E, in the norm (7), over.

    Between worlds whose columns differ by dA, forces that run straight from those of the one to
    those of the other, differing by dk, leave t (1 - t) dA dk.
    """
    if not len(one.forces) or not len(other.forces):
        return math.inf
    rest = (other.forces - one.forces) @ (other.columns - one.columns).T
    return float(np.linalg.norm(rest, axis=1).max())


def _covered(one: Spot, other: Spot, E: float) -> bool:
    """Whether slacks at both ends make up for t (1 - t) E everywhere between."""
    return (math.sqrt(one.slack) + math.sqrt(other.slack)) ** 2 >= E


def reach(line: Looks[L], most: float, close: float = CLOSE) -> tuple[L, L | None]:
    """Return how far one may go from 0 towards ``most``, of either sign: what holds, what fails.

    Proven pieces are laid end to end; where a value fails, the search goes on between it and the
    last proven one. None fails where ``most`` is reached, or where it is the proof that ends.
    """
    last, ahead = line.at(0.0), list[L]()
    if not last.holds:
        return last, last
    fails: L | None = None
    smallest, halve = SMALLEST * abs(most), False
    ahead, fails = _sorted(line.at(most), ahead, fails)
    while ahead or fails is not None:
        if not ahead:
            assert fails is not None
            width = close * abs(fails.x)
            if abs(fails.x - last.x) <= max(width, smallest):
                break
            x = _between(last, fails, width, halve)
            ahead, fails = _sorted(line.at(x), ahead, fails)
            halve = not halve
        elif line.certain(last, ahead[0]):
            last = ahead.pop(0)
        elif abs(ahead[0].x - last.x) <= max(close / 4.0 * abs(ahead[0].x), smallest):
            break
        else:
            ahead, fails = _sorted(line.at((last.x + ahead[0].x) / 2.0), ahead, fails)
    return last, fails


def _sorted(spot: L, ahead: list[L], fails: L | None) -> tuple[list[L], L | None]:
    """Return what holds ahead and what fails first, a nearer spot taken in."""
    return ([spot, *ahead], fails) if spot.holds else ([], spot)


def _between(last: Look, fails: Look, width: float, halve: bool) -> float:
    """Return where to look next: where z should just suffice, now and then half way."""
    way, share = fails.x - last.x, 0.5
    if not halve and math.isfinite(fails.slack) and last.slack > fails.slack:
        share = last.slack / (last.slack - fails.slack)
    off = min(width / 2.0 / abs(way), 0.5)
    return last.x + way * min(max(share, off), 1.0 - off)
