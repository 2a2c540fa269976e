"""``gm-ompl execute`` and ``export``: a plan over time."""

from __future__ import annotations

import math
from contextlib import nullcontext
from typing import cast

from gm_ompl.app.commands import Exit, require
from gm_ompl.app.output import note, say, say_json, writable
from gm_ompl.app.showing import opened
from gm_ompl.app.verbs import ExecuteVerb, ExportVerb
from gm_ompl.simulation.bag import write_bag
from gm_ompl.simulation.disturb import disturb, largest, probe
from gm_ompl.simulation.engine import ENGINES, EngineName
from gm_ompl.simulation.engines import load
from gm_ompl.simulation.execute import Setup, VariationReport, perform, prepare, vary
from gm_ompl.simulation.export import table
from gm_ompl.simulation.pulses import PulseReport
from gm_ompl.simulation.timeline import Pace
from gm_ompl.simulation.video import Film
from gm_ompl.writing import plain, write_text

FORMATS = ("csv", "ros2")

ENOUGH = 0.95  # share of the trials that must succeed


def execute_command(request: ExecuteVerb) -> Exit:
    """Play the plan back, put it to the test, show the result."""
    engine = _check(request)
    load(engine)
    video, plot = writable(request.video, "--video"), writable(request.plot, "--plot")
    with opened(request.plan_file) as plan:
        setup = prepare(plan, Pace(speed=request.speed), lean=request.lean, engine=engine)
    with nullcontext() if video is None else Film(video) as film:
        report, measured = perform(setup, watch=film)
    if plot is not None:
        from gm_ompl.viz.figures import draw_execution

        draw_execution(measured, plot)
    reached = largest(setup, request.largest, request.seed) if request.largest else ()
    tried = _tried(setup, request)
    made = [part for part in tried.values() if part is not None]
    holds = report.holds and all(part.share >= ENOUGH for part in made)
    if request.as_json:
        probed = tried["probes"]
        findings = report.findings + (probed.findings if isinstance(probed, PulseReport) else ())
        say_json({
            **report.to_dict(), "holds": holds, "findings": list(findings),
            **{name: None if part is None else part.to_dict() for name, part in tried.items()},
            "largest": plain(reached),
        })  # fmt: skip
    else:
        for part in (report, *made, *reached):
            say(part.table())
        say("it holds" if holds else "it does NOT hold")
        for path in (request.video, request.plot):
            if path is not None:
                note(f"written to {path}")
    return Exit.OK if holds else Exit.REFUTED


def _tried(setup: Setup, request: ExecuteVerb) -> dict[str, PulseReport | VariationReport | None]:
    """Put the plan to the tests that were asked for."""
    with_hand = setup.problem.hand is not None
    if with_hand and request.probe:
        note("margins are not probed: z counts on fingers that give way to nothing; motors do")
    return {
        "probes": probe(setup, request.probe) if request.probe and not with_hand else None,
        "disturbances": disturb(setup, request.disturb, request.trials, request.seed)
        if request.disturb else None,
        "variation": vary(setup, request.vary / 100.0, request.trials, request.seed)
        if request.vary else None,
    }  # fmt: skip


def _check(request: ExecuteVerb) -> EngineName:
    """Refuse what makes no sense; return the engine."""
    fraction, percent = request.disturb, request.vary
    holds = fraction is None or (math.isfinite(fraction) and fraction > 0)
    require(holds, "--disturb", fraction, "a positive fraction of z, such as 0.8")
    holds = percent is None or 0 < percent <= 50
    require(holds, "--vary", percent, "a percentage above 0, at most 50")
    require(request.engine in ENGINES, "--engine", request.engine, " or ".join(ENGINES))
    return cast(EngineName, request.engine)


def export_command(request: ExportVerb) -> Exit:
    """Write the plan over time as CSV or as a rosbag2."""
    require(request.to in FORMATS, "--to", request.to, "csv or ros2")
    if request.to == "ros2":
        with opened(request.plan_file) as plan:
            write_bag(plan, request.output, Pace(speed=request.speed), request.rate)
        note(f"written to {request.output}")
        return Exit.OK
    target = writable(request.output)
    assert target is not None
    with opened(request.plan_file) as plan:
        text = table(plan, Pace(speed=request.speed), request.rate)
    write_text(target, text)
    note(f"written to {request.output}")
    return Exit.OK
