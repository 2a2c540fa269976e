"""``gm-ompl plan``, and how far a search has come, on stderr."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gm_ompl
from gm_ompl import limits
from gm_ompl.app.commands import EXIT_OF_STATUS, Exit
from gm_ompl.app.output import note, say, say_json, show_warnings, writable
from gm_ompl.app.showing import check_viewer, write_html
from gm_ompl.app.verbs import PlanVerb
from gm_ompl.asking import budget
from gm_ompl.errors import InputError, ScenarioError
from gm_ompl.planfile.model import DisplacementStep, Plan, RegraspStep, Step
from gm_ompl.planfile.points import with_points
from gm_ompl.planfile.words import chain
from gm_ompl.planners.planner import Progress, Status
from gm_ompl.planners.registry import is_exact
from gm_ompl.problem import Problem
from gm_ompl.reading import Kind, read_text
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.writing import is_stdout

if TYPE_CHECKING:
    from rich.status import Status as StatusLine

FIRST_LINE_S, FACTOR = 5.0, 2.0
"""In a log (no terminal) a line appears after 5 s, 10 s, 20 s, ...: short for a long search too."""


class ProgressLine:
    """Shows a search's events: one line that changes on a terminal, now and then a line in a log.

    Use as a context manager around the search and hand it over as the search's ``report``.
    """

    def __init__(self) -> None:
        self._status: StatusLine | None = None
        self._due = FIRST_LINE_S

    def __enter__(self) -> ProgressLine:
        if sys.stderr.isatty():
            from rich.console import Console  # takes a while to load

            self._status = Console(stderr=True).status("planning ...")
            self._status.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._status is not None:
            self._status.stop()

    def __call__(self, event: Progress) -> None:
        """Show ``event``."""
        if self._status is not None:
            self._status.update(describe(event))
        elif event.time >= self._due:
            note(describe(event))
            self._due = FACTOR * max(event.time, self._due)


def describe(event: Progress) -> str:
    """Return the event as one line."""
    best = "none yet" if event.cost is None else f"{event.cost:.6g}"
    bound = f"{event.lower_bound:.6g}" if math.isfinite(event.lower_bound) else "infinite"
    return (
        f"{event.time:.1f} s: {event.expanded:,} nodes expanded, "
        f"{event.mode_decisions:,} mode decisions, best cost {best}, lower bound {bound}"
    )


def plan_command(request: PlanVerb) -> Exit:
    """Plan, write the file, show the result."""
    output = writable(request.output)
    html, trace = writable(request.html, "--html"), writable(request.trace, "--trace")
    named = [target for target in (output, html, trace) if target is not None]
    if len(set(named)) < len(named):
        raise InputError("-o, --html and --trace must name different files")
    if html is not None:
        check_viewer()
    parameters = read_parameters(request.params)
    asked = budget(request.time_limit, request.max_iterations, request.memory_limit)
    with limits.holding(asked.time_limit, asked.memory_limit_mb):
        scenario = gm_ompl.load(request.scenario, request.overrides or ())
        show_warnings(scenario)
        plan = _search(request, scenario, parameters, trace)
    if output is not None:
        plan.save(output)
    if html is not None:
        write_html(plan, html)
    to_stdout = any(map(is_stdout, named))  # the file alone comes out there
    if request.as_json and not to_stdout:
        say_json(plan.to_dict())
    elif not request.as_json:
        for line in summary(plan, scenario.problem):
            (note if to_stdout else say)(line)
        if output is not None:
            note(f"written to {request.output}")
        if html is not None:
            note(f"shown in {request.html}")
    return EXIT_OF_STATUS[plan.status]


def _search(
    request: PlanVerb, scenario: Scenario, parameters: dict[str, Any], trace: Path | None
) -> Plan:
    """Plan, the progress shown and, where asked for, traced."""
    passed = ("planner", "time_limit", "max_iterations", "memory_limit", "seed")
    options = {"parameters": parameters} | {name: getattr(request, name) for name in passed}
    with ProgressLine() as line:
        if trace is None:
            return gm_ompl.plan(scenario, report=line, **options)
        from gm_ompl.planners.trace_file import TraceFile

        names = list(scenario.problem.motion.names)
        header = {"scenario": scenario.name, "planner": request.planner, "seed": request.seed,
                  "coordinates": names}  # fmt: skip
        with TraceFile(trace, header, line) as report:
            found = gm_ompl.plan(scenario, report=report, **options)
            report.end(found)
            return found


def read_parameters(path: Path | None) -> dict[str, Any]:
    """Return the planner's parameters from a file that holds one JSON or YAML object.

    Raises:
        InputError: the file cannot be read or holds something else.
    """
    if path is None:
        return {}
    from gm_ompl.scenario.document import parse

    text = read_text(path, PARAMETERS)
    try:
        parameters = parse(text, str(path)).tree
    except ScenarioError as error:
        raise InputError(
            f"--params {path}: must hold one object of parameters, as JSON or YAML "
            f'({{"name": value, ...}} or lines of name: value)\n{error}'
        ) from None
    assert isinstance(parameters, dict), "the reader accepts nothing else"
    return parameters


PARAMETERS = Kind(
    "file of parameters", "JSON or YAML", 2**20, lambda text: InputError(f"--params {text}")
)


def summary(plan: Plan, problem: Problem) -> Iterator[str]:
    """Yield the plan of a problem as a few lines for people."""
    name = plan.scenario.get("name", "scenario")
    # Restarts may miss a configuration of the hand: claims are of those that were found.
    over = ", over what inverse kinematics reached" if plan.scenario.get("hand") else ""
    if plan.cost is None:
        claims = over if plan.status == Status.INFEASIBLE.value else ""
        yield f"{name}: {Status(plan.status).sentence}{claims}"
        if ended_by := (plan.statistics.model_extra or {}).get("ended_by"):
            yield f"  ended by     {ended_by}"
        if plan.status == Status.BUDGET.value and is_exact(plan.planner):
            yield "  may find one --planner HybridRRTConnect, without a proof of the least cost"
    else:
        proven = f"proven optimal on the lattice{over}"
        quality = _within(plan) or (proven if plan.optimal else "not proven optimal")
        yield f"{name}: solved by {plan.planner}, {quality}"
        yield f"  cost         {plan.cost:.6g}"
        yield f"  regrasps     {plan.regrasps}"
        yield from _junctions(plan.statistics.model_extra or {})
    yield from _worst_case(plan.scenario)
    yield from _deviations(plan.scenario)
    if plan.lower_bound is not None and not plan.optimal:
        yield f"  lower bound  {plan.lower_bound:.6g}"
    spent = plan.statistics
    yield (
        f"  search       {spent.time_s:.2f} s, {spent.expanded:,} nodes expanded, "
        f"{spent.mode_decisions:,} mode decisions"
    )
    if pockets := (spent.model_extra or {}).get("pockets"):
        yield f"  refused      {pockets:,} first touches and regrasps: a fingertip is in a pocket"
    yield from _chain(plan, problem)
    for _, group in groupby(plan.steps, key=_stage):
        yield from _describe(list(group))


def _within(plan: Plan) -> str:
    """Return how near a plan is to the least cost over continuous placements, where they are."""
    said = plan.scenario["fingers"]["placements"].get("continuous")
    if not said or plan.cost is None or not plan.lower_bound:
        return ""
    gap = 100.0 * (plan.cost / plan.lower_bound - 1.0)
    return f"within {gap:.2g}% of the least over all placements ({100.0 * said['gap']:g}% asked)"


def _chain(plan: Plan, problem: Problem) -> Iterator[str]:
    """Yield what the object does, arc by arc; in the plane, where all changes at once, nothing."""
    if plan.has_plan:
        for link in chain(plan, with_points(problem, plan)):
            first, last = (number + 1 for number in link.steps)
            steps = f"step {first}" if first == last else f"steps {first}-{last}"
            yield f"  {steps:12s} {link.words}"


def _junctions(statistics: Mapping[str, Any]) -> Iterator[str]:
    """Yield which junctions do not simply hold, where there are any."""
    told = {
        "resting_junctions": "hold only while the object rests",
        "failing_junctions": "do not hold",
    }
    counts = {name: statistics.get(name, 0) for name in told}
    if None in counts.values():
        yield "  junctions    not judged: no time was left"
    elif any(counts.values()):
        parts = ", ".join(f"{count} {told[name]}" for name, count in counts.items() if count)
        yield f"  junctions    {parts}"


def _worst_case(scenario: Mapping[str, Any]) -> Iterator[str]:
    """Yield what z is where not everything is known exactly."""
    ranges = scenario.get("uncertainty")
    if ranges:
        yield f"  uncertainty  z is that of the worst case of: {', '.join(ranges)}"


def _deviations(scenario: Mapping[str, Any]) -> Iterator[str]:
    """Yield how far shapes are from the files they come from, where they are."""
    shapes = {"object": scenario["object"]["shape"]}
    shapes |= scenario.get("environment", {}).get("obstacles", {})
    for name, shape in shapes.items():
        if shape.get("deviation"):
            yield f"  shape        {name}: up to {shape['deviation']:.3g} off its file's surface"


def _stage(step: Step) -> tuple[Any, ...]:
    """Return what stays the same over the steps that are shown as one."""
    if isinstance(step, RegraspStep):
        return ("regrasp", step.at, step.finger)
    modes = {segment.modes for segment in step.segments}
    return ("displacement", step.placements, frozenset(modes))


def _describe(steps: list[Step]) -> Iterator[str]:
    first, last = steps[0], steps[-1]
    if isinstance(first, RegraspStep):
        old, new = first.from_, first.to
        yield (
            f"  {f'at {_numbers(first.at)}: ' if first.at else ''}finger {first.finger} moves from "
            f"{old.words} to {new.words}"
        )
    elif isinstance(last, DisplacementStep):
        segments = [
            s for step in steps if isinstance(step, DisplacementStep) for s in step.segments
        ]
        fingers = []
        for i, place in enumerate(first.placements):
            modes = "/".join(sorted({segment.modes[i] for segment in segments}))
            fingers.append(f"{place.words} {modes}-controlled")
        least = min(segment.z for segment in segments)
        start, end = (
            _numbers(q or pose.position)
            for q, pose in ((first.from_, first.pose_from), (last.to, last.pose_to))
        )
        held = [s.z_strong for s in segments if s.z_strong is not None]
        strong = f", z_strong {min(held):.4g}" if held else ""
        yield f"  {start} to {end}: {'; '.join(fingers)}; z at least {least:.4g}{strong}"


def _numbers(q: tuple[float, ...]) -> str:
    return ", ".join(f"{round(value, 9) + 0.0:.4g}" for value in q)
