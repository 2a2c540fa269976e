"""For every placement of a finger, the largest z of a set of placements that it belongs to."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.contact.decision import Outcome
from gm_ompl.cores import share_out
from gm_ompl.feasibility.backends import Backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.mechanics.columns import wrench_norm
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.partner_cuts import (
    LOST,
    NOTHING,
    Found,
    PartnerCuts,
    Question,
    no_cuts,
    nothing_found,
)
from gm_ompl.mechanics.partner_sweeps import room_for
from gm_ompl.mechanics.partners import best_of, note

FIRST: Final = 150
"""Placements looked at first, spread over all faces: what they leave refutes most of the rest."""

BLOCKS: Final = 1700
"""Blocks of neighbouring placements, about, that are refuted together."""

AT_ONCE: Final = 64
"""Placements between two looks at the limits in force."""


@dataclass(frozen=True, eq=False)
class Partners:
    """The best that a finger can have at each placement.

    Attributes:
        z: (n, P), the largest margin, in the scenario's units of force; 0 is equilibrium alone,
            -inf none with any partners, or not allowed.
        sets: (n, P, n), a set of placements that has it; -1 for none.
        undecided: sets that nobody could decide; they count as none.
    """

    z: Array
    sets: IntArray
    undecided: int


def best_partners(judge: Judge, environment: int, allowed: BoolArray) -> Partners:
    """Find the best partners of every finger's every placement at a contact state.

    Args:
        judge: of the problem.
        environment: number of the contact state.
        allowed: (n, P), where each fingertip may be.

    Raises:
        LimitError: a limit in force is reached.
    """
    backend = judge.backend
    plain = judge.problem.uncertainty or judge.problem.mechanics.strong
    if not isinstance(backend, KernelBackend) or plain:
        return _all_sets(judge, environment, allowed)
    ask = _question(judge, backend, environment, allowed)
    n, P = allowed.shape
    known, cuts = nothing_found(n, P), no_cuts(ask)
    table = judge.problem.fingers.placements
    for i in ask.firsts.tolist() if allowed.any(axis=1).all() else ():
        coarse = _spread(table, allowed[i])
        _work(ask, i, coarse, coarse, cuts, known)
        _share(ask, i, np.setdiff1d(np.flatnonzero(allowed[i]), coarse), coarse, cuts, known)
    undecided = _settle(judge, backend, environment, ask.kind, known)
    backend.decisions += int(known.counts[0])
    z = np.where(known.z < 0.0, -np.inf, known.z * backend.scale)
    return Partners(z, known.sets, undecided)


def _question(
    judge: Judge, backend: KernelBackend, environment: int, allowed: BoolArray
) -> Question:
    hand = judge.problem.fingers
    traits = list(zip(hand.radius, hand.max_normal_force, hand.friction, hand.soft, strict=True))
    kinds = list(dict.fromkeys(traits))
    kind = np.array([kinds.index(trait) for trait in traits], dtype=np.int64)
    firsts = np.array([traits.index(trait) for trait in kinds], dtype=np.int64)
    centres = np.array([judge.centres(i) for i in range(hand.count)])
    points = np.ascontiguousarray(np.broadcast_to(hand.placements.points, centres.shape))
    normals = np.ascontiguousarray(np.broadcast_to(hand.placements.normals, centres.shape))
    widths = hand.friction * np.cos(np.pi / judge.problem.mechanics.cone_edges)
    U = wrench_norm(judge.problem.mass, judge.problem.inertia)
    columns = backend.columns(environment)
    return Question(
        *columns, DIRECTIONS, kind, firsts, np.ascontiguousarray(allowed), centres,
        judge.least_distances() ** 2, points, normals, np.ascontiguousarray(points[0].T),
        *_sides(hand.placements, columns[2], U), U, (1.0 + NOTHING) / np.hypot(1.0, widths),
        *_blocks(hand.placements),
    )  # fmt: skip


def _sides(table: PlacementTable, columns: Array, U: Array) -> tuple[IntArray, Array]:
    """Return where placements of equal normal begin (F + 1,), and their forces and moments.

    The columns U [d; p x d + e] at a point p come from few d and e (n, F, s, 6).
    """
    turns = np.flatnonzero((table.normals[1:] != table.normals[:-1]).any(axis=1)) + 1
    starts = np.concatenate([[0], turns])[: len(table)]
    sides = np.linalg.solve(U, columns[:, starts].swapaxes(2, 3)).swapaxes(2, 3)
    sides[..., 3:] -= np.cross(table.points[starts][:, None], sides[..., :3])
    return np.concatenate([starts, [len(table)]]).astype(np.int64), np.ascontiguousarray(sides)


def _blocks(table: PlacementTable) -> tuple[IntArray, IntArray]:
    """Return the placements block by block (P,), and where blocks begin (B + 1,).

    A block is a square of neighbouring cells on a face; on coarse grids each placement is one.
    """
    side = max(1, int((len(table) / BLOCKS) ** 0.5))
    keys = np.column_stack([table.face, table.cell // side])
    _, numbers = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(numbers, kind="stable")
    sizes = np.bincount(numbers.reshape(-1), minlength=1) if len(table) else np.zeros(0, np.int64)
    return order, np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _spread(table: PlacementTable, allowed: BoolArray) -> IntArray:
    """Return some allowed placements, about ``FIRST``, every so many cells on each face."""
    rows = np.flatnonzero(allowed)
    step = max(1, round((len(rows) / FIRST) ** 0.5))
    on = (table.cell[rows] % step == step // 2).all(axis=1)
    return rows[on] if on.any() else rows[::step]


def _share(
    ask: Question, i: int, rows: IntArray, coarse: IntArray, cuts: PartnerCuts, known: Found
) -> None:
    """Look at rows, both cores at once, each with cuts of its own."""
    nearest = _nearest(ask.centres[i], rows, coarse)

    def work(part: slice) -> None:
        own = Found(known.z.copy(), known.sets.copy(), known.lost.copy(), np.zeros(2, np.int64))
        own_cuts = PartnerCuts._make(each.copy() for each in cuts)
        _work(ask, i, rows[part], nearest[part], own_cuts, own)
        found.append(own)

    found: list[Found] = []
    share_out(work, len(rows))
    for own in found:
        better = own.z > known.z
        known.z[better], known.sets[better] = own.z[better], own.sets[better]
        room, lost = LOST - int(min(known.counts[1], LOST)), own.lost[: min(own.counts[1], LOST)]
        known.lost[LOST - room : LOST - room + len(lost[:room])] = lost[:room]
        known.counts[:] += own.counts


def _nearest(centres: Array, rows: IntArray, coarse: IntArray) -> IntArray:
    """Return for each row the nearest of the coarse ones."""
    from scipy.spatial import cKDTree  # loads long, and only maps ask

    nearest: IntArray = coarse[cKDTree(centres[coarse]).query(centres[rows])[1]]
    return nearest


def _work(
    ask: Question, i: int, rows: IntArray, near: IntArray, cuts: PartnerCuts, found: Found
) -> None:
    """Look at rows in order, each from the sets of the row before and of the one near it."""
    room = room_for(ask)
    for k, g in enumerate(rows):
        if k % AT_ONCE == 0:
            limits.check()
        hints = found.sets[i, [rows[max(0, k - 1)], near[k]]]
        best_of(ask, i, int(g), hints, cuts, found, room)


def _settle(judge: Judge, backend: Backend, environment: int, kind: IntArray, known: Found) -> int:
    """Have sets decided that the kernel could not prove; return how many nobody could."""
    lost = int(known.counts[1])
    everyone, undecided = tuple(range(known.sets.shape[2])), max(0, lost - LOST)
    for rows in known.lost[: min(lost, LOST)].tolist():
        decision = backend.decide(environment, everyone, tuple(rows))
        undecided += decision.outcome is Outcome.UNDECIDED
        if decision.outcome is Outcome.STABLE:
            note(kind, np.array(rows), decision.z / judge.problem.force_scale, known)
    return undecided


def _all_sets(judge: Judge, environment: int, allowed: BoolArray) -> Partners:
    """Decide every set of placements."""
    n, P = allowed.shape
    known, undecided, scale = nothing_found(n, P), 0, judge.problem.force_scale
    everyone = tuple(range(n))
    for rows in _sets(judge, allowed):
        limits.check()
        decision = judge.backend.decide(environment, everyone, rows)
        undecided += decision.outcome is Outcome.UNDECIDED
        if decision.outcome is Outcome.STABLE:
            note(np.arange(n), np.array(rows), decision.z / scale, known)
    return Partners(np.where(known.z < 0.0, -np.inf, known.z * scale), known.sets, undecided)


def _sets(judge: Judge, allowed: BoolArray) -> Iterator[tuple[int, ...]]:
    for rows in itertools.product(*(np.flatnonzero(mask).tolist() for mask in allowed)):
        if judge.apart(rows):
            yield rows
