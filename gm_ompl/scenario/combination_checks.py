"""What cannot be had together: continuous placements, strong margins and what knows neither."""

from __future__ import annotations

from collections.abc import Iterator

from gm_ompl.scenario.document import Path
from gm_ompl.scenario.model import ScenarioModel
from gm_ompl.scenario.motion_checks import Finding


def combination_findings(model: ScenarioModel) -> Iterator[Finding]:
    """Say what cannot be had together."""
    yield from _anywhere(model)
    yield from _strong(model)


def _strong(model: ScenarioModel) -> Iterator[Finding]:
    """Say what z_strong knows nothing of."""
    if model.mechanics.margin != "strong":
        return
    soft = model.fingers.soft
    for given, key in (
        (model.uncertainty is not None, "a certain world: remove uncertainty"),
        (max(soft if isinstance(soft, tuple) else (soft,)) > 0.0, "points: remove fingers.soft"),
    ):
        if given:
            yield ("mechanics", "margin"), "strong", f"needs {key}"


def _anywhere(model: ScenarioModel) -> Iterator[Finding]:
    """Say what continuous placements need, and what they cannot be had with."""
    placements, where = model.fingers.placements, ("fingers", "placements", "continuous")
    if placements.continuous is None:
        return
    if placements.margin is not None:
        path: Path = ("fingers", "placements", "margin")
        yield path, placements.margin, "is given by continuous.margin already; remove it"
    if model.mechanics.z_min <= 0.0:
        wanted = "must be positive with fingers.placements.continuous"
        yield ("mechanics", "z_min"), model.mechanics.z_min, wanted
    for given, key in (
        (model.hand is not None, "fingertips alone: remove hand"),
        (model.uncertainty is not None, "a certain world: remove uncertainty"),
        (model.mechanics.backend != "kernel", "mechanics.backend: kernel"),
        (model.mechanics.margin != "nominal", "mechanics.margin: nominal"),
        (model.fingers.count == 0, "a finger: raise fingers.count"),
    ):
        if given:
            yield where, ..., f"needs {key}"
