"""``gm-ompl execute``."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, say, say_json, writable
from gm_ompl.errors import InputError
from gm_ompl.plan.model import Plan
from gm_ompl.simulation.disturb import DisturbanceReport, Largest, disturb, largest
from gm_ompl.simulation.execute import Setup, perform, prepare
from gm_ompl.simulation.pace import Pace
from gm_ompl.simulation.physics import load
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
    setup = prepare(Plan.load(request.plan_file), Pace(speed=request.speed), lean=request.lean)
    with nullcontext() if video is None else Film(video) as film:
        report, measured = perform(setup, watch=film)
    if plot is not None:
        from gm_ompl.viz.execution import draw_execution

        draw_execution(measured, plot)
    disturbed = _disturbed(setup, request)
    reached = _largest(setup, request)
    varied = _varied(setup, request)
    if request.as_json:
        whole = report.to_dict()
        whole["disturbances"] = None if disturbed is None else disturbed.to_dict()
        whole["largest"] = plain([asdict(place) for place in reached])
        whole["variation"] = None if varied is None else varied.to_dict()
        say_json(whole)
    else:
        for part in (report, disturbed, varied):
            if part is not None:
                say(part.table())
        for place in reached:
            say(place.line())
        for path in (request.video, request.plot):
            if path is not None:
                note(f"written to {path}")
    return Exit.OK if _holds(report, disturbed, varied) else Exit.REFUTED


def _check(request: ExecuteRequest) -> None:
    """Refuse numbers that make no sense.

    Raises:
        InputError: an option's value is wrong.
    """
    if request.seed < 0:
        raise InputError(f"--seed {request.seed}: must be a whole number >= 0")
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


def _holds(
    report: ExecutionReport, disturbed: DisturbanceReport | None, varied: VariationReport | None
) -> bool:
    shares = [disturbed.share] if disturbed is not None else []
    shares += [varied.success] if varied is not None else []
    return report.holds and all(share >= ENOUGH for share in shares)
