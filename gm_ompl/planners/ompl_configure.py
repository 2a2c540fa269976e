"""From a planner's name and settings to OMPL's planner object."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ompl import geometric as og

if TYPE_CHECKING:
    from gm_ompl.planners.ompl_setup import HybridSetup

ENDLESS = 2**31 - 1
"""The largest number of goal samples that OMPL can be told of."""


def configure(setup: HybridSetup, name: str, settings: Mapping[str, Any]) -> Any:
    """Return OMPL's planner ``name`` for ``setup``; changes the setup's goal to suit it."""
    si = setup.getSpaceInformation()
    planner = getattr(og, name)(si)
    if "range" in settings:
        planner.setRange(settings["range"] * si.getStateSpace().getMaximumExtent())
    if "samples" in settings:
        _set_samples(planner, settings["samples"])
    if settings.get("first_plan"):
        setup.stop_at_first_plan()
    if "guided" in settings:
        _guide(setup, planner, settings["goal_bias"], settings["guided"])
    else:
        setup.offer_goals(settings["goal_states"])
    return planner


def _set_samples(planner: Any, samples: int) -> None:
    if isinstance(planner, og.FMT):
        planner.setNumSamples(samples)
    else:
        planner.setSamplesPerBatch(samples)


def _guide(setup: HybridSetup, planner: Any, goal_bias: float, guided: float) -> None:
    """Let goal states and guided states come through the goal region, the rest from OMPL."""
    share = goal_bias + guided - goal_bias * guided
    planner.setGoalBias(share)
    setup.offer_goals(ENDLESS, 0.0 if share == 0.0 else 1.0 - goal_bias / share)
