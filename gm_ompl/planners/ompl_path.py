"""Between a path of hybrid states and the moves of a plan."""

from __future__ import annotations

from collections.abc import Sequence

from gm_ompl.errors import PathError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.moves import Displacement, Move
from gm_ompl.problem import Problem
from gm_ompl.sampling.motions import ContinuousModel, HybridState
from gm_ompl.sampling.stages import states_along
from gm_ompl.space.motions import Motions


def judged_anew(problem: Problem, states: Sequence[HybridState]) -> tuple[Move, ...]:
    """Return the moves along ``states``, expanded and judged with nothing remembered.

    Raises:
        PathError: the path does not lead from start to goal, or a motion on it is infeasible.
    """
    model = ContinuousModel(problem, Judge(problem, make_backend(problem)))
    motions = Motions(model, model.start_state())
    if not states or not model.in_goal(states[-1]):
        raise PathError("the path does not end in the goal")
    moves: list[Move] = []
    here = model.start_state()
    for number, state in enumerate(states):
        found = motions.expand(here, state) if number else ()
        if found is None:
            raise PathError(
                f"motion {number} of the path, from {_shown(here)} to {_shown(state)}, cannot be "
                "executed in this direction"
            )
        if number:
            # The moves' own ends count: unwrapped, and free of OMPL's rounding.
            here = HybridState(_end(found, here), state.placements)
        moves.extend(found)
    return tuple(moves)


def _end(moves: Sequence[Move], before: HybridState) -> tuple[float, ...]:
    ends = [move.end for move in moves if isinstance(move, Displacement)]
    return ends[-1] if ends else before.q


def _shown(state: HybridState) -> str:
    return f"(q = {list(state.q)}, placements {list(state.placements)})"


def states_of(start: HybridState, moves: Sequence[Move]) -> list[HybridState]:
    """Return the states through which ``moves`` lead, one motion each; the start first."""
    return [start, *states_along(moves)]
