"""Start sets come in the order of their keys, whatever is learnt while they wait."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gm_ompl.arrays import Array, IntArray
from gm_ompl.planners import lane_sources
from gm_ompl.planners.lane_sources import Part, StartSets, merge


class Learning:
    """Stands for the graph: keys rise with every version."""

    def __init__(self, first: Array, rng: np.random.Generator) -> None:
        self.true, self._rng, self.version = first.copy(), rng, 0

    def learn(self) -> None:
        """Raise some keys, a few of them to +inf."""
        rises = self._rng.random(len(self.true)) < 0.3
        self.true[rises] += self._rng.exponential(size=rises.sum())
        self.true[self._rng.random(len(self.true)) < 0.02] = math.inf
        self.version += 1

    def keys(self, sets: IntArray, config: int) -> Array:
        """Return what is known now."""
        assert config == 5
        return np.array(self.true[sets[:, 0]])


def parts(keys: Array, sizes: list[int]) -> Iterator[Part]:
    """Yield sets 0, 1, ... in increasing order of their keys, in parts of these sizes."""
    order = np.argsort(keys, kind="stable")
    for part in np.split(order, np.cumsum(sizes)):
        if len(part):
            yield keys[part], np.stack([part, part + 1000], axis=1)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 60),
    st.lists(st.integers(1, 20), max_size=4),
    st.sampled_from([2, 8, 4096]),
)
@settings(max_examples=150, deadline=None)
def test_the_cheapest_comes_first(seed: int, count: int, sizes: list[int], block: int) -> None:
    """A fresh set that is taken has the least true key; sets that wait are never lost."""
    rng = np.random.default_rng(seed)
    first = np.round(rng.random(count), 1)  # many are equal
    graph = Learning(first, rng)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lane_sources, "LARGEST_BLOCK", block)
        source = StartSets(parts(first, sizes), 5, graph)  # type: ignore[arg-type]
        waiting = set(range(count))
        while source.key() < math.inf:
            assert source.key() <= min(graph.true[sorted(waiting)], default=math.inf)
            if not source.is_ready():
                source.renew()
                continue
            key, (name, other) = source.take()
            assert other == name + 1000
            stale = graph.true[name] > key
            source.judged(stale)
            if stale:
                source.put_back(float(graph.true[name]), (name, other))
                continue
            assert key == graph.true[name] == min(graph.true[sorted(waiting)])
            if rng.random() < 0.5:
                waiting.remove(name)
            else:  # judged, and waits again for something dearer
                graph.true[name] += rng.random()
                source.put_back(float(graph.true[name]), (name, other))
            graph.learn()
        assert not np.isfinite(graph.true[sorted(waiting)]).any()


def test_no_sets() -> None:
    """Without sets there is nothing to wait for."""
    source = StartSets(iter(()), 0, None)  # type: ignore[arg-type]
    assert source.key() == math.inf


@given(st.lists(st.integers(0, 9), max_size=20), st.lists(st.integers(0, 9), max_size=20))
def test_merge(new: list[int], old: list[int]) -> None:
    """Merging keeps all, sorted, and says which are new."""
    new.sort()
    old.sort()
    K = len(new)
    keys = np.array([0.0] * K + [float(k) for k in old] + [np.inf])
    rows = np.array([[0]] * K + [[k] for k in old], dtype=np.int64).reshape(-1, 1)
    versions = np.zeros(len(rows), dtype=np.int64)
    fresh = np.array(new, dtype=np.int64).reshape(-1, 1)
    merge(fresh[:, 0].astype(float), fresh, 7, K, keys, rows, versions)
    assert keys[:-1].tolist() == sorted(new + old)
    assert rows[:, 0].tolist() == sorted(new + old)
    assert sorted(rows[versions == 7, 0].tolist()) == new


def test_parts_come_only_when_they_are_needed() -> None:
    """However many sets have equal keys, few are made at a time."""
    made = 0

    def endless() -> Iterator[Part]:
        nonlocal made
        while True:
            made += 1
            yield np.ones(3), np.full((3, 1), made)

    class Dearer:
        version = 0

        def keys(self, sets: IntArray, config: int) -> Array:  # noqa: ARG002
            return np.full(len(sets), 2.0)

    source = StartSets(endless(), 0, Dearer())  # type: ignore[arg-type]
    key, placements = source.take()
    source.judged(stale=True)
    source.put_back(2.0, placements)
    assert (key, made) == (1.0, 1)
    renewed = sum(source.renew() for _ in range(8))
    assert source.key() == 1.0
    assert made <= 1 + renewed
