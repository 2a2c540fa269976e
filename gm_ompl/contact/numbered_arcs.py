"""The arcs of the contact lattice, by numbers, as compiled code reads them."""

from __future__ import annotations

from typing import Any, Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray, with_room
from gm_ompl.contact.departures import Departures

COUNTED: Final = 1e-9
"""A number of segments that is whole up to this is that number."""


class ArcRows(NamedTuple):
    """Arcs.

    Attributes:
        tails: (A,), the nodes they leave.
        heads: (A,), the nodes they lead to.
        forms: (A,), equal where fingertips go equally far.
        kinds: (A,), equal for arcs that are the same but for where on the floor they begin.
        alone: (A,), whether an obstacle may be in reach: then its kind is its own.
        bare: (A,), whether the object is known to touch nothing in the middle of some segment.
        turns: (A,), which are rotations.
        short: (A,), which are no whole step.
        by: (A, 3), whole translations; of a rotation, a point of its line, world frame.
        axes: (A, 3), unit, of lines.
        angles: (A,), whole rotations [rad]; 0 of a translation.
        parts: (A,), in how many segments each is judged.
        pitches: (A,), how long a segment is, as a share of the arc; the last may be shorter.
    """

    tails: IntArray
    heads: IntArray
    forms: IntArray
    kinds: IntArray
    alone: BoolArray
    bare: BoolArray
    turns: BoolArray
    short: BoolArray
    by: Array
    axes: Array
    angles: Array
    parts: IntArray
    pitches: Array


@final
class NumberedArcs:
    """Arcs, and the forms and kinds of those that are alike.

    Args:
        parts: segments per step.
        fewest: segments per arc at least.
        inside: whether arcs are judged inside their segments, and not at their ends.

    Attributes:
        rows: the arcs, with room for more.
        form_arcs: of each form the first arc.
        kind_arcs: of each kind the first arc.
    """

    def __init__(self, parts: int, fewest: int, *, inside: bool) -> None:
        self._parts, self._fewest, self._inside, self._count = parts, fewest, inside, 0
        flags, numbers, reals = np.zeros((4, 0), bool), np.zeros((5, 0), np.int64), np.zeros((2, 0))
        way = np.zeros((0, 3))
        self.rows = ArcRows._make([*numbers[:4], *flags, way, way, reals[0], numbers[4], reals[1]])
        self._forms, self._kinds = dict[bytes, int](), dict[bytes, int]()
        self.form_arcs, self.kind_arcs = list[int](), list[int]()

    def __len__(self) -> int:
        return self._count

    def add(
        self, tails: IntArray, heads: IntArray, rows: IntArray, found: Departures,
        alone: BoolArray, stands: IntArray,
    ) -> None:  # fmt: skip
        """Add arcs.

        Args:
            tails: (A,), the nodes they leave.
            heads: (A,), the nodes they lead to.
            rows: (A,), of the motions that they are.
            found: motions.
            alone: (A,), whether an obstacle may be in reach where they begin.
            stands: (A, 2), equal where the object stands alike on the floor where they begin.
        """
        before = len(self.form_arcs), len(self.kind_arcs)
        try:
            self._append(self._rows(tails, heads, rows, found, alone, stands))
        except BaseException:  # Ctrl-C: no form and no kind may be that of an arc to come
            self._forget(*before)
            raise

    def _rows(
        self, tails: IntArray, heads: IntArray, rows: IntArray, found: Departures,
        alone: BoolArray, stands: IntArray,
    ) -> ArcRows:  # fmt: skip
        forms = self._formed(found.forms[rows])
        kinds = self._kinded(np.column_stack([stands, forms, found.ahead[rows]]), alone)
        steps, bare = found.steps[rows], found.bare[rows] & self._inside
        short = steps < 1.0 - COUNTED
        parts = np.ceil(self._parts * steps - COUNTED).astype(np.int64)
        parts = np.where(short, np.maximum(self._fewest, parts), self._parts)
        pitches = np.where(short, 1.0 / (self._parts * steps), 1.0 / self._parts)
        turns, angles = found.turns[rows], np.where(found.turns[rows], found.angles[rows], 0.0)
        return ArcRows(
            tails, heads, forms, kinds, alone, bare, turns, short, found.by[rows],
            found.axes[rows], angles, parts, pitches,
        )  # fmt: skip

    def _forget(self, forms: int, kinds: int) -> None:
        """Forget all forms and kinds but the first."""
        del self.form_arcs[forms:], self.kind_arcs[kinds:]
        self._forms = {key: form for key, form in self._forms.items() if form < forms}
        self._kinds = {key: kind for key, kind in self._kinds.items() if kind < kinds}

    def _append(self, new: ArcRows) -> None:
        count, grown = self._count + len(new.heads), list[Any]()
        for old, more in zip(self.rows, new, strict=True):
            column = with_room(old, self._count, count)
            column[self._count : count] = more
            grown.append(column)
        self.rows, self._count = ArcRows._make(grown), count

    def _formed(self, numbers: IntArray) -> IntArray:
        known, firsts, forms = self._forms, self.form_arcs, np.empty(len(numbers), np.int64)
        for k, arc in enumerate(range(self._count, self._count + len(numbers))):
            form = known.setdefault(numbers[k].tobytes(), len(known))
            if form == len(firsts):
                firsts.append(arc)
            forms[k] = form
        return forms

    def _kinded(self, numbers: IntArray, alone: BoolArray) -> IntArray:
        known, firsts, kinds = self._kinds, self.kind_arcs, np.empty(len(numbers), np.int64)
        for k, own in enumerate(alone.tolist()):
            kind = len(firsts)
            if not own:
                kind = known.setdefault(numbers[k].tobytes(), kind)
            if kind == len(firsts):
                firsts.append(self._count + k)
            kinds[k] = kind
        return kinds
