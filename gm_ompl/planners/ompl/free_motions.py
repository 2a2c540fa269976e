"""Motions of free motion for OMPL: screws that follow each other."""

from __future__ import annotations

from typing import final

from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planners.ompl.motions import HybridMotions
from gm_ompl.sampling.free_model import FreeHybridModel, ScrewWay
from gm_ompl.sampling.motions import HybridState


@final
class FreeMotions(HybridMotions):
    """Motions of free motion: the object goes by screws that follow each other.

    Args:
        model: judges strides and regrasps.
        start: the start state.

    Attributes:
        free: the model.
    """

    def __init__(self, model: FreeHybridModel, start: HybridState) -> None:
        super().__init__(model, start)
        self.free = model

    def way(self, start: Coordinates, end: Coordinates, *, rests: bool = True) -> ScrewWay | None:  # noqa: ARG002
        """Return the chain of screws from a pose to another, or None where none is found."""
        begin = self.free.number(start)
        strides = self.free.chain(begin, self.free.number(end))
        return None if strides is None else ScrewWay(self.free, begin, strides)
