"""From one hand to another while the object goes its way: regrasps anywhere along it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Protocol, TypeAlias, final

from gm_ompl.problem import Move, Placements, Regrasp
from gm_ompl.sampling.stages import changed

Moves: TypeAlias = tuple[Move, ...]


class Passage(Protocol):
    """The object's way as arcs that follow one another; between them it may rest.

    Point k is where arc k begins and arc k - 1 ends.
    """

    @property
    def arcs(self) -> int:
        """How many arcs there are; the last point has this number."""

    def carried(self, arc: int, placements: Placements) -> Moves | None:
        """Return the moves along an arc with these placements, or None where they fail."""

    def rests(self, point: int, placements: Placements, finger: int) -> bool:
        """Whether the object rests at a point while ``finger`` is lifted; asked first: cheap."""

    def regrasped(
        self, point: int, placements: Placements, finger: int, target: int
    ) -> Regrasp | None:
        """Return the regrasp of ``finger`` to ``target`` at a point, or None if it fails."""


def regrasping(passage: Passage, before: Placements, wanted: Placements) -> Moves | None:
    """Return the moves along a whole passage from placements ``before`` to ``wanted``.

    Each finger that is elsewhere in ``wanted`` is regrasped once, one after the other, each at a
    point where the fingers that stay hold the object. Regrasps come as early as they can.

    Args:
        passage: the object's way.
        before: per finger, at the first point.
        wanted: per finger, at the last point.

    Returns:
        The moves, or None where no order and no points will do.
    """
    return _Backwards(passage, before, wanted).moves()


@final
class _Backwards:
    """A search from the last point back to the first.

    Its states are (point, placements). It goes back as far as the last placements hold before it
    tries to regrasp; where more than one finger changes, those in between are held no longer than
    they must. It never takes the first ones where they do not hold from the first point.
    """

    def __init__(self, passage: Passage, before: Placements, wanted: Placements) -> None:
        self._passage, self._before, self._wanted = passage, before, wanted
        self._far = 0

    def moves(self) -> Moves | None:
        """Return the moves from the first point to the last."""
        if not self._may_leave():
            return None
        last = (self._passage.arcs, self._wanted)
        onwards: dict[tuple[int, Placements], Moves] = {last: ()}
        waiting = [(last, step) for step in self._steps(*last)]
        if self._wanted == self._before:
            return self._start_to(self._passage.arcs) if self._reaches(self._passage.arcs) else None
        while waiting:
            (point, hand), (earlier, other) = waiting.pop()
            if (earlier, other) in onwards:
                continue
            if not (self._rests(earlier, other, hand) and self._hopeful(earlier, other)):
                continue
            moves = self._step(earlier, other, point, hand)
            if moves is None:
                continue
            onwards[earlier, other] = whole = (*moves, *onwards[point, hand])
            if other == self._before:
                return (*self._start_to(earlier), *whole)
            here = (earlier, other)
            waiting += [(here, step) for step in self._steps(*here)]
        return None

    def _may_leave(self) -> bool:
        """Whether some finger can be lifted off the first hand where that holds."""
        fingers = changed(self._before, self._wanted)
        points = range(self._passage.arcs + 1)
        return not fingers or any(
            self._passage.rests(point, self._before, finger)
            for point in itertools.takewhile(self._reaches, points)
            for finger in fingers
        )

    def _rests(self, point: int, hand: Placements, target: Placements) -> bool:
        """Whether the fingers that ``hand`` and ``target`` share hold the object at rest."""
        lifted = changed(hand, target)
        return not lifted or self._passage.rests(point, hand, lifted[0])

    def _hopeful(self, point: int, hand: Placements) -> bool:
        """Whether the first hand may lead to ``hand`` at ``point``.

        One regrasp from the first hand, it takes over here, or it holds on the arc to here.
        """
        left = len(changed(self._before, hand))
        if left > 1 or self._reaches(point):
            return True
        arc = point - 1
        return left == 1 and arc >= 0 and self._passage.carried(arc, hand) is not None

    def _reaches(self, point: int) -> bool:
        """Whether the first hand holds from the first point to this one."""
        while self._far < point and self._passage.carried(self._far, self._before) is not None:
            self._far += 1
        return self._far >= point

    def _start_to(self, point: int) -> Moves:
        arcs = (self._passage.carried(arc, self._before) for arc in range(point))
        return tuple(move for arc in arcs for move in arc or ())

    def _steps(self, point: int, hand: Placements) -> Iterator[tuple[int, Placements]]:
        """Yield what may come just before, the best last."""
        arc = [(point - 1, hand)] if point else []
        if hand != self._wanted:
            yield from arc
        for finger in reversed(changed(self._before, hand)):
            yield point, (*hand[:finger], self._before[finger], *hand[finger + 1 :])
        if hand == self._wanted:
            yield from arc

    def _step(self, point: int, hand: Placements, then: int, target: Placements) -> Moves | None:
        """Return the moves of one step, forwards."""
        if then > point:
            return self._passage.carried(point, hand)
        finger = changed(hand, target)[0]
        regrasp = self._passage.regrasped(point, hand, finger, target[finger])
        return None if regrasp is None else (regrasp,)
