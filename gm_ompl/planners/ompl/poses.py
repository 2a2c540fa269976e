"""The compound state space of free motion: position, rotation and placements."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Sequence
from typing import Any, Final, TypeAlias, final

import numpy as np
from ompl import base as ob

from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import SLACK
from gm_ompl.planners.ompl.convert import Codec, add_meaningless, add_placements
from gm_ompl.problem import Displacement, Move
from gm_ompl.sampling.free_model import FreeHybridModel, coordinates_of
from gm_ompl.sampling.motions import UNPLACED, HybridState
from gm_ompl.sampling.stages import after

PLACEMENTS: Final = 0.1
"""The first and the last row of the placement table are this far apart, over the region's size."""

SEALS: Final = 2.0**32

Steer: TypeAlias = Callable[[HybridState | None, Pose], HybridState | None]
"""From where a motion begins (None: anywhere) and a pose: a state near it."""


def make_pose_space(model: FreeHybridModel) -> Any:
    """Return OMPL's compound state space for free motion.

    Parts, in order: the centre of mass, the rotation, one discrete part per finger, and the two
    parts that mean nothing, see ``make_space``. Distances are in sizes of the region: the way of
    the centre of mass plus half D times the turn.
    """
    space = ob.CompoundStateSpace()
    space.setName(f"{model.problem.name}: pose and placements")
    low, high = model.motion.region
    slack = 2.0 * SLACK * model.problem.body.diagonal
    place, bounds = ob.RealVectorStateSpace(3), ob.RealVectorBounds(3)
    for k in range(3):
        bounds.setLow(k, float(low[k]) - slack)
        bounds.setHigh(k, float(high[k]) + slack)
    place.setBounds(bounds)
    place.setName("centre of mass")
    size = _size(model)
    space.addSubspace(place, 1.0 / size)
    turn = ob.SO3StateSpace()  # its distances are half the angle
    turn.setName("rotation")
    space.addSubspace(turn, 2.0 * model.metric.turn / size)
    add_placements(space, model.problem, PLACEMENTS)
    add_meaningless(space)
    return space


def _size(model: FreeHybridModel) -> float:
    low, high = model.motion.region
    return float(np.linalg.norm(high - low)) + model.problem.body.diagonal


@final
class PoseCodec(Codec):
    """What the states of ``make_pose_space`` mean.

    OMPL's samplers know nothing of contacts: what they draw is a wish, which is settled when OMPL
    first asks whether it is valid, or whether a motion to it is. The state is then changed to one
    near it that some hand can bring the object to. States that are settled carry a seal, their own
    checksum, in their label.

    Args:
        model: of the problem.

    Attributes:
        steer: settles wishes.
    """

    def __init__(self, model: FreeHybridModel) -> None:
        self.problem, self._motion = model.problem, model.motion
        self._n = self.problem.fingers.count
        self.start = model.start_state()
        beyond = (model.motion.region[1] + _size(model)).tolist()
        self.nowhere = HybridState((*beyond, 1.0, 0.0, 0.0, 0.0), (UNPLACED,) * self._n)
        self.steer: Steer = lambda _, __: None

    def read(self, state: Any) -> HybridState:
        """Return what an OMPL state says; the state is not kept."""
        place, turn = state[0], state[1]
        q = (place[0], place[1], place[2], turn.w, turn.x, turn.y, turn.z)
        rows = tuple(state[2 + i].value + UNPLACED for i in range(self._n))
        return HybridState(q, rows)

    def write(self, state: Any, meaning: HybridState, label: float = 0.0) -> None:  # noqa: ARG002
        """Make an OMPL state mean ``meaning``; its label is its seal."""
        place, turn = state[0], state[1]
        place[0], place[1], place[2], turn.w, turn.x, turn.y, turn.z = meaning.q
        for i, row in enumerate(meaning.placements):
            state[2 + i].value = row - UNPLACED
        state[2 + self._n][0] = _seal(meaning)
        state[3 + self._n].position = 0.0

    def said(self, state: Any) -> HybridState | None:
        """Return what an OMPL state means; None where it is not settled."""
        said = self.read(state)
        return said if state[2 + self._n][0] == _seal(said) else None

    def meant(self, state: Any, origin: HybridState | None = None) -> HybridState:
        """Return what a state means once it is settled; see ``Codec``."""
        said = self.said(state)
        if said is not None:
            return said
        q = self.read(state).q
        found = self.steer(origin, Pose.from_quaternion(q[:3], q[3:])) or self.nowhere
        self.write(state, found)
        return found

    def along(self, moves: Sequence[Move]) -> list[HybridState]:
        """Return the states that moves lead through, first and last included."""
        states = []
        for move in moves:
            if isinstance(move, Displacement):
                states.append(HybridState(coordinates_of(move.arc.start), move.placements))
                states.append(HybridState(coordinates_of(move.arc.end), move.placements))
            else:
                here = coordinates_of(move.pose)
                states.append(HybridState(here, move.placements))
                states.append(HybridState(here, after(move)))
        return list(dict.fromkeys(states))

    @property
    def projects(self) -> int:
        """The centre of mass and how far the object is tilted."""
        return 4

    def projected(self, state: Any) -> list[float]:
        """Return the centre of mass over the region, and the cosine of the tilt."""
        q = self.read(state).q
        low, high = self._motion.region
        ranges = np.where(high > low, high - low, 1.0)
        return [*(np.array(q[:3]) / ranges).tolist(), 1.0 - 2.0 * (q[4] ** 2 + q[5] ** 2)]


def _seal(said: HybridState) -> float:
    """Return a checksum in [0, 1)."""
    return zlib.crc32(struct.pack("7d", *said.q) + repr(said.placements).encode()) / SEALS
