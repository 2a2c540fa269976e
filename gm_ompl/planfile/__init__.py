"""Plan values, plan files, and the assembly of plans from a planner's moves."""

from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import (
    FORMAT,
    DisplacementStep,
    PlacementRecord,
    Plan,
    RegraspStep,
    SegmentRecord,
    Statistics,
    Step,
)
from gm_ompl.planfile.record import PoseRecord

__all__ = [
    "FORMAT",
    "DisplacementStep",
    "PlacementRecord",
    "Plan",
    "PoseRecord",
    "RegraspStep",
    "SegmentRecord",
    "Statistics",
    "Step",
    "assemble",
]
