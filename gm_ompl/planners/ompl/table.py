"""OMPL's planners by their OMPL names: those offered, and why the others are not sound."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

from gm_ompl.errors import UnsoundPlannerError
from gm_ompl.planners.parameters import Parameter

RANGE = Parameter(
    "range_share",
    float,
    1.0,
    "Longest motion tried, as a share of the space's extent. Below 1, motions end at states "
    "between two others, whose placements lie between theirs in the placement table.",
    low=0.001,
    high=1.0,
    logarithmic=True,
)
GOAL_BIAS = Parameter(
    "goal_bias", float, 0.05, "How often a goal state is drawn.", low=0.0, high=1.0
)
GUIDED = Parameter(
    "guided_share",
    float,
    0.0,
    "How often a state is drawn that is valid by itself and leans to placements that have held, "
    "instead of a uniform one.",
    low=0.0,
    high=1.0,
)
FIRST_PLAN = Parameter("first_plan", bool, False, "Stop at the first plan instead of improving it.")
GOAL_STATES = Parameter(
    "goal_states", int, 100, "Goal states that are drawn.", low=1, high=100_000, logarithmic=True
)
SAMPLES = Parameter(
    "samples", int, 100, "States drawn at a time.", low=1, high=1_000_000, logarithmic=True
)
SHORTCUTS = Parameter(
    "shortcuts", bool, True, "Replace the path found by the cheapest one through its own states."
)
# BITstar and FMT compare every state with every goal state and with all its neighbours.
FEW_GOAL_STATES = replace(GOAL_STATES, default=10)


@dataclass(frozen=True)
class Offer:
    """One of OMPL's planners that is sound for one-way motion.

    Attributes:
        meaning: what it does, in a sentence.
        parameters: what may be set.
        anytime: whether it improves its plan.
    """

    meaning: str
    parameters: tuple[Parameter, ...]
    anytime: bool = False


_STAR: Final = (RANGE, GOAL_BIAS, GUIDED, FIRST_PLAN, SHORTCUTS)

OMPL_PLANNERS: Final[dict[str, Offer]] = {
    "RRT": Offer("A tree from the start.", (RANGE, GOAL_BIAS, GUIDED, SHORTCUTS)),
    "RRTConnect": Offer(
        "Two trees; the goal's is judged in the direction of execution.",
        (RANGE, GOAL_STATES, SHORTCUTS),
    ),
    "RRTstar": Offer("A tree from the start that is rewired towards the optimum.", _STAR, True),
    "InformedRRTstar": Offer(
        "RRTstar that draws only states that could improve the plan.", _STAR, True
    ),
    "SORRTstar": Offer("InformedRRTstar that draws in order of promise.", _STAR, True),
    "BITstar": Offer(
        "A heuristic search over batches of states.",
        (SAMPLES, FEW_GOAL_STATES, FIRST_PLAN, SHORTCUTS),
        True,
    ),
    "FMT": Offer("One pass over a given number of states.", (SAMPLES, FEW_GOAL_STATES, SHORTCUTS)),
    # OMPL draws near known states, where the placements hardly ever change: hence the guide.
    "KPIECE1": Offer(
        "A tree that spreads over the object's coordinates.",
        (RANGE, GOAL_BIAS, replace(GUIDED, default=0.8), SHORTCUTS),
    ),
}

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
