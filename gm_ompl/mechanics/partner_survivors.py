"""Which placements of the last finger may still be better, the other fingers placed; compiled."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.partner_cuts import PartnerCuts, Question, refuting
from gm_ompl.mechanics.partner_sweeps import (
    PartnerRoom,
    Places,
    bases_without,
    pressed_sweep,
    sweep,
)


@compiled
def clear(ask: Question, rows: IntArray, last: int) -> bool:
    """Whether the last fingertip penetrates no other that is placed."""
    clear = True
    for i in range(len(rows)):
        if i != last and rows[i] >= 0:
            square = 0.0
            for t in range(3):
                step = ask.centres[i, rows[i], t] - ask.centres[last, rows[last], t]
                square += step * step
            clear = clear and square >= ask.apart[i, last]
    return clear


@compiled
def _pinch(ask: Question, rows: IntArray, last: int) -> bool:
    """Whether the last finger and another can press on each other, along the line between them.

    That is internal force without bound: Problem (5) forbids to position-control both.
    """
    g = rows[last]
    for i in range(len(rows)):
        if i == last or rows[i] < 0:
            continue
        square, here, there = 0.0, 0.0, 0.0
        for t in range(3):
            step = ask.points[last, g, t] - ask.points[i, rows[i], t]
            square += step * step
            here -= step * ask.normals[last, g, t]
            there += step * ask.normals[i, rows[i], t]
        length = np.sqrt(square)
        if square > 0.0 and here > ask.inner[last] * length and there > ask.inner[i] * length:
            return True
    return False


@compiled
def _pinching(ask: Question, rows: IntArray, last: int, alive: IntArray) -> int:
    """Put placements of the last finger first at which it and another pinch; return how many."""
    some = 0
    for j in range(len(alive)):
        g = alive[j]
        rows[last] = g
        if _pinch(ask, rows, last):
            alive[j], alive[some] = alive[some], g
            some += 1
    return some


@compiled
def _pinching_left(
    ask: Question, rows: IntArray, above: float, cuts: PartnerCuts, places: Places,
    pinching: int, room: PartnerRoom,
) -> int:  # fmt: skip
    """Sweep the first ones of those alive, where fingers pinch; return how many are left of all."""
    last, held, pressed, alive, bounds = places
    first = Places(last, held, pressed, alive[:pinching], bounds)
    left = pressed_sweep(ask, rows, above, cuts, first, room)
    for j in range(pinching, len(alive)):
        alive[left] = alive[j]
        left += 1
    return left


@compiled
def _blocks_left(
    ask: Question, rows: IntArray, last: int, best: float, cuts: PartnerCuts, room: PartnerRoom
) -> int:
    """Return how many blocks are not refuted: the first ones of the room."""
    m, above, blocks = ask.kind[last], refuting(best), room.blocks
    blocks[:] = np.arange(len(blocks))
    room.block_bounds[:] = np.inf
    some = sweep(room.bases[-1], cuts.held_most[m], above, cuts, blocks, room.block_bounds)
    if best < 0.0:
        return some
    pinching = 0
    for j in range(some):
        b, all_do = blocks[j], True
        for g in ask.blocks[ask.ends[b] : ask.ends[b + 1]]:
            rows[last] = g
            all_do = all_do and (not ask.allowed[last, g] or _pinch(ask, rows, last))
        if all_do:
            blocks[j], blocks[pinching] = blocks[pinching], b
            pinching += 1
    places = Places(last, cuts.held_most[m], cuts.pressed_most[m], blocks[:some], room.block_bounds)
    return _pinching_left(ask, rows, above, cuts, places, pinching, room)


@compiled
def lowered(
    ask: Question, rows: IntArray, last: int, best: float, cuts: PartnerCuts, room: PartnerRoom,
    some: int,
) -> int:  # fmt: skip
    """Lower the bounds of those alive; return how many are not refuted: the first ones."""
    m, above, alive = ask.kind[last], refuting(best), room.alive
    some = sweep(room.bases[-1], cuts.held[m], above, cuts, alive[:some], room.bounds)
    if best < 0.0:
        return some
    pinching = _pinching(ask, rows, last, alive[:some])
    places = Places(last, cuts.held[m], cuts.pressed[m], alive[:some], room.bounds)
    return _pinching_left(ask, rows, above, cuts, places, pinching, room)


@compiled
def survivors(
    ask: Question, rows: IntArray, last: int, first: int, best: float, cuts: PartnerCuts,
    room: PartnerRoom,
) -> int:  # fmt: skip
    """Return how many placements of the last finger, from row ``first`` on, are not refuted."""
    bases_without(ask, rows, last, cuts, room.bases)
    some = 0
    for b in room.blocks[: _blocks_left(ask, rows, last, best, cuts, room)]:
        for g in ask.blocks[ask.ends[b] : ask.ends[b + 1]]:
            if g >= first and ask.allowed[last, g]:
                room.alive[some], room.bounds[g] = g, np.inf
                some += 1
    some = lowered(ask, rows, last, best, cuts, room, some)
    left = 0
    for j in range(some):
        rows[last] = room.alive[j]
        if clear(ask, rows, last):
            room.alive[left] = room.alive[j]
            left += 1
    return left
