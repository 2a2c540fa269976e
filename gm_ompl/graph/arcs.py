"""The object's part of displacement arcs: what all placement sets share."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.caches import Memo
from gm_ompl.feasibility.judge import Judge
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.problem import Placements

USUAL = 8
"""Arcs that leave a node of free motion, about."""


@dataclass(frozen=True, eq=False)
class ObjectArc:
    """One arc of the object graph, divided into segments (Sec. 4.2).

    Attributes:
        environments: per segment, the back end's number of the contact state.
        states: the different ones among them.
        free: per finger, per placement: whether it is free all along the arc.
        lengths: per finger, (placements, segments), |dq_finger i,j| of Eq. (9).
        travel: per finger, per placement: their sum over the segments.
    """

    environments: tuple[int, ...]
    states: tuple[int, ...]
    free: tuple[Sequence[bool], ...]
    lengths: tuple[Array, ...]
    travel: tuple[Sequence[float], ...]

    def admits(self, placements: Placements) -> bool:
        """Whether no fingertip penetrates the environment along the arc."""
        for mask, row in zip(self.free, placements, strict=True):  # noqa: SIM110 (twice as fast)
            if not mask[row]:
                return False
        return True

    def finger_lengths(self, placements: Placements) -> list[list[float]]:
        """Return per finger, per segment, |dq_finger i,j|."""
        return [table[row].tolist() for table, row in zip(self.lengths, placements, strict=True)]

    def lengths_by_state(self, placements: Placements) -> list[list[float]]:
        """Return per finger the lengths of its segments, summed over equal contact states."""
        if len(self.states) == len(self.environments):
            return self.finger_lengths(placements)
        totals = []
        for lengths in self.finger_lengths(placements):
            total = dict.fromkeys(self.states, 0.0)
            for state, length in zip(self.environments, lengths, strict=True):
                total[state] += length
            totals.append(list(total.values()))
        return totals

    def least_cost(self, placements: Placements) -> float:
        """Return Eq. (9) for z = +inf."""
        return max([t[row] for t, row in zip(self.travel, placements, strict=True)])


@final
class ObjectArcs:
    """Arcs of the object graph, made on demand; those the object cannot take are left out."""

    def __init__(self, judge: Judge) -> None:
        problem = judge.problem
        self._graph, self._judge = problem.object_graph, judge
        radii = len(set(problem.fingers.shapes))
        numbers = 8 * (problem.cost.samples_per_arc + 1) + 32  # 32: a float and its place in a list
        each = len(problem.fingers.placements) * radii * numbers + 2000
        leaving = 2 * problem.motion.dimension or USUAL
        self._known = Memo[int, Mapping[int, ObjectArc]](each * leaving)
        self._kinds = Memo[Hashable, ObjectArc | None](each)

    def leaving(self, config: int) -> Mapping[int, ObjectArc]:
        """Return the arcs from the object's node ``config`` by their heads."""
        known = self._known.get(config)
        if known is None:
            made = {step.head: self._alike(step) for step in self._graph.arcs_from(config)}
            known = self._known[config] = {h: arc for h, arc in made.items() if arc is not None}
        return known

    def _alike(self, step: GraphArc) -> ObjectArc | None:
        """Return an arc, made once for all of its kind."""
        if step.kind is None or self._judge.problem.hand is not None:
            return self._make(step)
        if step.kind not in self._kinds:
            self._kinds[step.kind] = self._make(step)
        return self._kinds[step.kind]

    def _make(self, step: GraphArc) -> ObjectArc | None:
        judge = self._judge
        places = judge.along(step.arc)
        # The node's own pose, not the arc's end, which may be unwrapped: it is judged once.
        node = judge.node(self._graph.pose(step.head))
        if not (places.object_free and node.object_free):
            return None
        radii = judge.problem.fingers.shapes
        lengths: dict[tuple[float, int], Array] = {}
        free: dict[tuple[float, int], list[bool]] = {}
        for i, radius in enumerate(radii):
            if radius not in lengths:
                lengths[radius] = np.ascontiguousarray(step.lengths(judge.centres(i)))
                free[radius] = (places.free[i] & node.free[i]).tolist()
        travel = {radius: table.sum(axis=1).tolist() for radius, table in lengths.items()}
        environments = judge.environments(step)
        return ObjectArc(
            environments=environments,
            states=tuple(dict.fromkeys(environments)),
            free=tuple(free[r] for r in radii),
            lengths=tuple(lengths[r] for r in radii),
            travel=tuple(travel[r] for r in radii),
        )
