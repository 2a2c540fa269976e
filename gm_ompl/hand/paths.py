"""Joint paths: what the hand's hinges do along a plan, and why they cannot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from gm_ompl.arrays import Array, read_only


@dataclass(frozen=True, eq=False)
class JointPaths:
    """A hand's way along a plan; between rows the hinges turn evenly.

    Attributes:
        joints: the k hinges' names.
        approach: (a, k), from home to where all fingertips touch.
        moves: per move (m, k): of a displacement, rows evenly spaced along its arc; of a regrasp,
            the way of the lifted finger.
        retreat: (r, k), from the last configuration home.
    """

    joints: tuple[str, ...]
    approach: Array
    moves: tuple[Array, ...]
    retreat: Array

    def __post_init__(self) -> None:
        shape = (None, len(self.joints))
        for name in ("approach", "retreat"):
            object.__setattr__(self, name, read_only(getattr(self, name), shape, name))
        moves = tuple(read_only(rows, shape, "moves") for rows in self.moves)
        object.__setattr__(self, "moves", moves)


class JointRefusal(NamedTuple):
    """Why there are no joint paths along moves.

    Attributes:
        move: the first move that no configuration gets through.
        share: how far along it.
        finger: who cannot.
        why: in words.
    """

    move: int
    share: float
    finger: int
    why: str
