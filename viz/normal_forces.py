"""Which normal forces the fingers may exert: statics leaves a range under position control."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from scipy import sparse

from gm_ompl.arrays import Array
from gm_ompl.contact.state import Instant
from gm_ompl.reference import highs
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.statics import Statics, statics

from .story import Beat, Story

SLACK: Final = 1e-7
"""How far f_com, rounded in a plan file, may be missed, in units of the object's weight."""


def normal_force_ranges(story: Story, beat: Beat) -> Array:
    """Return the least and greatest normal force of each finger in equilibrium, (n, 2).

    Eq. (3) without disturbance, at the middle of ``beat``, friction cones and limits kept and
    commanded forces met. A lifted finger, and every finger where there is no equilibrium, has
    NaN.
    """
    hand = [i for i, mode in enumerate(beat.modes) if mode != "L"]
    ranges = np.full((story.problem.fingers.count, 2), np.nan)
    if not hand:
        return ranges
    model = statics(_instant(story, beat, hand))
    commanded = [beat.f_com[i] for i in hand]
    for row, i in enumerate(hand):
        for side, maximise in enumerate((False, True)):
            found = highs.solve(normal_force_program(model, commanded, row, maximise))
            if found.status is LpStatus.OPTIMAL:
                ranges[i, side] = found.objective * model.scale
    return ranges


def normal_force_program(
    model: Statics, commanded: list[float | None], finger: int, maximise: bool
) -> LinearProgram:
    """Build: the least (or greatest) normal force of ``finger``, over k_env and k_rob.

    Args:
        model: the statics, forces in units of ``model.scale``.
        commanded: per finger, f_com; None under position control.
        finger: whose normal force.
        maximise: whether to find the greatest.
    """
    wrenches = np.hstack([model.env_wrenches, model.rob_wrenches])
    padding = np.zeros((model.fingers, model.env_wrenches.shape[1]))
    normal = np.hstack([padding, model.normal_parts])
    f = [None if force is None else force / model.scale for force in commanded]
    least = [0.0 if force is None else force - SLACK for force in f]
    most = [m if force is None else force + SLACK for force, m in zip(f, model.f_max, strict=True)]
    columns = wrenches.shape[1]
    return LinearProgram(
        cost=normal[finger],
        matrix=sparse.csc_array(np.vstack([wrenches, normal])),
        row_lower=np.concatenate([-model.load, least]),
        row_upper=np.concatenate([-model.load, most]),
        col_lower=np.zeros(columns),
        col_upper=np.full(columns, np.inf),
        maximise=maximise,
    )


def _instant(story: Story, beat: Beat, hand: list[int]) -> Instant:
    return replace(
        story.problem.instant(beat.contacts, tuple(hand), (0,) * len(hand)),
        points=np.array([beat.placements[i].point for i in hand]),
        normals=np.array([beat.placements[i].normal for i in hand]),
    )
