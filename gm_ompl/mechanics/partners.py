"""The largest z of a finger's every placement, over all placements of the others; compiled."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.certificate import Record
from gm_ompl.mechanics.internal_force import FAILS, separate
from gm_ompl.mechanics.modes import STABLE, UNDER, UNPROVEN, decide, unit_columns
from gm_ompl.mechanics.partner_cuts import (
    LOST,
    Found,
    PartnerCuts,
    Question,
    keep,
    refuting,
    threshold,
)
from gm_ompl.mechanics.partner_survivors import clear, lowered, survivors
from gm_ompl.mechanics.partner_sweeps import PartnerRoom, Places, bases_without, pressed_sweep
from gm_ompl.mechanics.program import Touch


@compiled
def _may_hold_all(ask: Question, rows: IntArray, room: PartnerRoom) -> bool:
    """Whether Problem (5) is not proven to forbid position control of all fingers."""
    for i in range(len(rows)):
        room.tips[i] = ask.table[i, rows[i]]
    everyone, columns = (1 << len(rows)) - 1, room.columns
    end, _ = separate(columns, unit_columns(ask.env, room.tips, everyone, columns), np.empty(6))
    return end != FAILS


@compiled
def note(kind: IntArray, rows: IntArray, z: float, found: Found) -> None:
    """Take a set's margin into account, for all fingers that are alike."""
    for i in range(len(rows)):
        for j in range(len(rows)):
            if kind[i] == kind[j] and z > found.z[j, rows[i]]:
                found.z[j, rows[i]] = z
                there = found.sets[j, rows[i]]
                there[:] = rows
                there[i], there[j] = rows[j], rows[i]


@compiled
def _may_be_better(
    ask: Question, rows: IntArray, best: float, cuts: PartnerCuts, bases: Array
) -> bool:
    """Whether fingertips leave each other room and no cut refutes the set."""
    last, bound = len(rows) - 1, np.inf
    for j in range(len(rows)):
        if not clear(ask, rows, j):
            return False
    bases_without(ask, rows, last, cuts, bases)
    for k in range(bases.shape[1]):
        bound = min(bound, bases[-1, k] + cuts.held[ask.kind[last], k, rows[last]])
    return bound >= refuting(best)


@inlined
def _decided(
    ask: Question, rows: IntArray, best: float, cuts: PartnerCuts, found: Found, record: Record
) -> float:
    """Decide a set; return the best margin so far."""
    n = len(rows)
    f_com, y, everyone = np.empty(n), np.zeros(6), (1 << n) - 1
    record.sets[:] = -1
    touch = Touch(ask.env, ask.q, ask.table, ask.f_max, ask.L, np.arange(n), rows)
    end, z, _, mask = decide(touch, threshold(best), -1, -1, record, f_com, y)
    found.counts[0] += 1
    if end == UNPROVEN:
        if found.counts[1] < LOST:
            found.lost[found.counts[1]] = rows
        found.counts[1] += 1
    if end == STABLE:
        note(ask.kind, rows, z, found)
    if mask == everyone or end not in (STABLE, UNDER):
        keep(ask, y, cuts)
    else:
        for j in range(len(record.sets)):
            ones = 0
            for i in range(n):
                ones += (record.sets[j] >> i) & 1 if record.sets[j] >= 0 else 0
            if record.sets[j] >= 0 and ones == n - 1:
                for k in range(len(record.wrenches[j])):  # zero stands for none
                    keep(ask, record.wrenches[j, k], cuts)
    return max(best, z) if end == STABLE else best


@inlined
def _best_last(
    ask: Question, i: int, rows: IntArray, best: float, cuts: PartnerCuts, found: Found,
    room: PartnerRoom,
) -> float:  # fmt: skip
    """Return the best margin with the last finger beside ``i`` anywhere that is not yet tried."""
    last = _last(len(rows), i)
    one, m, first = np.empty(1, np.int64), ask.kind[last], _first_row(ask, rows, i, last)
    some = survivors(ask, rows, last, first, best, cuts, room)
    while some > 0:
        top = 0
        for j in range(some):
            if room.bounds[room.alive[j]] > room.bounds[room.alive[top]]:
                top = j
        some -= 1
        g = room.alive[top]
        room.alive[top] = room.alive[some]
        rows[last], one[0] = g, g
        # What is not refuted where somebody must be force-controlled needs no question.
        here = Places(last, cuts.held[m], cuts.pressed[m], one, room.bounds)
        refuted = best >= 0.0 and (pressed_sweep(ask, rows, refuting(best), cuts, here, room) == 0)
        if not refuted or _may_hold_all(ask, rows, room):
            best = _decided(ask, rows, best, cuts, found, room.record)
            bases_without(ask, rows, last, cuts, room.bases)
            some = lowered(ask, rows, last, best, cuts, room, some)
    return best


@compiled
def best_of(
    ask: Question,
    i: int,
    g: int,
    hints: IntArray,
    cuts: PartnerCuts,
    found: Found,
    room: PartnerRoom,
) -> None:
    """Find the best margin with finger ``i`` at ``g``, over all placements of the others.

    Args:
        ask: the question.
        i: the finger.
        g: its placement, where it is allowed.
        hints: (h, n), sets of placements nearby to begin with, or -1.
        cuts: the cuts; they grow.
        found: output.
        room: room to work in.
    """
    n = len(ask.kind)
    rows, best = np.full(n, -1, dtype=np.int64), found.z[i, g]
    rows[i] = g
    if n == 1:
        _decided(ask, rows, best, cuts, found, room.record)
        return
    for hint in hints:
        for j in range(n):
            rows[j] = g if j == i else hint[j]
        if hint[0] >= 0 and _may_be_better(ask, rows, best, cuts, room.bases):
            best = _decided(ask, rows, best, cuts, found, room.record)
        rows[:] = -1
        rows[i] = g
    if n == 2:
        _best_last(ask, i, rows, best, cuts, found, room)
    else:
        _middle(ask, i, rows, best, cuts, found, room)


@compiled
def _last(n: int, i: int) -> int:
    """Return the finger that is placed last where finger i of n is placed first."""
    return n - 1 if i < n - 1 else n - 2


@compiled
def _next_row(ask: Question, rows: IntArray, i: int, j: int) -> int:
    """Return the next row of finger j that fits those placed before it; P for none."""
    g, P = rows[j] + 1, ask.allowed.shape[1]
    if rows[j] < 0:
        g = _first_row(ask, rows, i, j)
    while g < P:
        rows[j] = g
        if ask.allowed[j, g] and clear(ask, rows, j):
            return g
        g += 1
    return P


@compiled
def _first_row(ask: Question, rows: IntArray, i: int, j: int) -> int:
    """Return where finger j begins: like fingers, the first aside, stand in increasing order."""
    first = 0
    for k in range(j):
        if k != i and ask.kind[k] == ask.kind[j]:
            first = max(first, rows[k] + 1)
    return first


@compiled
def _bound_of_some(ask: Question, rows: IntArray, cuts: PartnerCuts, peaks: Array) -> float:
    """Return a bound on z with some fingers placed, the others anywhere."""
    bound = np.inf
    for k in range(len(cuts.constants)):
        here = cuts.constants[k]
        for f in range(len(rows)):
            m = ask.kind[f]
            here += peaks[m, k] if rows[f] < 0 else cuts.held[m, k, rows[f]]
        bound = min(bound, here)
    return bound


@compiled
def _peaks(cuts: PartnerCuts) -> Array:
    """Return (m, K), each cut's largest T of each kind of finger."""
    kinds, K, _ = cuts.held_most.shape
    peaks = np.zeros((kinds, K))
    for m in range(kinds):
        for k in range(K):
            peaks[m, k] = cuts.held_most[m, k].max()
    return peaks


@inlined
def _middle(
    ask: Question, i: int, rows: IntArray, best: float, cuts: PartnerCuts, found: Found,
    room: PartnerRoom,
) -> float:  # fmt: skip
    """Place all fingers between the first and the last in every way that is not refuted."""
    last = _last(len(rows), i)
    others = np.array([j for j in range(len(rows)) if j not in (i, last)])
    level, peaks, decided = 0, _peaks(cuts), found.counts[0]
    while level >= 0:
        j = others[level]
        if _next_row(ask, rows, i, j) == ask.allowed.shape[1]:
            rows[j] = -1
            level -= 1
            continue
        if found.counts[0] > decided:  # cuts have grown
            peaks, decided = _peaks(cuts), found.counts[0]
        if _bound_of_some(ask, rows, cuts, peaks) < refuting(best):
            continue
        if level + 1 < len(others):
            level += 1
        else:
            best = _best_last(ask, i, rows, best, cuts, found, room)
            rows[last] = -1
    return best
