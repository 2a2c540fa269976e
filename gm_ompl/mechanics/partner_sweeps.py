"""Sweeps of the cuts over places for the last finger: which of them are not refuted; compiled."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.partner_cuts import PartnerCuts, Question, to_front


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
    ask: Question, rows: IntArray, f: int, above: float, base: Array, cuts: PartnerCuts,
    terms: Array, last: bool, alive: IntArray, scratch: Array,
) -> int:  # fmt: skip
    """Return how many places one command of finger f may satisfy: the first ones of those alive."""
    some, (_, each, least, largest) = len(alive), scratch
    for g in alive:
        each[g], least[g], largest[g] = np.inf, 0.0, 1.0
    for p in range(len(cuts.order)):
        k = cuts.order[p]
        left, here, row = 0, base[k], terms[k]
        slope = 0.0 if last else cuts.pressed[ask.kind[f], k, rows[f]]
        for j in range(some):
            g = alive[j]
            a, b = (here, row[g]) if last else (here + row[g], slope)
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
    ask: Question, rows: IntArray, last: int, bases: Array, above: float, cuts: PartnerCuts,
    terms: tuple[Array, Array], alive: IntArray, bounds: Array, scratch: Array,
) -> int:  # fmt: skip
    """As ``sweep``, where some finger must be force-controlled: whichever is best.

    Args:
        ask: the question.
        rows: the placements of all fingers but the last.
        last: the last finger.
        bases: see ``bases_without``.
        above: a bound below this refutes.
        cuts: the cuts.
        terms: (K, m) each, T and F of the last finger at each place.
        alive: the places asked for; put in another order.
        bounds: (m,), lowered.
        scratch: (4, m), written to.
    """
    most, each = scratch[0], scratch[1]
    for g in alive:
        most[g] = -np.inf
    for f in range(len(rows)):
        row = terms[1] if f == last else terms[0]
        some = _sweep_with(ask, rows, f, above, bases[f], cuts, row, f == last, alive, scratch)
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
