"""Where lanes come from: all start sets, in increasing order of their lower bounds."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator
from typing import Final, TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.holds.goals import restricted
from gm_ompl.holds.sets import ordered_sets, placement_sets
from gm_ompl.problem import Placements, Problem

MOST_SETS: Final = 2_000_000
"""Start sets kept in one array; beyond, they are made one by one."""

LARGEST_BLOCK: Final = 4096
"""Sets whose keys are renewed in one compiled call at most."""

Part: TypeAlias = tuple[Array, IntArray]
"""Keys (L,), not decreasing, and sets (L, n)."""


@compiled
def merge(
    keys: Array, rows: IntArray, version: int, behind: int, all_keys: Array, all_rows: IntArray,
    versions: IntArray,
) -> None:  # fmt: skip
    """Merge sorted keys and sets (K,), (K, n) into those from ``behind`` on, K places earlier."""
    K, n = rows.shape
    place, old, new = behind - K, behind, 0
    while new < K:
        if old < len(versions) and all_keys[old] < keys[new]:
            all_keys[place], versions[place] = all_keys[old], versions[old]
            for i in range(n):
                all_rows[place, i] = all_rows[old, i]
            old += 1
        else:
            all_keys[place], versions[place] = keys[new], version
            for i in range(n):
                all_rows[place, i] = rows[new, i]
            new += 1
        place += 1


@final
class StartSets:
    """All start sets, those least likely to cost much first.

    A set comes with a key that geometry alone gives. When it reaches the front, its key is renewed
    by the cuts and hubs' bounds known then, together with those of the sets behind it: two, four,
    eight, ... of them until the key in front is fresh, so that less than twice as many are renewed
    as must be.

    Args:
        parts: all sets, in increasing order of their keys.
        start: the start node.
        graph: renews keys.
    """

    def __init__(self, parts: Iterator[Part], start: int, graph: LaneGraph) -> None:
        self._parts, self._start, self._graph = parts, start, graph
        self._part, self._at = next(parts, None), 0  # sets that never came to the front
        n = 0 if self._part is None else self._part[1].shape[1]
        self._keys, self._rows = np.array([np.inf]), np.empty((0, n), dtype=np.int64)
        self._versions, self._next = np.empty(0, dtype=np.int64), 0  # sets renewed among others
        self._back: list[tuple[float, Placements, int]] = []  # taken, and put back: a heap
        self._block = 1

    def _fronts(self) -> tuple[float, float, float]:
        """Return the first keys of what never came, of what was renewed, of what was put back."""
        part = math.inf if self._part is None else float(self._part[0][self._at])
        back = self._back[0][0] if self._back else math.inf
        return part, float(self._keys[self._next]), back

    def key(self) -> float:
        """Return a lower bound on the cost of plans from all sets that wait; +inf at the end."""
        return min(self._fronts())

    def is_ready(self) -> bool:
        """Whether the first set is to be taken: its key is fresh, or no other's has been stale."""
        if self._block == 1:
            return True
        part, renewed, back = self._fronts()
        version = self._graph.version
        if back <= min(part, renewed):
            return self._back[0][2] == version
        return renewed <= part and bool(self._versions[self._next] == version)

    def take(self) -> tuple[float, Placements]:
        """Return the first set with its key."""
        part, renewed, back = self._fronts()
        if back <= min(part, renewed):
            key, placements, _ = heapq.heappop(self._back)
            return key, placements
        keys, rows = self._cut(1, renewed <= part)
        return float(keys[0]), tuple(rows[0].tolist())

    def put_back(self, key: float, placements: Placements) -> None:
        """Let a set that was taken wait again."""
        if key < math.inf:
            heapq.heappush(self._back, (key, placements, self._graph.version))

    def judged(self, stale: bool) -> None:
        """Hear whether the key of the set taken last was stale."""
        self._block = max(2, self._block) if stale else 1

    def renew(self) -> int:
        """Renew the keys of the first sets, up to twice as many as before; return how many."""
        part, renewed, back = self._fronts()
        if back <= min(part, renewed):
            count = self._renew_back(min(part, renewed))
        else:
            own = renewed <= part
            assert own or self._part is not None, "nothing is left"
            left = self._part[0][self._at :] if self._part is not None else self._keys[:0]
            waiting = self._keys[self._next : -1] if own else left
            # Not beyond what comes first elsewhere.
            near = waiting[: self._block]
            least = min(part if own else renewed, back)
            count = max(1, int(np.searchsorted(near, least, side="right")))
            keys, rows = self._cut(count, own)
            keys = np.maximum(keys, self._graph.keys(rows, self._start))
            order = np.argsort(keys, kind="stable")
            order = order[: np.isfinite(keys).sum()]
            self._insert(keys[order], rows[order])
        self._block = min(2 * self._block, LARGEST_BLOCK)
        return count

    def _renew_back(self, least: float) -> int:
        """Renew keys up to ``least`` of sets that were put back."""
        back: list[tuple[float, Placements, int]] = []
        while self._back and self._back[0][0] <= least and len(back) < self._block:
            back.append(heapq.heappop(self._back))
        rows = np.array([placements for _, placements, _ in back], dtype=np.int64)
        keys = self._graph.keys(rows, self._start).tolist()
        for (before, placements, _), key in zip(back, keys, strict=True):
            self.put_back(max(before, key), placements)
        return len(back)

    def _cut(self, count: int, own: bool) -> Part:
        """Take the first sets away, of those renewed (``own``) or of those that never came."""
        if own:
            part = slice(self._next, self._next + count)
            self._next = part.stop
            return self._keys[part].copy(), self._rows[part].copy()
        assert self._part is not None, "nothing is left"
        part = slice(self._at, self._at + count)
        keys, rows = self._part[0][part], self._part[1][part]
        self._at = part.stop
        if self._at == len(self._part[0]):
            self._part, self._at = next(self._parts, None), 0
        return keys, rows

    def _insert(self, keys: Array, rows: IntArray) -> None:
        """Put sets with fresh, sorted keys in their places among those renewed."""
        if self._next < len(keys):
            room = len(keys) + len(self._keys)  # twice as much: each set is moved rarely
            self._keys = np.concatenate([np.empty(room), self._keys[self._next :]])
            empty = np.empty((room, rows.shape[1]), dtype=np.int64)
            self._rows = np.concatenate([empty, self._rows[self._next :]])
            self._versions = np.concatenate([empty[:, 0], self._versions[self._next :]])
            self._next = room
        behind, self._next = self._next, self._next - len(keys)
        version = self._graph.version
        merge(keys, rows, version, behind, self._keys, self._rows, self._versions)


def start_sets(problem: Problem, judge: Judge, graph: LaneGraph) -> StartSets:
    """Return the source of all valid sets at the start node."""
    tables, start = graph.tables, graph.start
    geometry = judge.node(problem.object_graph.pose(problem.object_graph.start))
    allowed = restricted(geometry.free, problem.fingers.start)
    groups = problem.fingers.groups()
    onward = tables.X_regr + tables.least[start]
    keys = [np.minimum(tables.ahead[i, :, start], onward) for i in range(len(allowed))]
    sets = placement_sets(groups, allowed, judge.clear, MOST_SETS)
    if sets is None:
        one_by_one = ordered_sets(groups, allowed, keys, judge.clear)
        return StartSets(_parts(one_by_one), start, graph)
    largest = np.max([key[sets[:, i]] for i, key in enumerate(keys)], axis=0)
    order = np.argsort(largest, kind="stable")
    order = order[: np.isfinite(largest).sum()]
    whole = [(largest[order], sets[order])] if len(order) else []
    return StartSets(iter(whole), start, graph)


def _parts(sets: Iterator[tuple[float, Placements]]) -> Iterator[Part]:
    while part := list(itertools.islice(sets, LARGEST_BLOCK)):
        keys, rows = zip(*part, strict=True)
        yield np.array(keys), np.array(rows, dtype=np.int64)
