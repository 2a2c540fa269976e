"""Physical fingers along a path of the graph."""

from __future__ import annotations

import numpy as np

from gm_ompl.holds.extraction import PhysicalHand
from gm_ompl.holds.sets import LIFTED, PlacementSets


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
