"""Ways through the air, as the search over lanes asks for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.reach import Staying
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph.lane import Hub, Lane
from gm_ompl.problem import Placements, Problem


@final
class LaneAir:
    """Answers at the nodes of one lane graph.

    Args:
        problem: the problem.
        judge: answers about it.
        nodes: the object graph's, by their numbers here.
        node_free: (n, placements, V), whether fingertips are free at the nodes.

    Attributes:
        landing: (n, placements, V), where a finger can be lifted or set down, as far as known.
        learnt: nodes whose pockets are left out of it.
    """

    def __init__(
        self, problem: Problem, judge: Judge, nodes: Sequence[int], node_free: BoolArray
    ) -> None:
        self._problem, self._judge, self._nodes = problem, judge, nodes
        self._node_free = self.landing = node_free
        self.learnt = set[int]()
        self._start = problem.object_graph.pose(problem.object_graph.start)
        self._landed: dict[Placements, bool] = {}
        self._outside: dict[tuple[int, Staying, int, int], bool] = {}

    def is_outside(self, hub: Hub, node: int, row: int) -> bool:
        """Whether the lifted finger of a hub can get from a placement to outside all pockets."""
        reach = self._judge.reach
        if not reach.active:
            return True
        key = hub.slot, hub.staying, node, row
        known = self._outside.get(key)
        if known is None:
            known = reach.outside(self._pose(node), hub.slot, hub.staying, row)
            self._outside[key] = known
        return known

    def joined(self, hub: Hub, node: int, a: int, b: int) -> bool:
        """Whether the lifted finger of a hub gets from one placement to another at a node."""
        return self._judge.reach.joined(self._pose(node), hub.slot, hub.staying, a, b)

    def lands(self, placements: Placements) -> bool:
        """Whether the fingers of a set can touch the object at the start, one after the other."""
        known = self._landed.get(placements)
        if known is None:
            hand, reach = self._problem.fingers, self._judge.reach
            order = reach.landing(self._start, placements, hand.standing)
            known = self._landed[placements] = order is not None
        return known

    def leaves(self, lane: Lane, node: int) -> bool:
        """Whether the fingers of a lane can leave the object at a goal node, where they must."""
        hand, reach = self._problem.fingers, self._judge.reach
        return not hand.leave or reach.landing(self._pose(node), lane.placements) is not None

    def _pose(self, node: int) -> Pose:
        return self._problem.object_graph.pose(self._nodes[node])

    def doubtful(self, hub: Hub, node: int) -> BoolArray | None:
        """Return which rows (P,) of the lifted finger may be in pockets; None where none may."""
        reach = self._judge.reach
        if not reach.active:
            return None
        doubt: BoolArray = ~reach.at_once(self._pose(node), hub.slot, hub.staying)
        doubt &= self._node_free[hub.slot, :, node]
        return doubt if doubt.any() else None

    def mind_pockets(self, lane: Lane, slot: int, hub: Hub, G: Array) -> None:
        """Let the finger at ``slot`` be lifted where it leads to placements not reached yet."""
        row = int(lane.rows[slot])
        for node, doubtful in hub.doubtful.items():
            if doubtful[row] and not self.is_outside(hub, node, row):
                G[node] = np.inf
        if lane.shut is not None:
            np.minimum(G, lane.shut[slot], out=G)

    def learn(self, node: int) -> bool:
        """Leave out of ``landing`` what is in a pocket at a node; whether that was not done yet."""
        if node in self.learnt:
            return False
        if not self.learnt:
            self.landing = self.landing.copy()
        self.learnt.add(node)
        for i in range(self._problem.fingers.count):
            rows = np.flatnonzero(self.landing[i, :, node])
            self.landing[i, rows, node] = self._judge.reach.regraspable(self._pose(node), i, rows)
        return True
