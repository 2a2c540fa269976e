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
from gm_ompl.graph.goals import restricted
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.graph.sets import ordered_sets, placement_sets
from gm_ompl.problem import Placements, Problem

MOST_SETS: Final = 2_000_000
"""Start sets kept in one array; beyond, they are made one by one."""

LARGEST_BLOCK: Final = 4096
"""Sets whose keys are renewed in one compiled call at most."""

UNRENEWED: Final = -1
"""Stands for what a key rests on that geometry alone gave."""

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
        self._part = next(parts, None)
        n = 0 if self._part is None else self._part[1].shape[1]
        self._keep(np.empty(0), np.empty((0, n), dtype=np.int64), np.empty(0, dtype=np.int64))
        self._back: list[tuple[float, Placements, int]] = []  # taken, and put back: a heap
        self._block = 1

    def _keep(self, keys: Array, rows: IntArray, versions: IntArray) -> None:
        """Keep these sets, with +inf behind."""
        self._keys = np.append(keys, np.inf)
        self._rows, self._versions, self._next = rows, versions, 0

    def key(self) -> float:
        """Return a lower bound on the cost of plans from all sets that wait; +inf at the end."""
        key = float(self._keys[self._next])
        if self._part is not None:
            key = min(key, float(self._part[0][0]))
        return min(key, self._back[0][0]) if self._back else key

    def is_ready(self) -> bool:
        """Whether the first set is to be taken: its key is fresh, or no other's has been stale."""
        if self._block == 1:
            return True
        first, version = self.key(), self._graph.version
        if self._back and self._back[0][0] == first:
            return self._back[0][2] == version
        return bool(self._keys[self._next] == first and self._versions[self._next] == version)

    def take(self) -> tuple[float, Placements]:
        """Return the first set with its key."""
        self._fill()
        if self._back and self._back[0][0] <= self._keys[self._next]:
            key, placements, _ = heapq.heappop(self._back)
            return key, placements
        first, self._next = self._next, self._next + 1
        return float(self._keys[first]), tuple(self._rows[first].tolist())

    def put_back(self, key: float, placements: Placements) -> None:
        """Let a set that was taken wait again."""
        if key < math.inf:
            heapq.heappush(self._back, (key, placements, self._graph.version))

    def judged(self, stale: bool) -> None:
        """Hear whether the key of the set taken last was stale."""
        self._block = max(2, self._block) if stale else 1

    def renew(self) -> int:
        """Renew the keys of the first sets, twice as many as before; return how many."""
        self._fill()
        part = slice(self._next, min(self._next + self._block, len(self._keys) - 1))
        rows, keys = self._rows[part].copy(), self._keys[part].copy()
        back: list[tuple[float, Placements, int]] = []
        while self._back and self._back[0][0] <= self._keys[part.stop] and len(back) < self._block:
            back.append(heapq.heappop(self._back))
        if back:
            rows = np.concatenate([rows, [placements for _, placements, _ in back]])
            keys = np.append(keys, [key for key, _, _ in back])
        keys = np.maximum(keys, self._graph.keys(rows, self._start))
        own = len(keys) - len(back)
        for key, (_, placements, _) in zip(keys[own:].tolist(), back, strict=True):
            self.put_back(key, placements)
        self._next = part.stop
        order = np.argsort(keys[:own], kind="stable")
        order = order[: np.isfinite(keys[:own]).sum()]
        self._insert(keys[order], rows[order])
        self._block = min(2 * self._block, LARGEST_BLOCK)
        return len(rows)

    def _insert(self, keys: Array, rows: IntArray) -> None:
        """Put sets with fresh, sorted keys in their places; as many at least were taken."""
        behind, self._next = self._next, self._next - len(keys)
        version = self._graph.version
        merge(keys, rows, version, behind, self._keys, self._rows, self._versions)

    def _fill(self) -> None:
        """Take in the parts that may hold the first set."""
        while self._part is not None and self._part[0][0] <= self._keys[self._next]:
            keys, rows = self._part
            keys = np.concatenate([self._keys[self._next : -1], keys])
            order = np.argsort(keys, kind="stable")
            versions = self._versions[self._next :]
            versions = np.pad(versions, (0, len(rows)), constant_values=UNRENEWED)
            rows = np.concatenate([self._rows[self._next :], rows])
            self._keep(keys[order], rows[order], versions[order])
            self._part = next(self._parts, None)


def start_sets(problem: Problem, judge: Judge, graph: LaneGraph, start: int) -> StartSets:
    """Return the source of all valid sets at the start node."""
    tables = graph.tables
    geometry = judge.node(problem.lattice.coordinates(start))
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
