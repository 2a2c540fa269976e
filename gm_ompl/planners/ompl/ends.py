"""Start and goal states of a user's own: taken where the scenario admits them, else refused."""

from __future__ import annotations

import sys
from typing import Any, Final

from gm_ompl.errors import InputError
from gm_ompl.planners.ompl.convert import Codec
from gm_ompl.sampling.motions import UNPLACED, HybridModel, HybridState

EXACTLY: Final = sys.float_info.epsilon
"""OMPL's own threshold of goal states."""


def given_start(codec: Codec, model: HybridModel, state: Any, asked: str) -> HybridState:
    """Return the start state that ``state`` means.

    Args:
        codec: what states mean.
        model: judges states.
        state: OMPL's.
        asked: the method that it was handed to, for the message.

    Raises:
        InputError: a plan of the scenario cannot begin there.
    """
    start = _read(codec, state, asked)
    wrong = why_no_start(model, start)
    if wrong is not None:
        raise InputError(f"{asked}: {wrong}")
    return HybridState(codec.start.q, start.placements)


def why_no_start(model: HybridModel, start: HybridState) -> str | None:
    """Return why a plan of the scenario cannot begin at ``start``, or None where it can."""
    hand = model.problem.fingers
    if not model.same(start.q, model.start):
        return (
            f"the object is at {list(start.q)}, but the scenario starts at {list(model.start)}; "
            "change motion.start in the scenario"
        )
    for finger, (have, want) in enumerate(zip(start.placements, hand.start, strict=True)):
        if want is not None and have != want:
            return (
                f"finger {finger} has {_named(have)}, but the scenario's fingers.start wants "
                f"{_named(want)}"
            )
    if not model.state_valid(model.start, start.placements):
        return f"placements {list(start.placements)} penetrate something"
    if UNPLACED not in start.placements and not model.lands(start.placements):
        return f"the fingers cannot come to placements {list(start.placements)} through the air"
    return None


def given_goal(codec: Codec, model: HybridModel, state: Any, asked: str) -> HybridState:
    """Return the goal state that ``state`` means.

    Args:
        codec: what states mean.
        model: judges states.
        state: OMPL's.
        asked: the method that it was handed to, for the message.

    Raises:
        InputError: a plan of the scenario cannot end there.
    """
    goal, hand = _read(codec, state, asked), model.problem.fingers
    if not model.arrived(goal.q):
        raise InputError(
            f"{asked}: the object at {list(goal.q)} is not in the scenario's goal; change "
            "motion.goal (or motion.path) in the scenario"
        )
    for finger, (have, want) in enumerate(zip(goal.placements, hand.goal, strict=True)):
        if have == UNPLACED or (want is not None and have != want):
            wanted = "a placement" if want is None else f"{_named(want)} (fingers.goal)"
            raise InputError(f"{asked}: finger {finger} has {_named(have)}, but needs {wanted}")
    if not model.state_valid(goal.q, goal.placements):
        raise InputError(f"{asked}: placements {list(goal.placements)} penetrate something")
    if not model.leaves(goal):
        raise InputError(f"{asked}: the fingers cannot leave the object there (fingers.leave)")
    return goal


def _read(codec: Codec, state: Any, asked: str) -> HybridState:
    """Return what a state means; its placements are rows of the table."""
    meaning = codec.read(state)
    rows = len(codec.problem.fingers.placements)
    for finger, row in enumerate(meaning.placements):
        if not UNPLACED <= row < rows:
            raise InputError(
                f"{asked}: finger {finger} has placement {row - UNPLACED}: must be 0 (not placed "
                f"yet) to {rows}"
            )
    return meaning


def _named(row: int) -> str:
    return "no placement" if row == UNPLACED else f"placement {row - UNPLACED}"
