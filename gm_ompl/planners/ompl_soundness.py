"""Which of OMPL's planners respect that motions are one-way, and why the others do not."""

from __future__ import annotations

from typing import Any

from gm_ompl.errors import UnsoundPlannerError

_ROADMAP = "its roadmap is undirected: a motion checked in one direction is used in both"
_BACKWARDS = "its goal tree checks motions from the goal outwards, against their execution"

UNSOUND = {
    "PRM": _ROADMAP,
    "PRMstar": _ROADMAP,
    "BFMT": _BACKWARDS,
    "BKPIECE1": _BACKWARDS,
    "LBKPIECE1": _BACKWARDS,
    "AORRTC": "it samples its trees anew without asking on which side a motion lies",
}
"""OMPL's planners that are unsound for one-way motion, with the reason."""

_REVERSED = (
    "with delayed collision checking off (setDelayCC(False)) it takes the reverse direction's "
    "validity for a motion's; leave it on"
)
_UNCHECKED = (
    "with intermediate states on it keeps states that OMPL interpolates, and no one checks the "
    "motions between them; leave them off"
)


def reason_unsound(planner: Any) -> str | None:
    """Return why an OMPL planner object is unsound as it is set up, or None."""
    from ompl import geometric as og

    for name, reason in UNSOUND.items():
        if isinstance(planner, getattr(og, name)):
            return reason
    if isinstance(planner, og.RRTstar) and not planner.getDelayCC():
        return _REVERSED
    if isinstance(planner, (og.RRT, og.RRTConnect)) and planner.getIntermediateStates():
        return _UNCHECKED
    return None


def refuse_unsound(planner: Any) -> None:
    """Refuse an OMPL planner object that is unsound for one-way motion.

    Raises:
        UnsoundPlannerError: it is; the message says why.
    """
    reason = reason_unsound(planner)
    if reason is not None:
        raise UnsoundPlannerError(type(planner).__name__, reason)
