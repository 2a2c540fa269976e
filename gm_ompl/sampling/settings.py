"""What the randomised searches may be set to: each value with its default, range and meaning."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


def setting(
    default: float, low: float, high: float, meaning: str, *, factors: bool = False, was: str = ""
) -> Any:
    """Return a field of settings.

    Args:
        default: the value where none is given; its type is the setting's.
        low: least value.
        high: greatest value.
        meaning: one sentence for the user.
        factors: whether a search over values should go by factors rather than by steps.
        was: what it was called before.
    """
    told = {"low": low, "high": high, "meaning": meaning, "logarithmic": factors, "was": was}
    return field(default=default, metadata=told)


@dataclass(frozen=True)
class ExploringSettings:
    """How a first plan is searched for: how trees grow, sets are drawn, routes are tried."""

    batch: int = setting(
        128, 1, 4096, "Sets of placements drawn at once; the most promising one is judged first.",
        factors=True,
    )  # fmt: skip
    root_share: float = setting(
        0.3, 0.01, 1.0, "Share of the iterations that try new sets at a tree's own end."
    )
    progress_bias: float = setting(
        8.0, 0.0, 100.0,
        "How strongly branches that came far are preferred for regrasps; 0 is not at all.",
        was="greed",
    )  # fmt: skip
    backtrack_share: float = setting(
        0.15, 0.0, 1.0,
        "How far before a branch's end a regrasp is tried, as a mean share of the route.",
        was="window",
    )  # fmt: skip
    no_progress_share: float = setting(
        0.1, 0.0, 1.0, "Chance to accept a regrasp that gets no further by itself.", was="sidestep"
    )
    placement_bias: float = setting(
        2.0, 0.0, 10.0,
        "How strongly draws lean to placements that got far; 0 draws evenly.", was="lean",
    )  # fmt: skip
    uniform_share: float = setting(
        0.1, 0.01, 1.0, "Share of the draws that are even all the same.", was="explore"
    )
    new_route_share: float = setting(
        0.02, 0.001, 1.0, "Chance per iteration to try another route of the object.",
        factors=True, was="detour",
    )  # fmt: skip


@dataclass(frozen=True)
class ImprovingSettings(ExploringSettings):
    """How a first plan is searched for, and how time is divided once there is one."""

    best_neighbour_share: float = setting(
        0.4, 0.0, 1.0, "Share of the draws near the best plan's sets.", was="near_best"
    )
    neighbour_share: float = setting(
        0.3, 0.0, 1.0, "Share of the draws near other sets of the sample.", was="near_any"
    )
    drawn: int = setting(
        400, 1, 10_000, "Sets drawn at once, before bounds choose among them.", factors=True
    )
    joining: int = setting(40, 1, 1000, "Sets that join the sample at once.", factors=True)
    tries: int = setting(40, 1, 1000, "Paths judged per iteration.", factors=True)
    sample_limit: int = setting(
        1500, 10, 100_000, "Sets kept per route.", factors=True, was="sample"
    )
    exploring_share: float = setting(
        0.05, 0.0, 1.0, "Share of the iterations that go on exploring once there is a plan.",
        was="roam",
    )  # fmt: skip
    other_routes_share: float = setting(
        0.2, 0.0, 1.0, "Share of the improving iterations spent on routes other than the best.",
        was="elsewhere",
    )  # fmt: skip
    smoothing_share: float = setting(
        0.1, 0.0, 1.0,
        "Share of the iterations that refine the best plan off its route's vertices.",
        was="polish",
    )  # fmt: skip
    rerouting_share: float = setting(
        0.3, 0.0, 1.0,
        "Share of the improving iterations that look for a shorter route beside the best; free "
        "motion only.",
    )  # fmt: skip
    stall_limit: int = setting(
        40, 1, 100_000, "Iterations without improvement before the best route is varied.",
        factors=True, was="stall",
    )  # fmt: skip
    patience: int = setting(
        1000, 1, 10_000_000,
        "Iterations without improvement after which an unlimited search ends.", factors=True,
    )  # fmt: skip
