"""Sweeps of the cuts over places for the last finger: which of them are not refuted; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import Record, record_of
from gm_ompl.mechanics.partner_cuts import CUTS, PartnerCuts, Question, to_front


class PartnerRoom(NamedTuple):
    """Room to work in.

    Attributes:
        bases: (n + 1, K), see ``bases_without``.
        alive: (P,), placements of the last finger that are not refuted, the first ones.
        bounds: (P,), their bounds.
        blocks: (B,), likewise blocks of placements.
        block_bounds: (B,).
        scratch: (4, P).
        tips: (n, s, 6), fingers' columns.
        columns: (e + n s, 6), for Problem (5).
        record: of one proof.
    """

    bases: Array
    alive: IntArray
    bounds: Array
    blocks: IntArray
    block_bounds: Array
    scratch: Array
    tips: Array
    columns: Array
    record: Record


def room_for(ask: Question) -> PartnerRoom:
    """Return the room that a question takes."""
    n, s, e, P = len(ask.kind), ask.table.shape[2], len(ask.env), ask.allowed.shape[1]
    B = len(ask.ends) - 1
    return PartnerRoom(
        np.empty((n + 1, CUTS)), np.empty(P, np.int64), np.empty(P), np.empty(B, np.int64),
        np.empty(B), np.empty((4, P)), np.empty((n, s, 6)), np.empty((e + n * s, 6)),
        record_of(n, e + n * s),
    )  # fmt: skip


class Places(NamedTuple):
    """Places for the last finger, or blocks of them, and what cuts say of them.

    Attributes:
        last: the finger.
        held: (K, m), its T at each place.
        pressed: (K, m), its F.
        alive: the places asked for; put in another order.
        bounds: (m,), lowered.
    """

    last: int
    held: Array
    pressed: Array
    alive: IntArray
    bounds: Array


@compiled
def bases_without(
    ask: Question, rows: IntArray, last: int, cuts: PartnerCuts, bases: Array
) -> None:
    """Write what the cuts give without the last finger (n + 1, K).

    Row n: the others held; row f: the others but f held.
    """
    n = len(rows)
    for f in range(n + 1):
        bases[f] = cuts.constants
        for i in range(n):
            if i not in (f, last):
                for k in range(bases.shape[1]):
                    bases[f, k] += cuts.held[ask.kind[i], k, rows[i]]


@compiled
def sweep(
    base: Array, terms: Array, above: float, cuts: PartnerCuts, alive: IntArray, bounds: Array
) -> int:
    """Lower bounds by all cuts; return how many of those alive are not refuted: the first ones.

    Args:
        base: (K,), of all fingers but the last.
        terms: (K, m), of the last one at each place.
        above: a bound below this refutes.
        cuts: the cuts.
        alive: the places asked for; put in another order.
        bounds: (m,), lowered.
    """
    some = len(alive)
    for p in range(len(cuts.order)):
        k = cuts.order[p]
        left, here, row = 0, base[k], terms[k]
        for j in range(some):
            g = alive[j]
            bounds[g] = min(bounds[g], here + row[g])
            if bounds[g] >= above:
                alive[j], alive[left] = alive[left], g
                left += 1
        if left < some:
            to_front(cuts.order, p)
            some = left
        if some == 0:
            break
    return some


@compiled
def _sweep_with(
    ask: Question, rows: IntArray, f: int, above: float, cuts: PartnerCuts, places: Places,
    room: PartnerRoom,
) -> int:  # fmt: skip
    """Return how many places one command of finger f may satisfy: the first ones of those alive."""
    itself, alive, base = f == places.last, places.alive, room.bases[f]
    each, least, largest = room.scratch[1], room.scratch[2], room.scratch[3]
    some, terms = len(alive), places.pressed if itself else places.held
    for g in alive:
        each[g], least[g], largest[g] = np.inf, 0.0, 1.0
    for p in range(len(cuts.order)):
        k = cuts.order[p]
        left, here, row = 0, base[k], terms[k]
        slope = 0.0 if itself else cuts.pressed[ask.kind[f], k, rows[f]]
        for j in range(some):
            g = alive[j]
            a, b = (here, row[g]) if itself else (here + row[g], slope)
            each[g] = min(each[g], a + max(b, 0.0))
            if b > 0.0:
                least[g] = max(least[g], (above - a) / b)
            elif b < 0.0:
                largest[g] = min(largest[g], (above - a) / b)
            if each[g] >= above and least[g] <= largest[g] and (b != 0.0 or a >= above):
                alive[j], alive[left] = alive[left], g
                left += 1
        if left < some:
            to_front(cuts.order, p)
            some = left
        if some == 0:
            break
    return some


@compiled
def pressed_sweep(
    ask: Question, rows: IntArray, above: float, cuts: PartnerCuts, places: Places,
    room: PartnerRoom,
) -> int:  # fmt: skip
    """As ``sweep``, where some finger must be force-controlled: whichever is best.

    Args:
        ask: the question.
        rows: the placements of all fingers but the last.
        above: a bound below this refutes.
        cuts: the cuts.
        places: the places asked for.
        room: with what the cuts give without the last finger.
    """
    most, each = room.scratch[0], room.scratch[1]
    alive, bounds = places.alive, places.bounds
    for g in alive:
        most[g] = -np.inf
    for f in range(len(rows)):
        some = _sweep_with(ask, rows, f, above, cuts, places, room)
        for g in alive[:some]:
            most[g] = max(most[g], each[g])
    left = 0
    for j in range(len(alive)):
        g = alive[j]
        bounds[g] = min(bounds[g], most[g])
        if bounds[g] >= above:
            alive[j], alive[left] = alive[left], g
            left += 1
    return left
