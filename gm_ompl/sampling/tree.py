"""A tree of lanes grown along a route, from the start onwards or from the goal backwards."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from gm_ompl.arrays import BoolArray, IntArray
from gm_ompl.holds.extraction import Leg, merged
from gm_ompl.holds.goals import fits, restricted
from gm_ompl.holds.watch import Stop
from gm_ompl.problem import Placements, Problem
from gm_ompl.sampling.lane_store import LaneStore, SetDraw
from gm_ompl.sampling.settings import ExploringSettings

ROOT: Final = -1
"""Stands for the parent of a set that needs none."""

ATTEMPTS: Final = 8
"""Places for a regrasp that are drawn before a growth step gives up."""


@dataclass(frozen=True)
class Branch:
    """A set that holds along a stretch of the route.

    Attributes:
        lane: the canonical set.
        enter: the vertex where the tree came to it.
        reach: the vertex up to which it is decided to hold, as seen from ``enter``.
        parent: number of the branch it was regrasped from (or to, in a goal tree), or ROOT.
    """

    lane: Placements
    enter: int
    reach: int
    parent: int


@final
class Tree:
    """Branches along one route.

    Args:
        problem: the problem.
        store: what is known along the route.
        draw: draws sets at this tree's end.
        ahead: from the start onwards, or from the goal backwards (judged onwards all the same).
        settings: how it grows.
        rng: the source of randomness.

    Attributes:
        branches: all branches.
        by_lane: the branches of a set.
        by_hub: the branches that a hub joins.
        best: the largest share of the route that a branch came.
        steps: growth steps so far.
    """

    def __init__(
        self,
        problem: Problem,
        store: LaneStore,
        draw: SetDraw,
        ahead: bool,
        settings: ExploringSettings,
        rng: np.random.Generator,
    ) -> None:
        self._store, self._draw, self._settings, self._rng = store, draw, settings, rng
        self._K = store.route.strides
        self.ahead = ahead
        self._first, self._last = (0, self._K) if ahead else (self._K, 0)
        given = problem.fingers.start if ahead else problem.fingers.goal
        here = store.route.node_free[:, :, self._first]
        self._allowed: tuple[BoolArray, ...] = restricted(tuple(here), given)
        self._wanted = problem.fingers.goal if ahead else problem.fingers.start
        self.branches: list[Branch] = []
        self.by_lane: dict[Placements, list[int]] = {}
        self.by_hub: dict[Placements, list[int]] = {}
        self._roots: set[Placements] = set()
        self._tried: set[tuple[Placements, int]] = set()
        self._visits: list[int] = []
        self.best, self.steps = 0.0, 0

    def progress(self, vertex: int) -> int:
        """Return how many strides ``vertex`` is from the tree's end."""
        return abs(vertex - self._first)

    def fits_other_end(self, lane: Placements) -> bool:
        """Whether the fingers are where the motion's other end wants them."""
        return fits(lane, self._wanted)

    def grow(self, stop: Stop) -> int | None:
        """Try one growth step; return the new branch's number, if any."""
        self.steps += 1
        if not self.branches or self._rng.random() < self._settings.root_share:
            return self._grow_root(stop)
        return self._grow_hub(stop)

    def _grow_root(self, stop: Stop) -> int | None:
        drawn = self._draw.draw(self._settings.batch, self._allowed, self._rng)
        fresh = [k for k, row in enumerate(drawn.tolist()) if tuple(row) not in self._roots]
        sets = np.ascontiguousarray(drawn[fresh])
        # Where the object need not move, every set comes all the way.
        found, reach = self._race(sets, self._first, 0 if self._K else -1, stop)
        if len(sets) and self._K:
            self._draw.learn(sets, np.abs(reach - self._first) / self._K)
        if found is None:
            return None
        lane = tuple(sets[found].tolist())
        self._roots.add(lane)
        if not self._store.free_at_end(lane, self._first):
            return None
        return self._add(Branch(lane, self._first, int(reach[found]), ROOT))

    def _race(
        self, sets: IntArray, first: int, least: int, stop: Stop
    ) -> tuple[int | None, IntArray]:
        """Find the set that comes furthest from ``first``, judging as little as needed.

        Args:
            sets: (L, n).
            first: where all start.
            least: a set must come beyond this many strides from the tree's end.
            stop: asked between judgements.

        Returns:
            The winner, or None, and how far each set may come at most.
        """
        sign = 1 if self.ahead else -1
        reach = np.full(len(sets), self._last, dtype=np.int64)
        self._store.screen(sets, first, self._last, reach)
        while len(sets) and not stop():
            m = int(np.argmax(sign * reach))
            if self.progress(int(reach[m])) <= least:
                break
            lane = tuple(sets[m].tolist())
            got = self._store.probe(lane, first, int(reach[m]))
            if got == reach[m]:
                return m, reach
            reach[m] = got
            # The decision left a cut at the stride that failed: who else does it stop there?
            after = np.full(len(sets), got + sign, dtype=np.int64)
            self._store.screen(sets, got, got + sign, after)
            stopped = (after == got) & (sign * reach > sign * got)
            reach[stopped] = got
        return None, reach

    def _add(self, branch: Branch) -> int:
        number = len(self.branches)
        self.branches.append(branch)
        self._visits.append(0)
        self.by_lane.setdefault(branch.lane, []).append(number)
        for slot in range(len(branch.lane)):
            self.by_hub.setdefault(self._store.lifted(branch.lane, slot), []).append(number)
        if self._K:
            self.best = max(self.best, self.progress(branch.reach) / self._K)
        return number

    def _grow_hub(self, stop: Stop) -> int | None:
        """Try a regrasp where a branch fails, or shortly before."""
        for _ in range(ATTEMPTS):
            parent = self._pick()
            branch = self.branches[parent]
            span = abs(branch.reach - branch.enter)
            back = int(self._rng.exponential(self._settings.backtrack_share) * self._K)
            vertex = branch.reach - (1 if self.ahead else -1) * min(back, span)
            hub = self._store.lifted(branch.lane, int(self._rng.integers(len(branch.lane))))
            if (hub, vertex) in self._tried:
                continue
            self._tried.add((hub, vertex))
            if self._store.known.rest_holds(hub, vertex):
                return self._from_hub(parent, hub, vertex, stop)
        return None

    def _pick(self) -> int:
        """Draw a branch: far and seldom tried ones are likely."""
        reach = np.array([self.progress(branch.reach) for branch in self.branches])
        behind = (reach.max() - reach) / max(self._K, 1)
        weights = np.exp(-self._settings.progress_bias * behind) / (1.0 + np.array(self._visits))
        number = int(self._rng.choice(len(weights), p=weights / weights.sum()))
        self._visits[number] += 1
        return number

    def _from_hub(self, parent: int, hub: Placements, vertex: int, stop: Stop) -> int | None:
        branch = self.branches[parent]
        sets = self._store.targets(hub, vertex)
        sets = np.ascontiguousarray(sets[(sets != np.array(branch.lane)).any(axis=1)])
        if not len(sets):
            return None
        sets = np.ascontiguousarray(self._rng.permutation(sets))
        least = self.progress(branch.reach)
        found, reach = self._race(sets, vertex, least, stop)
        while found is not None and not self._joined(parent, hub, vertex, sets[found]):
            sets = np.ascontiguousarray(np.delete(sets, found, axis=0))
            found, reach = self._race(sets, vertex, least, stop)
        if found is not None:
            lane = tuple(sets[found].tolist())
            return self._add(Branch(lane, vertex, int(reach[found]), parent))
        if not len(sets):
            return None
        # A branch that came all the way with its fingers in the wrong places needs no luck.
        arrived = branch.reach == self._last and not self.fits_other_end(branch.lane)
        if arrived or self._rng.random() < self._settings.no_progress_share:
            # One with most fingers where the motion's other end wants them.
            wanted = np.array([-1 if row is None else row for row in self._wanted])
            lane = tuple(sets[int(np.argmax((sets == wanted).sum(axis=1)))].tolist())
            if lane not in self.by_lane and self._joined(parent, hub, vertex, lane):
                return self._add(Branch(lane, vertex, self._onward(lane, vertex), parent))
        return None

    def _joined(
        self, parent: int, hub: Placements, vertex: int, after: IntArray | Placements
    ) -> bool:
        """Whether the lifted finger gets from branch ``parent`` to the set ``after``."""
        before = self.branches[parent].lane
        return self._store.joined(hub, vertex, before, tuple(int(row) for row in after))

    def _onward(self, lane: Placements, vertex: int) -> int:
        """Return how far a set comes from ``vertex``."""
        bound = np.array([self._last])
        self._store.screen(np.array([lane]), vertex, self._last, bound)
        reach = int(bound[0])
        while (got := self._store.probe(lane, vertex, reach)) != reach:
            reach = got
        return reach

    def legs(self, number: int, vertex: int) -> list[Leg]:
        """Return the legs between the tree's end and ``vertex`` on branch ``number``."""
        legs: list[Leg] = []
        while number != ROOT:
            branch = self.branches[number]
            ends = (branch.enter, vertex) if self.ahead else (vertex, branch.enter)
            legs.append((branch.lane, *ends))
            vertex, number = branch.enter, branch.parent
        return legs[::-1] if self.ahead else legs


def join(store: LaneStore, tree: Tree, number: int, other: Tree) -> list[Leg] | None:
    """Return the legs of a plan through branch ``number`` of ``tree`` and some of ``other``."""
    branch = tree.branches[number]
    for k in other.by_lane.get(branch.lane, ()):
        low, high = _overlap(branch, other.branches[k])
        if low <= high:
            return _joined(tree, number, other, k, low)
    for slot in range(len(branch.lane)):
        hub = store.lifted(branch.lane, slot)
        for k in other.by_hub.get(hub, ()):
            low, high = _overlap(branch, other.branches[k])
            for vertex in range(low, high + 1):
                lanes = branch.lane, other.branches[k].lane
                if store.known.rest_holds(hub, vertex) and store.joined(hub, vertex, *lanes):
                    return _joined(tree, number, other, k, vertex)
    return None


def _overlap(a: Branch, b: Branch) -> tuple[int, int]:
    low = max(min(a.enter, a.reach), min(b.enter, b.reach))
    return low, min(max(a.enter, a.reach), max(b.enter, b.reach))


def _joined(tree: Tree, number: int, other: Tree, k: int, vertex: int) -> list[Leg]:
    onward, back = (tree, other) if tree.ahead else (other, tree)
    i, j = (number, k) if tree.ahead else (k, number)
    return merged(onward.legs(i, vertex) + back.legs(j, vertex))
