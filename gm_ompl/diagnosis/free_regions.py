"""Free motion: what one set of placements reaches on the contact lattice without regrasping."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TypeAlias, final

import numpy as np

from gm_ompl.contact.deeds import doing
from gm_ompl.diagnosis.instants import Explainer
from gm_ompl.diagnosis.roaming import Refusal, place_of, refusal
from gm_ompl.diagnosis.values import InstantLine
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.motion.arc import Moment
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.motion.screw import Screw
from gm_ompl.planfile.words import screw_in_words
from gm_ompl.problem import Placements, Problem

NODES = 1500
"""Poses visited per set."""

Leaving: TypeAlias = Callable[[int], Iterable[tuple[int, GraphArc]]]
"""The arcs at a node, each with the node at its other end."""


@final
class FreeRegion:
    """What one set of placements reaches on the contact lattice without regrasping.

    Args:
        explainer: of the problem.
        placements: per finger.
        sources: nodes where it begins.
        leaving: the arcs that are looked at.
        off: how far a node is from the other end; 0: it has arrived.

    Attributes:
        nodes: those visited.
        nearest: least ``off`` of them; +inf where there is none.
        cut_short: whether the visit stopped at ``NODES``, or was stopped.
    """

    def __init__(
        self,
        explainer: Explainer,
        placements: Placements,
        sources: Sequence[int],
        leaving: Leaving,
        off: Callable[[int], float],
    ) -> None:
        self._explainer, self._placements, self._off = explainer, placements, off
        graph, judge = explainer.problem.object_graph, explainer.judge
        self._blocked: tuple[float, Refusal, GraphArc | None] | None = None
        self.nodes = set[int]()
        for node in sources:
            if judge.placements_valid(graph.pose(node), placements):
                self.nodes.add(node)
            else:
                self._note(node, Refusal(Moment(graph.pose(node)), Verdict(Finding.GEOMETRY)), None)
        queue = deque(self.nodes)
        while queue and len(self.nodes) < NODES and not explainer.stop():
            for other, arc in leaving(queue.popleft()):
                if other in self.nodes:
                    continue
                refused = refusal(explainer, arc, placements)
                if refused is None:
                    self.nodes.add(other)
                    queue.append(other)
                else:
                    self._note(other, refused, arc)
        self.nearest = min(map(off, self.nodes), default=np.inf)
        self.cut_short = bool(queue)

    def _note(self, node: int, refused: Refusal, arc: GraphArc | None) -> None:
        off = self._off(node)
        if self._blocked is None or off < self._blocked[0]:
            self._blocked = off, refused, arc

    @property
    def arrived(self) -> bool:
        """Whether the other end was reached."""
        return self.nearest == 0.0

    def failure(self) -> InstantLine | None:
        """Return what blocks the arc nearest to the other end; None where that was reached."""
        if self.arrived or self._blocked is None:
            return None
        _, (moment, verdict), arc = self._blocked
        problem, placements = self._explainer.problem, self._placements
        if verdict.decision is not None:  # its margin was not needed exactly
            verdict = self._explainer.judge.segment(moment, placements)
        line = self._explainer.at(moment.pose, placements, verdict)
        return replace(line, place=place_of(problem, moment.pose), moving=_moving(problem, arc))


def _moving(problem: Problem, arc: GraphArc | None) -> str | None:
    if arc is None or not isinstance(arc.arc, Screw):
        return None
    return screw_in_words(arc.arc, doing(arc.arc, problem.body, problem.environment))
