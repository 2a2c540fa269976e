"""A* over (pose, set of placements), all sets at once: compiled.

A state is *open* while an arc may leave it that was not followed yet. Its key is the least bound
of a plan along one of those; arcs dearer than the limit in force wait (partial expansion). What is
not known yet of an arc is asked for, and the state stays open.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.graph.goal_distance import way_left
from gm_ompl.graph.kept_book import find, margin, meet, put
from gm_ompl.graph.kept_tables import (
    ARRIVED,
    ASKED_FOR,
    BLOCKED,
    EMPTY,
    FAILED,
    READY,
    SAME,
    STATES,
    UNKNOWN,
    WANTED,
    FloorTable,
    KeptArcs,
    KeptSets,
    KeptTables,
    Relaxed,
)
from gm_ompl.graph.potentials import potential
from gm_ompl.holds.sets import LIFTED


@lean
def ahead(pose: int, hand: int, tables: KeptTables) -> float:
    """Return a lower bound on the cost from a state to the goal; +inf: beyond what was reached."""
    hands, places, bodies = tables.hands, tables.poses.places, tables.bodies
    least, most = np.inf, 0.0
    for i in range(hands.lifts.shape[1]):
        hub = hands.lifts[hand, i]
        if hub != EMPTY and hands.alive[hub]:
            least = min(least, _after(pose, hub, tables.relaxed))
    if hands.lifts[hand, 0] != EMPTY:
        return float(least)
    if tables.relaxed.rows[hand] != EMPTY:
        return _after(pose, hand, tables.relaxed)
    number = bodies.numbers[pose]
    R, p = bodies.rotations[number], bodies.positions[number]
    for i in range(hands.rows.shape[1]):
        row = hands.rows[hand, i]
        if row != LIFTED:
            most = max(most, way_left(tables.goal, hands.shapes[i], row, R, p))
    row, attitude = tables.floor.rows[hand], tables.poses.attitudes[pose]
    if row >= 0 and attitude >= 0:
        most = max(most, _left_on_floor(row, attitude, R, p, tables.floor))
    if hands.known[hand]:
        most = max(most, potential(hands.potentials[hand], places[pose], hands.target))
    return float(most)


@lean
def _after(pose: int, hand: int, relaxed: Relaxed) -> float:
    """Return what follows where some fingers stay to the end, by what stands for them.

    Of states that were met since, nothing is known yet.
    """
    there = relaxed.book.slots[find(relaxed.book, pose, relaxed.rows[hand])]
    known = there != EMPTY and there < len(relaxed.after)
    return float(relaxed.extra[hand] + relaxed.after[there]) if known else np.inf


@inlined
def _left_on_floor(row: int, attitude: int, R: Array, p: Array, floor: FloorTable) -> float:
    """Return what is left to pay from a pose on an open floor."""
    o, left = floor.points[row], floor.values[row, attitude] - floor.slack
    for c in range(2):
        here = p[c] + R[c, 0] * o[0] + R[c, 1] * o[1] + R[c, 2] * o[2]
        left += floor.ways[row, c] * (floor.goal[c] - here)
    return float(left)


@compiled
def begin(which: IntArray, tables: KeptTables) -> None:
    """Open sets at the start, pose 0."""
    for hand in which:
        left = min(ahead(0, hand, tables), beyond(tables.relaxed))
        put(tables.book, meet(0, hand, left, tables.book), 0.0, EMPTY, EMPTY)


@compiled
def renew(which: IntArray, tables: KeptTables) -> None:
    """Raise the keys of open states to what bounds say by now."""
    book, past = tables.book, beyond(tables.relaxed)
    for number in which:
        left = ahead(book.pose[number], book.hand[number], tables)
        book.key[number] = max(book.key[number], min(past, book.cost[number] + left))


@inlined
def beyond(relaxed: Relaxed) -> float:
    """Return what ways cost at least that were not followed."""
    return float(relaxed.reached * (1.0 + SAME))


@lean
def expand(which: IntArray, limit: float, tables: KeptTables) -> int:
    """Follow the arcs from open states, up to plans of a bound of at most ``limit``.

    The states' poses must have their arcs. Returns how many were followed until the book is full.
    """
    hands, poses, book = tables.hands, tables.poses, tables.book
    for k in range(len(which)):
        number = which[k]
        hand, pose = book.hand[number], book.pose[number]
        coming = poses.past[pose] - poses.first[pose] + hands.rows.shape[1]
        if book.counts[STATES] + coming > len(book.cost):
            return k
        book.key[number], nearest = np.inf, np.inf
        if hands.alive[hand]:
            for arc in range(poses.first[pose], poses.past[pose]):
                nearest = min(nearest, _follow(number, arc, limit, tables))
            for i in range(hands.lifts.shape[1]):
                if hands.lifts[hand, i] != EMPTY:
                    nearest = min(nearest, _lift(number, hands.lifts[hand, i], limit, tables))
        book.key[number] = min(book.key[number], nearest)
    return len(which)


@lean
def _lift(number: int, hub: int, limit: float, tables: KeptTables) -> float:
    """Lift a finger; return the bound of plans by that where it is still to be done, or +inf.

    Its price is paid where the finger is put down again.
    """
    book, pose = tables.book, tables.book.pose[number]
    here, there = book.cost[number], book.slots[find(book, pose, hub)]
    before = book.cost[there] if there != EMPTY else np.inf
    if not tables.hands.alive[hub] or before <= here * (1.0 + SAME):
        return np.inf
    left = _after(pose, hub, tables.relaxed)
    if left == np.inf:
        return beyond(tables.relaxed)
    if here + left > limit:
        return float(here + left)
    if tables.poses.rests[pose] < 0:
        tables.poses.rests[pose] = ASKED_FOR
        return float(here + left)
    z = margin(tables.poses.rests[pose], hub, book)
    if z == FAILED:
        return np.inf
    if np.isnan(z):
        return float(here + left)
    put(book, meet(pose, hub, left, book), here, number, EMPTY)
    return np.inf


@compiled
def put_down(number: int, hands: IntArray, tables: KeptTables) -> None:
    """Let the lifted finger of a hub's state touch again: open sets (m,).

    There must be room for them.
    """
    book, pose = tables.book, tables.book.pose[number]
    cost = book.cost[number] + tables.prices.X_regr
    for hand in hands:
        there = book.slots[find(book, pose, hand)]
        left = ahead(pose, hand, tables)
        if left < np.inf and (there == EMPTY or cost < book.cost[there] * (1.0 - SAME)):
            put(book, meet(pose, hand, left, book), cost, number, EMPTY)
            book.counts[ARRIVED] += tables.poses.goal[pose]


@lean
def _follow(number: int, arc: int, limit: float, tables: KeptTables) -> float:
    """Follow an arc; return the bound of plans by it where it is still to be followed, or +inf."""
    hands, arcs, book = tables.hands, tables.arcs, tables.book
    hand, head, kind = book.hand[number], arcs.heads[arc], arcs.kinds[arc]
    stage, form, here = arcs.stages[kind], arcs.forms[arc], book.cost[number]
    if stage == BLOCKED or (stage == READY and not _is_free(arcs, kind, hands, hand)):
        return np.inf
    cost, known = _price(-1, form, hand, tables)
    there, before = book.slots[find(book, head, hand)], np.inf
    if there != EMPTY:
        before = book.cost[there]
    if before <= (here + cost) * (1.0 + SAME):
        return np.inf
    left = book.bound[there] if there != EMPTY else 0.0
    if there == EMPTY or tables.relaxed.rows[hand] >= 0:
        left = ahead(head, hand, tables)
    if left == np.inf:
        return beyond(tables.relaxed)
    if stage == READY and here + cost + left <= limit:
        cost, known = _price(kind, form, hand, tables)
        if known and before <= (here + cost) * (1.0 + SAME):
            return np.inf
    total = here + cost + left
    if not known or total > limit:
        if total <= limit and stage == UNKNOWN:
            arcs.stages[kind] = WANTED
        return float(total)
    put(book, meet(head, hand, left, book), here + cost, number, arc)
    book.counts[ARRIVED] += tables.poses.goal[head]
    return np.inf


@inlined
def _is_free(arcs: KeptArcs, kind: int, hands: KeptSets, hand: int) -> bool:
    """Whether fingertips penetrate nothing along a class of arcs."""
    free = True
    for i in range(hands.rows.shape[1]):
        row = hands.rows[hand, i]
        if row != LIFTED:
            free &= arcs.free[kind, hands.shapes[i], row]
    return free


@lean
def _price(kind: int, form: int, hand: int, tables: KeptTables) -> tuple[float, bool]:
    """Return Eq. (9), and whether it is known; by travel alone where it is not, or without kind.

    Margins that are not known are asked for.
    """
    hands, arcs, prices = tables.hands, tables.arcs, tables.prices
    known, travel, arm = kind >= 0, 0.0, 0.0
    for j in range(arcs.chords.shape[1]):
        z = np.inf
        if kind >= 0 and arcs.states[kind, j] >= 0:
            z = margin(arcs.states[kind, j], hand, tables.book)
        if z == FAILED:
            return np.inf, True
        if np.isnan(z):
            known, z = False, np.inf
        travel += (1.0 + prices.X_stab / max(z, prices.z_floor)) * arcs.chords[form, j]
    point, way = arcs.lines[form, 0], arcs.lines[form, 1]
    if way[0] == 0.0 and way[1] == 0.0 and way[2] == 0.0:
        return travel, known
    for i in range(hands.rows.shape[1]):
        row = hands.rows[hand, i]
        if row != LIFTED:
            arm = max(arm, _arm(tables.goal.tips[hands.shapes[i], row], point, way))
    return travel * arm, known


@inlined
def _arm(tip: Array, point: Array, way: Array) -> float:
    """Return how far a fingertip (3,) is from a line."""
    x, y, z = tip[0] - point[0], tip[1] - point[1], tip[2] - point[2]
    along = x * way[0] + y * way[1] + z * way[2]
    x, y, z = x - along * way[0], y - along * way[1], z - along * way[2]
    return float(np.sqrt(x * x + y * y + z * z))


@lean
def list_steps(which: IntArray, tables: KeptTables, ends: IntArray, costs: Array) -> int:
    """List the steps from states to others by arcs that are free; return how many there are.

    Arcs that are not known are taken to be free; no margin is asked for.

    Args:
        which: the states.
        tables: what is known.
        ends: (m, 2), written: states.
        costs: (m,), written.
    """
    hands, poses, arcs, book, count = tables.hands, tables.poses, tables.arcs, tables.book, 0
    for number in which:
        hand, pose = book.hand[number], book.pose[number]
        for arc in range(poses.first[pose], poses.past[pose]):
            kind = arcs.kinds[arc]
            stage = arcs.stages[kind]
            if stage == BLOCKED or (stage == READY and not _is_free(arcs, kind, hands, hand)):
                continue
            there = book.slots[find(book, arcs.heads[arc], hand)]
            if there != EMPTY:
                ends[count, 0], ends[count, 1] = number, there
                costs[count], _ = _price(-1, arcs.forms[arc], hand, tables)
                count += 1
    return count


@compiled
def settle(ends: IntArray, costs: Array, left: Array) -> None:
    """Lower what is left to pay from states to what steps say.

    Args:
        ends: (m, 2), states; quickest where steps near the goal come last.
        costs: (m,), of the steps.
        left: (E,), lowered.
    """
    changed = True
    while changed:
        changed = False
        for k in range(len(ends) - 1, -1, -1):
            one = costs[k] + left[ends[k, 1]]
            if one < left[ends[k, 0]] * (1.0 - SAME):
                left[ends[k, 0]], changed = one, True
