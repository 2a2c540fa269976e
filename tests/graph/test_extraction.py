"""Physical fingers and unwrapped coordinates along a path of the graph."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gm_ompl.arrays import read_only
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.reference_backend import ReferenceBackend
from gm_ompl.graph.arcs import ObjectArcs
from gm_ompl.graph.extraction import ObjectTrack, PhysicalHand
from gm_ompl.graph.sets import LIFTED, PlacementSets
from gm_ompl.motion.lattice import Lattice
from gm_ompl.motion.planar import PlanarMotion
from gm_ompl.scenario.load import load


def test_random_regrasps_are_attributed_to_one_finger() -> None:
    """However sets are reordered, exactly the lifted physical finger changes its placement."""
    rng = np.random.default_rng(0)
    groups = ((0, 2, 3), (1,))
    sets = PlacementSets(groups)
    canonical = sets.canonical((5, 1, 3, 8))
    hand = PhysicalHand(groups, canonical)
    for _ in range(200):
        slot = int(rng.integers(4))
        hub = sets.replaced(canonical, slot, LIFTED)
        row = int(rng.choice([p for p in range(12) if p not in hub]))
        after = sets.replaced(hub, hub.index(LIFTED), row)
        before = hand.placements
        if after != canonical:
            finger, target = hand.regrasped(hub, after)
            assert before[finger] == canonical[slot]
            assert target == row
            hand.move(finger, target)
            assert sum(a != b for a, b in zip(before, hand.placements, strict=True)) == 1
        canonical = after
        assert sets.canonical(hand.placements) == canonical
        for i in range(4):
            assert canonical[hand.slot(i, canonical)] == hand.placements[i]


def test_yaw_is_unwrapped() -> None:
    """Turning on and on, the coordinates grow steadily though lattice nodes wrap."""
    problem = load("paper/slide", ["fingers.placements.grid=[1, 1]"]).problem
    step = math.pi / 2
    yaws = [k * step for k in range(4)]
    axes = tuple(read_only(values, (None,), "axis") for values in ([0.0], [0.0], yaws))
    problem = dataclasses.replace(
        problem,
        motion=PlanarMotion((-1, -1, 0), (1, 1, 2 * math.pi), 2.5),
        lattice=Lattice(axes, (None, None, 2 * math.pi)),
        start=(0.0, 0.0, 2 * math.pi),
    )
    arcs = ObjectArcs(problem, Judge(problem, ReferenceBackend(problem)))
    track = ObjectTrack(problem, 0)
    assert track.q == pytest.approx((0.0, 0.0, 2 * math.pi))
    for k in range(9):
        arc = arcs.leaving(k % 4)[(k + 1) % 4]
        assert np.subtract(arc.end, arc.start) == pytest.approx((0.0, 0.0, step))
        track.advance(arc)
        assert track.q == pytest.approx((0.0, 0.0, 2 * math.pi + (k + 1) * step))
