"""Counts on swept tests: random motions and obstacles against 2,000 poses each."""

from __future__ import annotations

import numpy as np

from tests.geometry.test_swept import KINDS, object_case, tips_case
from tests.verify.counting import Result, count

POSES = 2000


@count(300)
def swept_object(instance: int) -> Result:
    """Objects along arcs: free, hit, or near (refused, yet no sample penetrates; within 1e-4)."""
    rng = np.random.default_rng([1, instance])
    try:
        return Result(True, outcome=object_case(rng, KINDS[instance % len(KINDS)], POSES))
    except AssertionError as error:
        return Result(False, note=f"instance {instance}: {error}")


@count(150)
def swept_fingertips(instance: int) -> Result:
    """Twenty fingertips along each arc: any near (refused within 1e-4 of clear), or none."""
    rng = np.random.default_rng([2, instance])
    try:
        seen = tips_case(rng, KINDS[instance % len(KINDS)], POSES)
    except AssertionError as error:
        return Result(False, note=f"instance {instance}: {error}")
    return Result(True, outcome="some near" if seen["near"] else "none near")
