"""What a problem is to OMPL: the space, what its states mean, its motions and draws."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planners.ompl.convert import Codec, CoordinateCodec, make_space
from gm_ompl.planners.ompl.draws import Draws, StateDraws
from gm_ompl.planners.ompl.free_motions import FreeMotions
from gm_ompl.planners.ompl.motions import HybridMotions, MacroMotions
from gm_ompl.planners.ompl.pose_draws import PoseDraws
from gm_ompl.planners.ompl.poses import PoseCodec, make_pose_space
from gm_ompl.planners.ompl.steering import Steering
from gm_ompl.sampling.free_model import FreeHybridModel
from gm_ompl.sampling.motions import CoordinateModel


class Parts(NamedTuple):
    """What a problem is to OMPL.

    Attributes:
        space: the compound state space.
        codec: what its states mean.
        motions: what each motion consists of.
        draws: random states.
    """

    space: Any
    codec: Codec
    motions: HybridMotions
    draws: Draws


def parts_of(judge: Judge, rng: np.random.Generator) -> Parts:
    """Return what a problem is to OMPL.

    Args:
        judge: answers about the problem.
        rng: of the states drawn in Python.
    """
    problem = judge.problem
    if not isinstance(problem.motion, FreeMotion):
        codec = CoordinateCodec(problem)
        motions = MacroMotions(CoordinateModel(problem, judge), codec.start)
        return Parts(make_space(problem), codec, motions, StateDraws(motions, rng))
    model = FreeHybridModel(problem, judge)
    poses, free = PoseCodec(model), FreeMotions(model, model.start_state())
    steering = Steering(free, rng)
    poses.steer = steering.settle
    return Parts(make_pose_space(model), poses, free, PoseDraws(free, steering, rng))


def motions_from(judge: Judge) -> HybridMotions:
    """Return what motions consist of, nothing being remembered."""
    problem = judge.problem
    if isinstance(problem.motion, FreeMotion):
        free = FreeHybridModel(problem, judge)
        return FreeMotions(free, free.start_state())
    model = CoordinateModel(problem, judge)
    return MacroMotions(model, model.start_state())
