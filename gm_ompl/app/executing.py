"""``gm-ompl execute``."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from typing import Any

from gm_ompl.app.exits import Exit
from gm_ompl.app.options import require
from gm_ompl.app.output import note, say, say_json, writable
from gm_ompl.app.plan_files import opened
from gm_ompl.app.show_verbs import ExecuteVerb
from gm_ompl.simulation.disturb import DisturbanceReport, Largest, disturb, largest
from gm_ompl.simulation.execute import perform, prepare
from gm_ompl.simulation.pace import Pace
from gm_ompl.simulation.physics import load
from gm_ompl.simulation.probe import ProbeReport, probe
from gm_ompl.simulation.report import ExecutionReport, plain
from gm_ompl.simulation.vary import VariationReport, vary
from gm_ompl.simulation.video import Film

ENOUGH = 0.95
"""Share of the trials that must succeed."""


def execute_command(request: ExecuteVerb) -> Exit:
    """Play the plan back, put it to the test, show the result."""
    _check(request)
    load()
    video, plot = writable(request.video, "--video"), writable(request.plot, "--plot")
    with opened(request.plan_file) as plan:
        setup = prepare(plan, Pace(speed=request.speed), lean=request.lean)
    with nullcontext() if video is None else Film(video) as film:
        report, measured = perform(setup, watch=film)
    if plot is not None:
        from gm_ompl.viz.execution import draw_execution

        draw_execution(measured, plot)
    tests = _Tests(
        probe(setup, request.probe) if request.probe else None,
        disturb(setup, request.disturb, request.trials, request.seed) if request.disturb else None,
        largest(setup, request.largest, request.seed) if request.largest else (),
        vary(setup, request.vary / 100.0, request.trials, request.seed) if request.vary else None,
    )
    holds = report.holds and all(share >= ENOUGH for share in tests.shares())
    if request.as_json:
        say_json(_as_json(report, tests, holds))
    else:
        _say(report, tests, holds)
        for path in (request.video, request.plot):
            if path is not None:
                note(f"written to {path}")
    return Exit.OK if holds else Exit.REFUTED


@dataclass(frozen=True)
class _Tests:
    """What was tried beyond playing back; None where it was not asked for."""

    probed: ProbeReport | None
    disturbed: DisturbanceReport | None
    reached: tuple[Largest, ...]
    varied: VariationReport | None

    def shares(self) -> list[float]:
        """Return the share of the trials that succeed, per test."""
        found = [part.share for part in (self.probed, self.disturbed) if part is not None]
        return found + ([] if self.varied is None else [self.varied.success])


def _as_json(report: ExecutionReport, tests: _Tests, holds: bool) -> dict[str, Any]:
    whole = {**report.to_dict(), "holds": holds}
    if tests.probed is not None:
        whole["findings"] = [*whole["findings"], *tests.probed.findings]
    parts = {
        "probes": tests.probed, "disturbances": tests.disturbed, "variation": tests.varied,
    }  # fmt: skip
    whole |= {name: None if part is None else part.to_dict() for name, part in parts.items()}
    whole["largest"] = plain([asdict(place) for place in tests.reached])
    return whole


def _say(report: ExecutionReport, tests: _Tests, holds: bool) -> None:
    for part in (report, tests.probed, tests.disturbed, tests.varied):
        if part is not None:
            say(part.table())
    for place in tests.reached:
        say(place.line())
    say("it holds" if holds else "it does NOT hold")


def _check(request: ExecuteVerb) -> None:
    """Refuse numbers that make no sense.

    Raises:
        InputError: an option's value is wrong.
    """
    fraction, percent = request.disturb, request.vary
    require(request.seed >= 0, "--seed", request.seed, "a whole number >= 0")
    require(request.probe >= 0, "--probe", request.probe, "a whole number >= 0")
    require(request.trials >= 1, "--trials", request.trials, "a whole number >= 1")
    holds = fraction is None or (math.isfinite(fraction) and fraction > 0)
    require(holds, "--disturb", fraction, "a positive fraction of z, such as 0.8")
    holds = percent is None or 0 < percent <= 50
    require(holds, "--vary", percent, "a percentage above 0, at most 50")
