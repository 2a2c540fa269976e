"""The parameters of the project's own randomised planners, and the settings they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, Final, TypeVar

from gm_ompl.planners.parameters import Parameter
from gm_ompl.sampling.anytime import AnytimeSettings
from gm_ompl.sampling.explorer import ExplorerSettings
from gm_ompl.sampling.improver import ImproverSettings
from gm_ompl.sampling.tree import TreeSettings

Settings = TypeVar("Settings")

_TREE, _EXPLORER = TreeSettings(), ExplorerSettings()
_IMPROVER, _ANYTIME = ImproverSettings(), AnytimeSettings()

EXPLORING: Final[tuple[Parameter, ...]] = (
    Parameter(
        "batch", int, _TREE.batch,
        "Sets of placements drawn at once; the most promising one is judged first.",
        1, 4096, logarithmic=True,
    ),
    Parameter(
        "root_share", float, _TREE.root_share,
        "Share of the iterations that try new sets at a tree's own end.", 0.01, 1.0,
    ),
    Parameter(
        "greed", float, _TREE.greed,
        "How strongly branches that came far are preferred for regrasps; 0 is not at all.",
        0.0, 100.0,
    ),
    Parameter(
        "window", float, _TREE.window,
        "How far before a branch's end a regrasp is tried, as a mean share of the route.",
        0.0, 1.0,
    ),
    Parameter(
        "sidestep", float, _TREE.sidestep,
        "Chance to accept a regrasp that gets no further by itself.", 0.0, 1.0,
    ),
    Parameter(
        "lean", float, _EXPLORER.lean,
        "How strongly draws lean to placements that got far; 0 draws evenly.", 0.0, 10.0,
    ),
    Parameter(
        "explore", float, _EXPLORER.explore,
        "Share of the draws that are even all the same.", 0.01, 1.0,
    ),
    Parameter(
        "detour", float, _EXPLORER.detour,
        "Chance per iteration to try another route of the object.", 0.001, 1.0,
        logarithmic=True,
    ),
)  # fmt: skip
"""Of HybridRRT and HybridRRTConnect."""

IMPROVING: Final[tuple[Parameter, ...]] = (
    *EXPLORING,
    Parameter(
        "near_best", float, _IMPROVER.near_best,
        "Share of the draws near the best plan's sets.", 0.0, 1.0,
    ),
    Parameter(
        "near_any", float, _IMPROVER.near_any,
        "Share of the draws near other sets of the sample.", 0.0, 1.0,
    ),
    Parameter(
        "drawn", int, _IMPROVER.drawn,
        "Sets drawn at once, before bounds choose among them.", 1, 10_000, logarithmic=True,
    ),
    Parameter(
        "joining", int, _IMPROVER.joining,
        "Sets that join the sample at once.", 1, 1000, logarithmic=True,
    ),
    Parameter(
        "tries", int, _IMPROVER.tries,
        "Paths judged per iteration.", 1, 1000, logarithmic=True,
    ),
    Parameter(
        "sample", int, _IMPROVER.sample,
        "Sets kept per route.", 10, 100_000, logarithmic=True,
    ),
    Parameter(
        "roam", float, _ANYTIME.roam,
        "Share of the iterations that go on exploring once there is a plan.", 0.0, 1.0,
    ),
    Parameter(
        "elsewhere", float, _ANYTIME.elsewhere,
        "Share of the improving iterations spent on routes other than the best.", 0.0, 1.0,
    ),
    Parameter(
        "polish", float, _ANYTIME.polish,
        "Share of the iterations that refine the best plan off its route's vertices.", 0.0, 1.0,
    ),
    Parameter(
        "stall", int, _ANYTIME.stall,
        "Iterations without improvement before the best route is varied.", 1, 100_000,
        logarithmic=True,
    ),
    Parameter(
        "patience", int, 1000,
        "Iterations without improvement after which an unlimited search ends.", 1, 10_000_000,
        logarithmic=True,
    ),
)  # fmt: skip
"""Of HybridRRTstar."""


def exploring(values: Mapping[str, Any]) -> ExplorerSettings:
    """Return the explorer's settings from parameter values."""
    return replace(_made(ExplorerSettings, values), tree=_made(TreeSettings, values))


def improving(values: Mapping[str, Any]) -> AnytimeSettings:
    """Return the anytime search's settings from parameter values."""
    improver = _made(ImproverSettings, values)
    return replace(_made(AnytimeSettings, values), explorer=exploring(values), improver=improver)


def _made(kind: type[Settings], values: Mapping[str, Any]) -> Settings:
    """Return settings of a kind, its fields from the parameters of the same names."""
    names = {field.name for field in fields(kind)}  # type: ignore[arg-type]
    return kind(**{name: value for name, value in values.items() if name in names})
