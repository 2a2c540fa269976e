"""Poses and arcs of free motion as searches over (pose, set of placements) ask for them."""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.contact.lattice import ContactLattice
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.arc_classes import ArcClasses, arcs_leaving
from gm_ompl.graph.closure import firsts_of, lifts
from gm_ompl.graph.floor_bounds import FloorBounds
from gm_ompl.graph.kept_bounds import PlanarBounds
from gm_ompl.graph.kept_chords import chords, lines
from gm_ompl.graph.kept_room import NO_ROWS, columns_with_room, no_arcs
from gm_ompl.graph.kept_tables import (
    ASKED_FOR,
    BLOCKED,
    EMPTY,
    UNKNOWN,
    WANTED,
    BodyPoses,
    KeptArcs,
    Poses,
)
from gm_ompl.motion.arc import Moment
from gm_ompl.motion.free import FreeMotion

START: Final = 0
"""The node at the start."""


class TakenIn(NamedTuple):
    """How many of the lattice's poses, classes of arcs and forms were taken in."""

    poses: int
    kinds: int
    forms: int


@final
class KeptObject:
    """The object's poses, and the arcs between them.

    Args:
        judge: of a problem of free motion; its back end is the kernel's.
        planar: potentials, where they are told from a plane.
        floor: bounds on an open floor, where there are some.

    Attributes:
        poses: what compiled code goes by; another once it has grown. Poses have the numbers of the
            object's nodes.
        bodies: likewise.
        arcs: likewise.
    """

    def __init__(
        self, judge: Judge, planar: PlanarBounds | None, floor: FloorBounds | None
    ) -> None:
        problem = judge.problem
        motion, hand = problem.motion, problem.fingers
        assert isinstance(motion, FreeMotion)
        assert isinstance(problem.object_graph, ContactLattice)
        self._judge, self._graph, self._lifts = judge, problem.object_graph, lifts(problem)
        # With a hand each arc is a class of its own: its joints are asked for there.
        self._apart, self._ends = problem.hand is not None, motion.ends
        self._planar, self._floor = planar, floor
        fingers = list(firsts_of(hand.shapes).values())
        self._classes = ArcClasses(judge, problem.object_graph, fingers)
        self.poses = Poses(np.zeros((0, 5)), np.zeros(0, dtype=bool), *(NO_ROWS,) * 4)
        self.bodies = BodyPoses(*self._graph.bodies())
        self.arcs = no_arcs(len(fingers), len(hand.placements), problem.cost.samples_per_arc)
        self._taken_in = TakenIn(0, 0, 0)
        self._meet()
        self._see(np.array([START]))

    def __len__(self) -> int:
        return self._taken_in.poses

    @property
    def kinds(self) -> int:
        """How many classes of arcs were taken in."""
        return self._taken_in.kinds

    def prepare(self, of: IntArray) -> None:
        """Make the arcs that leave poses."""
        new = np.unique(of[self.poses.first[of] == EMPTY])
        if len(new):
            self._graph.leave(new.tolist())
            self._meet()
            first, past = self._graph.spans(new)
            leaving, _ = arcs_leaving(self._graph, new)
            self._form(leaving)
            arcs, poses = self.arcs, self.poses
            self._see(arcs.heads[leaving[arcs.stages[arcs.kinds[leaving]] != BLOCKED]])
            poses.first[new], poses.past[new] = first, past

    def learn(self) -> None:
        """Find what was asked for of classes of arcs."""
        wanted = np.flatnonzero(self.arcs.stages[: self._taken_in.kinds] == WANTED)
        first = wanted.tolist()
        if not self._apart:
            first = [self._graph.arcs.kind_arcs[kind] for kind in first]
        self._classes.learn(wanted, np.array(first, dtype=np.int64), self.arcs)

    def rest(self) -> None:
        """Find the contact states of the object at rest that were asked for."""
        rests = self.poses.rests
        for node in np.flatnonzero(rests[: self._taken_in.poses] == ASKED_FOR).tolist():
            rests[node] = self._judge.environment(Moment(self._graph.pose(node)))

    def _meet(self) -> None:
        """Take in the poses and arcs that the lattice has made."""
        graph, known = self._graph, self._taken_in
        new = np.arange(known.poses, len(graph))
        poses = columns_with_room(self.poses, len(graph))
        poses.places[new, 0] = np.nan
        poses.first[new] = poses.attitudes[new] = poses.rests[new] = EMPTY
        arcs, rows = self.arcs, graph.arcs.rows
        count = len(graph.arcs) if self._apart else len(graph.arcs.kind_arcs)
        fresh = np.arange(known.kinds, count)
        stages, free, states = columns_with_room((arcs.stages, arcs.free, arcs.states), count)
        firsts = fresh if self._apart else np.array(graph.arcs.kind_arcs[known.kinds :], np.int64)
        stages[fresh] = np.where(rows.bare[firsts] & (not self._lifts), BLOCKED, UNKNOWN)
        states[fresh] = -1
        kinds = np.arange(count) if self._apart else rows.kinds
        alike = arcs.lines, arcs.chords, stages, free, states
        self.poses, self.bodies = poses, BodyPoses(*graph.bodies())
        self.arcs = KeptArcs(rows.heads, rows.forms, kinds, *alike)
        self._taken_in = TakenIn(len(graph), count, known.forms)

    def _see(self, nodes: IntArray) -> None:
        """Find how far it is from poses to the goal, where that is not known."""
        poses, graph = self.poses, self._graph
        new = np.unique(nodes[np.isnan(poses.places[nodes, 0])])
        R, p = graph.poses(new)
        poses.goal[new] = graph.arrived(new)
        poses.places[new] = 0.0 if self._planar is None else self._planar.places(R, p)
        if self._floor is not None:
            poses.attitudes[new] = self._floor.attitudes(R, p)

    def _form(self, leaving: IntArray) -> None:
        """Find how far fingertips go along arcs."""
        graph, arcs, forms = self._graph, self.arcs, len(self._graph.arcs.form_arcs)
        lined, chorded = columns_with_room((arcs.lines, arcs.chords), forms)
        if forms > self._taken_in.forms:
            chorded[self._taken_in.forms : forms, 0] = np.nan
            self._taken_in = self._taken_in._replace(forms=forms)
        asked = np.unique(arcs.forms[leaving])
        new = asked[np.isnan(chorded[asked, 0])]
        courses = graph.courses(np.array(graph.arcs.form_arcs, np.int64)[new])
        chorded[new] = chords(courses, chorded.shape[1], ends=self._ends)
        lined[new] = lines(courses)
        self.arcs = arcs._replace(lines=lined, chords=chorded)
