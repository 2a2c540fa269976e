"""``gm-ompl execute``."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, say, say_json, writable
from gm_ompl.app.plan_files import opened
from gm_ompl.errors import InputError
from gm_ompl.simulation.disturb import DisturbanceReport, disturb
from gm_ompl.simulation.execute import Setup, perform, prepare
from gm_ompl.simulation.largest import Largest, largest
from gm_ompl.simulation.pace import Pace
from gm_ompl.simulation.physics import load
from gm_ompl.simulation.probe import ProbeReport, probe
from gm_ompl.simulation.report import ExecutionReport, plain
from gm_ompl.simulation.vary import VariationReport, vary
from gm_ompl.simulation.video import Film

ENOUGH = 0.95
"""Share of the trials that must succeed."""


@dataclass(frozen=True)
class ExecuteRequest:
    """The options of ``gm-ompl execute``."""

    plan_file: Path
    seed: int
    probe: int
    disturb: float | None
    largest: int | None
    vary: float | None
    trials: int
    speed: float
    lean: bool
    video: Path | None
    plot: Path | None
    as_json: bool


def execute_command(request: ExecuteRequest) -> Exit:
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
        _disturbed(setup, request),
        _largest(setup, request),
        _varied(setup, request),
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


def _check(request: ExecuteRequest) -> None:
    """Refuse numbers that make no sense.

    Raises:
        InputError: an option's value is wrong.
    """
    if request.seed < 0:
        raise InputError(f"--seed {request.seed}: must be a whole number >= 0")
    if request.probe < 0:
        raise InputError(f"--probe {request.probe}: must be a whole number >= 0")
    if request.trials < 1:
        raise InputError(f"--trials {request.trials}: must be a whole number >= 1")
    fraction, percent = request.disturb, request.vary
    if fraction is not None and not (math.isfinite(fraction) and fraction > 0):
        raise InputError(f"--disturb {fraction}: must be a positive fraction of z, such as 0.8")
    if percent is not None and not 0 < percent <= 50:
        raise InputError(f"--vary {percent}: must be a percentage above 0, at most 50")


def _disturbed(setup: Setup, request: ExecuteRequest) -> DisturbanceReport | None:
    if request.disturb is None:
        return None
    return disturb(setup, request.disturb, request.trials, request.seed)


def _largest(setup: Setup, request: ExecuteRequest) -> tuple[Largest, ...]:
    if request.largest is None:
        return ()
    return largest(setup, request.largest, request.seed)


def _varied(setup: Setup, request: ExecuteRequest) -> VariationReport | None:
    if request.vary is None:
        return None
    return vary(setup, request.vary / 100.0, request.trials, request.seed)
