"""The manipulation-feasibility graph of Sec. 4.2, its nodes and arcs made on demand.

A node is a placement set at a node of the object graph, numbered set * 2^63 + that node.
Regrasping passes through hubs: the set with one finger LIFTED costs X_regr to enter, if the rest of
the hand holds the object at rest, and nothing to leave to any free placement. Paths have the costs
they have with the paper's arcs from placement to placement.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import final

import numpy as np

from gm_ompl import limits
from gm_ompl.contact.decision import ModeDecision
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.arcs import ObjectArc, ObjectArcs
from gm_ompl.graph.heuristic import Heuristic
from gm_ompl.holds.cost import displacement_cost, stability_factor
from gm_ompl.holds.extraction import Leg, merged
from gm_ompl.holds.goals import fits, restricted
from gm_ompl.holds.sets import LIFTED, PlacementSets, beside, ordered_sets, staying_of
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Placements

BITS = 63
"""Of a node's number, those that are the object's node."""

OBJECT = (1 << BITS) - 1


@final
class FeasibilityGraph:
    """The graph as best-first search sees it.

    Args:
        judge: of the problem.
        heuristic: a lower bound on the cost to the goal.

    Attributes:
        sets: the placement sets met so far.
        arcs_of_object: displacement arcs, without the hand.
    """

    def __init__(self, judge: Judge, heuristic: Heuristic) -> None:
        problem = judge.problem
        self._problem, self._judge, self._heuristic = problem, judge, heuristic
        self._objects = problem.object_graph
        self._z_min = problem.mechanics.z_min
        self._X_stab, self._X_regr = problem.cost.stability, problem.cost.regrasp
        self._z_floor = problem.z_floor
        self._fingers = tuple(range(problem.fingers.count))
        self._rests: dict[int, int] = {}
        self._reach = judge.reach
        self.sets = PlacementSets(problem.fingers.groups())
        self.arcs_of_object = ObjectArcs(judge)

    def legs(self, path: Sequence[int]) -> tuple[list[int], list[Leg]]:
        """Return the object's nodes along a path, and the legs between its regrasps."""
        nodes: list[int] = []
        legs: list[Leg] = []
        for config, placements in map(self.parts, path):
            if not nodes or nodes[-1] != config:
                nodes.append(config)
            if LIFTED not in placements:
                legs.append((placements, len(nodes) - 1, len(nodes) - 1))
        return nodes, merged(legs)

    def node(self, config: int, canonical: Placements) -> int:
        """Return the number of the node with this object node and canonical set."""
        return self.sets.number(canonical) << BITS | config

    def parts(self, node: int) -> tuple[int, Placements]:
        """Return the object's node and the canonical set of ``node``."""
        return node & OBJECT, self.sets.placements(node >> BITS)[: len(self._fingers)]

    def _origin(self, hub: int) -> int | None:
        """Return the placement in a pocket that alone leads to a hub; None: it is outside."""
        return next(iter(self.sets.placements(hub >> BITS)[len(self._fingers) :]), None)

    def sources(self) -> Iterator[tuple[float, int]]:
        """Yield (bound, node) of all start nodes; bounds on the estimates do not decrease."""
        start = self._objects.start
        geometry = self._judge.node(self._objects.pose(start))
        allowed = restricted(geometry.free, self._problem.fingers.start)
        keys = self._heuristic.finger_estimates(start)
        for bound, placements in ordered_sets(self.sets.groups, allowed, keys, self._judge.clear):
            yield bound, self.node(start, placements)

    def estimate(self, node: int) -> float:
        """Return a lower bound on the cost from ``node`` to the goal."""
        config, placements = self.parts(node)
        return self._heuristic.estimate(config, placements)

    def is_goal(self, node: int) -> bool:
        """Whether ``node`` is joined to the virtual goal node."""
        config, placements = self.parts(node)
        if LIFTED in placements or not self._objects.in_goal(config):
            return False
        hand = self._problem.fingers
        if not fits(placements, hand.goal):
            return False
        pose = self._objects.pose(config)
        return not hand.leave or self._reach.landing(pose, placements) is not None

    def arcs(self, node: int) -> Iterator[tuple[int, float, bool]]:
        """Yield (head, least cost, exact): displacement arcs, or from a hub to all placements.

        A cost that is not exact is a lower bound, and the arc is still to be judged.
        """
        config, placements = self.parts(node)
        if LIFTED in placements:
            yield from self._touching_down(node)
            return
        first = node - config
        for head, arc in self.arcs_of_object.leaving(config).items():
            if arc.admits(placements):
                yield first + head, arc.least_cost(placements), False

    def late_arcs(self, node: int) -> Iterator[tuple[int, float, bool]]:
        """Yield (head, X_regr, False) of the arcs that lift a finger.

        A finger that is in a pocket leads to a hub of its own: what it reaches is in the pocket.
        """
        config, placements = self.parts(node)
        for hub, row in zip(self.sets.hubs(placements), placements, strict=True):
            if not self._rest_bound(config, hub) >= self._z_min:
                continue  # nobody is lifted there, wherever it would get to
            outside = not self._reach.active or self._reach.outside(
                self._objects.pose(config), hub.index(LIFTED), staying_of(hub), row
            )
            yield self.node(config, hub if outside else (*hub, row)), self._X_regr, False

    def late_bound(self, node: int) -> float:
        """Return a lower bound on the cost to the goal if a finger is lifted next."""
        _, placements = self.parts(node)
        return math.inf if LIFTED in placements else max(self._X_regr, self.estimate(node))

    def optimistic(self, tail: int, head: int) -> float:
        """Return the present lower bound on an arc's cost; +inf where it cannot hold."""
        config, placements = self.parts(tail)
        end, after = self.parts(head)
        if LIFTED in placements:
            return 0.0
        if config == end:
            return self._X_regr if self._rest_bound(config, after) >= self._z_min else math.inf
        return self._bounded_cost(self.arcs_of_object.leaving(config)[end], placements)

    def judge(self, tail: int, head: int) -> float:
        """Return an arc's cost, (9) or (10); +inf where it is not feasible."""
        config, placements = self.parts(tail)
        end, after = self.parts(head)
        if LIFTED in placements:
            return 0.0 if self._lands(tail, after) else math.inf
        if config == end:
            return self._X_regr if self.rest(config, after).z >= self._z_min else math.inf
        arc = self.arcs_of_object.leaving(config)[end]
        decide = self._judge.backend.decide
        z = []
        for environment in arc.states:
            limits.check()
            z.append(decide(environment, self._fingers, placements, self._z_min).z)
            if not z[-1] >= self._z_min:
                return math.inf
        return self._cost(arc, placements, z)

    def rest(self, config: int, hub: Placements) -> ModeDecision:
        """Return the decision for the fingers that touch, the object at rest.

        Where z is below z_min, the decision may say no more than that.
        """
        fingers = tuple(i for i, row in enumerate(hub) if row != LIFTED)
        pose = self._objects.pose(config)
        return self._judge.rest(pose, fingers, tuple(hub[i] for i in fingers), self._z_min)

    def _rest_bound(self, config: int, hub: Placements) -> float:
        environment = self._rests.get(config)
        if environment is None:
            moment = Moment(self._objects.pose(config))
            environment = self._rests[config] = self._judge.environment(moment)
        fingers = tuple(i for i, row in enumerate(hub) if row != LIFTED)
        rows = tuple(hub[i] for i in fingers)
        return self._judge.backend.bound(environment, fingers, rows)

    def _bounded_cost(self, arc: ObjectArc, placements: Placements) -> float:
        bound = self._judge.backend.bound
        z = []
        for environment in arc.states:
            z.append(bound(environment, self._fingers, placements))
            if not z[-1] >= self._z_min:
                return math.inf
        return self._cost(arc, placements, z)

    def _cost(self, arc: ObjectArc, placements: Placements, z: Sequence[float]) -> float:
        """Return Eq. (9), ``z`` per contact state of the arc."""
        if len(z) == 1:
            factor = stability_factor(z[0], self._X_stab, self._z_floor)
            return factor * arc.least_cost(placements)
        lengths = arc.lengths_by_state(placements)
        return displacement_cost(lengths, z, self._X_stab, self._z_floor)

    def starts_at(self, node: int) -> bool:
        """Whether the fingers can touch the object at a start node, one after the other."""
        config, placements = self.parts(node)
        pose, standing = self._objects.pose(config), self._problem.fingers.standing
        return self._reach.landing(pose, placements, standing) is not None

    def _lands(self, node: int, after: Placements) -> bool:
        """Whether the finger lifted at a hub gets to where it is in ``after``."""
        config, hub = self.parts(node)
        (row,) = (Counter(after) - Counter(hub)).elements()
        pose, slot, staying = self._objects.pose(config), hub.index(LIFTED), staying_of(hub)
        origin = self._origin(node)
        if origin is None:
            return self._reach.outside(pose, slot, staying, row)
        return self._reach.joined(pose, slot, staying, origin, row)

    def _touching_down(self, node: int) -> Iterator[tuple[int, float, bool]]:
        """Yield the arcs from a hub: the lifted finger to every free placement."""
        config, hub = self.parts(node)
        slot, pose = hub.index(LIFTED), self._objects.pose(config)
        free = self._judge.node(pose).free[slot] & beside(hub, self._judge.clear)
        sure = np.ones(len(free), dtype=bool)
        if self._reach.active:
            sure = self._reach.at_once(pose, slot, staying_of(hub))
            sure = sure & (self._origin(node) is None)
        for row in np.flatnonzero(free).tolist():
            yield self.node(config, self.sets.replaced(hub, slot, row)), 0.0, bool(sure[row])
