"""Judges a saved plan anew, from its scenario alone, with the reference."""

from gm_ompl.checking.check import check
from gm_ompl.checking.recheck import Tolerances
from gm_ompl.checking.report import CheckReport, StepReport, Violation

__all__ = ["CheckReport", "StepReport", "Tolerances", "Violation", "check"]
