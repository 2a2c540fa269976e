"""Links: the ramps between neighbouring commands of a plan, which are to hold.

What the kernel cannot prove, or hardly, the reference decides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError

if TYPE_CHECKING:
    from gm_ompl.mechanics.case_alternatives import Choices

DOUBT: Final = 1e-6
"""A ramp that misses equilibrium by no more, relative to what adds up to that, may hold."""


class Side(NamedTuple):
    """A junction's mechanics under one of its twists.

    Attributes:
        hand: for the kernel.
        instant: for the reference, made when it is asked.
    """

    hand: Choices
    instant: Callable[[], Instant]


@dataclass(eq=False)
class Link:
    """A junction whose commands are still to be chosen; forces in the scenario's units.

    Attributes:
        number: of the instant before it; the other is the next.
        modes: per finger that touches.
        ends: at each end of the ramp, where the commands of the force-controlled fingers stand
            among all commands f of the plan: place 0 is no force, place i + 1 is ``f[i]``.
        same: whether the modes are equal on both sides: there is no ramp where forces are, too.
        look: returns the mechanics there, under each twist; asked once, if at all.
        cuts: (c, slopes, places): the ramp holds only where c + slopes . f at the places >= 0.
    """

    number: int
    modes: tuple[ControlMode, ...]
    ends: tuple[IntArray, ...]
    same: bool
    look: Callable[[], Sequence[Side]]
    cuts: list[tuple[float, Array, IntArray]] = field(default_factory=list)
    _known: dict[tuple[int, bytes, bytes], bool] = field(default_factory=dict)

    @cached_property
    def sides(self) -> Sequence[Side]:
        """The mechanics, under each twist."""
        return self.look()

    def holds(self, f: Array) -> bool:
        """Whether the ramp holds with the commands ``f`` of the plan; learns a cut where not."""
        commands, held = np.append(0.0, f), True
        if self.same and np.array_equal(commands[self.ends[0]], commands[self.ends[-1]]):
            return True
        for k in range(len(self.sides)):
            for places in self.ends:
                held = self._once(k, places, commands[places]) and held
        return held

    def _once(self, k: int, places: IntArray, forces: Array) -> bool:
        key = k, places.tobytes(), forces.tobytes()
        if key not in self._known:
            self._known[key] = self._balanced(k, places, forces)
        return self._known[key]

    def _balanced(self, k: int, places: IntArray, forces: Array) -> bool:
        """Whether ``forces`` of the force-controlled fingers can be balanced under twist ``k``."""
        limits.check()
        found = self.sides[k].hand.balanced(self.modes, forces)
        if found is not None:
            held, c, slopes = found
            if held:
                return True
            cut, missed = (c, slopes, places), -(c + float(slopes @ forces))
            if missed > DOUBT * (abs(c) + float(np.abs(slopes) @ forces)):
                self.cuts.append(cut)
                return False
        # Imported late: it loads HiGHS, and is seldom needed.
        from gm_ompl.reference.junction import equilibrium

        left = iter(forces.tolist())
        f_com = [next(left) if mode is ControlMode.FORCE else None for mode in self.modes]
        try:
            held = equilibrium(self.sides[k].instant(), self.modes, f_com)
        except SolverError:
            held = False
        if not held and found is not None:
            self.cuts.append(cut)
        return held


def failing(links: Sequence[Link], f: Array) -> list[Link]:
    """Return the links that do not hold with the commands ``f`` of the plan."""
    return [link for link in links if not link.holds(f)]
