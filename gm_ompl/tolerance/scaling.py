"""How far all ranges may be widened together at one site: the largest common factor.

Worlds off in load and commands alone hold where those at the corners of the ranges do (z is
concave in both); friction cones that only grow are worst at one end; sliding friction and shifted
fingertips change columns, and forces mixed from those at the corners leave a rest that is known.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Final, TypeAlias

import numpy as np

from gm_ompl.problem import Problem
from gm_ompl.reference.cases import is_mean
from gm_ompl.reference.internal_force import excessive_internal_force
from gm_ompl.tolerance.forces import Held, held, mechanics
from gm_ompl.tolerance.mixing import covered
from gm_ompl.tolerance.sites import Site
from gm_ompl.tolerance.squeezing import clear, pressing
from gm_ompl.uncertainty.ranges import Uncertainty
from gm_ompl.uncertainty.worlds import World, corners

WIDEST: Final = 10.0
"""Factors are looked at up to here."""

Flip: TypeAlias = tuple[str, int]
"""A field of ``World`` by which columns change, and the place in it."""


@dataclass(frozen=True, eq=False)
class Box:
    """All worlds of the ranges times a factor, at a site.

    Attributes:
        x: the factor.
        slack: by how much z is large enough in the worst case; -inf where that is not it.
        holds: whether modes and commands are proven to hold in all of them.
        world: one in which they do not; None where none is known.
    """

    x: float
    slack: float
    holds: bool
    world: World | None = None


class Boxes:
    """The ranges at a site, by their factor.

    Args:
        site: where.
        ranges: those of all fingers.
        nominal: the site with nothing off.
        trail: by number of the case, what was found last, perhaps at another site.
    """

    def __init__(
        self, site: Site, ranges: Uncertainty, nominal: Held, trail: dict[int, Held]
    ) -> None:
        self._site, self._ranges = site, ranges.of(site.fingers)
        contacts = site.instant.contacts
        self._slides = sorted(set(contacts.surfaces[contacts.slip.any(axis=1)].tolist()))
        self._trail, self._nominal = trail, nominal
        self._boxes: dict[float, Box] = {}
        self._worst = 0

    def at(self, x: float) -> Box:
        """Return what holds in all worlds of the ranges times ``x``."""
        if x not in self._boxes:
            self._boxes[x] = self._box(x)
        return self._boxes[x]

    def certain(self, one: Box, other: Box) -> bool:
        """Wider ranges hold the narrower ones."""
        return one.holds and other.holds

    def _box(self, x: float) -> Box:
        scaled = self._ranges.scaled(x)
        squeezes, world = self._squeezed(scaled)
        if squeezes:
            return Box(x, -math.inf, False, world)
        flips, cases = self._flips(scaled), self._cases(scaled)
        needed = self._needed(cases, bool(flips))
        found: dict[World, Held] = {}
        for k in sorted(needed, key=lambda k: k != self._worst):
            last = self._trail.get(k, self._nominal)
            here = held(self._site, cases[k], last, even=bool(flips))
            found[cases[k]] = self._trail[k] = here
            if here.slack < 0.0:
                self._worst = k
                return Box(x, here.slack, False, cases[k])
        slack = [found[cases[k]].slack for k in needed]
        self._worst = needed[int(np.argmin(slack))]
        holds = self._covered(dict(found), flips)
        if not holds:  # bounds on z are too little: it is needed as it is
            exact = {w: held(self._site, w, h, exactly=True, even=True) for w, h in found.items()}
            holds = self._covered(exact, flips)
        return Box(x, min(slack), holds)

    def _cases(self, ranges: Uncertainty) -> list[World]:
        """Return the corners of the ranges, those that make no difference here once."""
        site, slides = self._site, bool(self._slides)
        cases = (
            replace(
                world,
                sliding_friction=world.sliding_friction if slides else (),
                command=tuple(
                    e if f > 0.0 else 0.0 for e, f in zip(world.command, site.f_com, strict=False)
                ),
            )
            for world in corners(ranges, len(site.fingers), site.instant.mass)
        )
        return list(dict.fromkeys(cases))

    def _needed(self, cases: Sequence[World], mixed: bool) -> list[int]:
        """Return the numbers of the cases among which the worst is.

        A load that is a mean of others is not: z is concave in it. Nor is one that forces of the
        environment carry over into such a mean, where its columns are not ``mixed``.
        """
        kept: list[int] = []
        models = [mechanics(self._site, world)[0] for world in cases]
        forces = models[0].env_wrenches[:, : 0 if mixed else None]
        for group in _alike(cases):
            k = 0
            while k < len(group):
                others = np.array([models[j].load for j in group if j != group[k]])
                if len(others) and is_mean(models[group[k]], others, forces):
                    del group[k]
                else:
                    k += 1
            kept += group
        return kept

    def _flips(self, ranges: Uncertainty) -> list[Flip]:
        """Return by what columns change within the ranges, other than friction cones growing."""
        friction = ranges.environment_friction
        surfaces = [0] if len(friction) == 1 and self._slides else self._slides
        flips = [("sliding_friction", k) for k in surfaces if friction and friction[k] > 0.0]
        if ranges.position > 0.0:
            flips += [("position", j) for j in range(2 * len(self._site.fingers))]
        return flips

    def _covered(self, found: dict[World, Held], flips: list[Flip]) -> bool:
        """Whether slacks at the corners make up for what mixed forces leave between them."""
        while found and flips:
            first = next(iter(found))
            corner = [
                reduce(flipped, (f for f, turn in zip(flips, turns, strict=True) if turn), first)
                for turns in itertools.product((False, True), repeat=len(flips))
            ]
            if not covered([found.pop(world) for world in corner], len(flips)):
                return False
        return True

    def _squeezed(self, ranges: Uncertainty) -> tuple[bool, World | None]:
        """Return whether Problem (5) may fail within the ranges, and a world in which it does."""
        sets = []
        for world in self._slippery(ranges):
            model, columns, _ = mechanics(self._site, world)
            if excessive_internal_force(model, self._site.position).excessive:
                return True, world
            sets.append(columns[:, pressing(self._site, model)])
        together = np.hstack(sets)
        # One set was judged as it is; what lies between several must be proven.
        return len(sets) > 1 and together.shape[1] > 0 and not clear(together), None

    def _slippery(self, ranges: Uncertainty) -> Iterator[World]:
        """Yield the corners for Problem (5): static friction is the worse the more there is."""
        high, tips = ranges.environment_friction, ranges.finger_friction
        flips = self._flips(ranges)
        for signs in itertools.product((-1.0, 1.0), repeat=len(flips)):
            world = World(environment_friction=high, sliding_friction=high, finger_friction=tips)
            if ranges.position > 0.0:
                pairs = ((ranges.position, ranges.position),) * len(self._site.fingers)
                world = replace(world, position=pairs)
            for flip, sign in zip(flips, signs, strict=True):
                world = flipped(world, flip) if sign < 0.0 else world
            yield world


def _alike(cases: Sequence[World]) -> list[list[int]]:
    """Return the numbers of cases that differ in the load alone, together."""
    groups: dict[World, list[int]] = {}
    for k, world in enumerate(cases):
        bare = replace(world, mass=0.0, centre_of_mass=(0.0, 0.0, 0.0), tilt=(0.0, 0.0))
        groups.setdefault(bare, []).append(k)
    return list(groups.values())


def flipped(world: World, flip: Flip) -> World:
    """Return the world with one of its numbers of the other sign."""
    field, place = flip
    if field == "position":
        i, k = divmod(place, 2)
        pairs = [list(pair) for pair in world.position]
        pairs[i][k] = -pairs[i][k]
        return replace(world, position=tuple((u, v) for u, v in pairs))
    friction = list(world.sliding_friction)
    friction[place] = -friction[place]
    return replace(world, sliding_friction=tuple(friction))


def widest(problem: Problem, ranges: Uncertainty) -> float:
    """Return the largest factor that makes sense: no friction, mass or command below none."""
    pairs = [(problem.mass, ranges.mass), (1.0, ranges.command)]
    frictions = ranges.environment_friction
    pairs += [(problem.environment.friction, width) for width in frictions]
    pairs += list(zip(problem.fingers.friction.tolist(), ranges.finger_friction, strict=False))
    return min([WIDEST, *(nominal / width for nominal, width in pairs if width > 0.0)])
