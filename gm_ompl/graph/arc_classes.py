"""What is free along classes of arcs that are alike, and their contact states: many at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.contact.lattice import ContactLattice
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.kept_tables import BLOCKED, READY, KeptArcs
from gm_ompl.motion.object_graph import GraphArc


@final
class ArcClasses:
    """Finds what the search for plans that keep the whole hand asks of classes of arcs.

    Args:
        judge: answers about the problem; its back end is the kernel's.
        graph: the problem's.
        fingers: one of each shape.
    """

    def __init__(self, judge: Judge, graph: ContactLattice, fingers: Sequence[int]) -> None:
        self._judge, self._graph, self._fingers = judge, graph, list(fingers)

    def learn(self, kinds: IntArray, which: IntArray, arcs: KeptArcs) -> None:
        """Write where the fingertips are free along classes of arcs, and the contact states.

        Args:
            kinds: (m,), the classes.
            which: (m,), an arc of each.
            arcs: where it is written.
        """
        if self._judge.hand is None:
            self._learn_at_once(kinds, which, arcs)
            return
        for kind, arc in zip(kinds.tolist(), which.tolist(), strict=True):
            step = self._graph.arc(arc)
            found = self._judge.passing(step, self._graph.pose(step.head))
            arcs.free[kind] = [found.free[i] for i in self._fingers]
            passes = found.object_free and bool(arcs.free[kind].any(axis=1).all())
            if passes:
                self._write_states(kind, step, arcs)
            arcs.stages[kind] = READY if passes else BLOCKED

    def _learn_at_once(self, kinds: IntArray, which: IntArray, arcs: KeptArcs) -> None:
        screws, backend = self._graph.courses(which), self._judge.backend
        assert isinstance(backend, KernelBackend)
        object_free, free = self._judge.passing_along(screws)
        arcs.free[kinds] = free[:, self._fingers]
        passes = object_free & np.all(np.any(arcs.free[kinds], axis=2), axis=1)
        (rows,) = np.nonzero(passes)
        states = backend.along(screws.some(rows))
        arcs.states[kinds[rows], : states.shape[1]] = states
        for k in rows[states.max(axis=1, initial=-1) < 0].tolist():
            self._write_states(int(kinds[k]), self._graph.arc(int(which[k])), arcs)
        # Last: a limit may be reached before, and the search gone on with.
        arcs.stages[kinds] = np.where(passes, READY, BLOCKED)

    def _write_states(self, kind: int, step: GraphArc, arcs: KeptArcs) -> None:
        states = self._judge.environments(step)
        arcs.states[kind, : len(states)] = states


def arcs_leaving(graph: ContactLattice, nodes: IntArray) -> tuple[IntArray, IntArray]:
    """Return the arcs that leave nodes (N,), one node after the other, and which row each leaves.

    They must have been made.
    """
    first, past = graph.spans(nodes)
    arcs = [np.arange(a, b) for a, b in zip(first, past, strict=True)]
    return np.concatenate([*arcs, first[:0]]), np.repeat(np.arange(len(nodes)), past - first)
