"""``gm-ompl map``: where a finger may go, as numbers, as an image, or as a page."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import gm_ompl
from gm_ompl import limits
from gm_ompl.app.commands import Exit, require_positive
from gm_ompl.app.explaining import read_coordinates
from gm_ompl.app.output import note, say, say_json, show_warnings, writable
from gm_ompl.app.showing import opened
from gm_ompl.app.verbs import MapVerb
from gm_ompl.errors import InputError
from gm_ompl.feasibility.placement_map import PlacementMap
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.planfile.arcs import arc_of, pose_before
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import DisplacementStep, Plan
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.writing import write_text

IMAGES = (".png", ".svg", ".pdf")

FACES_SHOWN = 12


def map_command(request: MapVerb) -> Exit:
    """Map a scenario's placements at an instant, and show or write them.

    Raises:
        InputError: options do not go together, or the file cannot be written.
    """
    require_positive(time_limit=request.time_limit, memory_limit=request.memory_limit)
    target = writable(request.output, "-o")
    kind = "" if request.output is None else request.output.suffix.lower()
    if request.output is not None and kind not in (*IMAGES, ".html", ".json"):
        wanted = ", ".join((*IMAGES, ".html", ".json"))
        raise InputError(f"-o {request.output}: the name must end in {wanted}")
    with limits.holding(request.time_limit, request.memory_limit):
        found = _mapped(request)
    if not request.finger < len(found.z):
        raise InputError(f"--finger {request.finger}: must be below {len(found.z)}")
    if target is not None:
        _write(found, request, kind, target)
        note(f"written to {request.output}")
    if request.as_json:
        say_json(found.to_dict())
    elif target is None:
        for line in lines(found, request.finger):
            say(line)
    return Exit.OK


def _mapped(request: MapVerb) -> PlacementMap:
    """Return the map that is asked for."""
    if request.step is not None:
        given = {"--at": request.at, "--direction": request.direction, "--set": request.overrides}
        beside = [name for name, value in given.items() if value is not None]
        if beside or request.rest:
            raise InputError(f"{(*beside, '--rest')[0]}: goes with a scenario, not with --step")
        with opened(Path(request.source)) as plan:
            return of_step(plan, request.step)
    scenario = gm_ompl.load(request.source, request.overrides or ())
    show_warnings(scenario)
    problem = scenario.problem
    if request.at is None and request.direction is None and not problem.motion.names:
        return gm_ompl.placement_map(scenario)
    q = problem.start if request.at is None else read_coordinates(request.at)
    return gm_ompl.placement_map(scenario, q, _direction(request, problem))


def of_step(plan: Plan, step: int) -> PlacementMap:
    """Map all placements at a step of a plan: at its segment of least z, or at rest for a regrasp.

    Args:
        plan: the plan.
        step: its number, from 0.

    Raises:
        InputError: there is no such step.
        MisfitError: the plan does not fit its scenario.
    """
    if not 0 <= step < len(plan.steps):
        raise InputError(f"step {step}: the plan has {len(plan.steps)} steps, counted from 0")
    problem, record = problem_of(plan), plan.steps[step]
    scenario = Scenario.from_resolved(plan.scenario)
    if not isinstance(record, DisplacementStep):
        return gm_ompl.placement_map(scenario, pose=pose_before(plan, step, problem))
    weakest = min(range(len(record.segments)), key=lambda k: record.segments[k].z)
    middle = arc_of(record, problem).middles(len(record.segments))[weakest]
    return gm_ompl.placement_map(scenario, pose=middle.pose, twist=middle.twist)


def _direction(request: MapVerb, problem: Problem) -> list[float] | None:
    if request.direction is not None:
        if request.rest:
            raise InputError("--rest: does not go with --direction")
        return read_coordinates(request.direction, "--direction")
    on_path = len(problem.motion.names) == 1
    return [1.0] if on_path and not request.rest else None


def _write(found: PlacementMap, request: MapVerb, kind: str, target: Path) -> None:
    if kind == ".json":
        write_text(target, json.dumps(found.to_dict(), allow_nan=False) + "\n")
    elif kind == ".html":
        from gm_ompl.viz.placements import placements_page

        write_text(target, placements_page(found, "\n".join(lines(found, request.finger)),
                                           request.finger))  # fmt: skip
    else:
        from gm_ompl.viz.canvas import save, styled
        from gm_ompl.viz.placements import placements_figure

        with styled():
            save(placements_figure(found), target)


def lines(found: PlacementMap, finger: int) -> Iterator[str]:
    """Yield the map of one finger as lines for people: in all, then face by face."""
    table, z_min = found.problem.fingers.placements, found.problem.mechanics.z_min
    moving = "at rest" if found.moment.twist is None else "moving"
    yield f"{found.problem.name}: finger {finger}, the object {moving}; z_min = {z_min:g}"
    for finding, count in found.counts(finger).items():
        yield f"  {count:6d} placements: {finding.value}"
    yield "  face      hold   of    best z  where, and the others then"
    faces = np.unique(table.face)
    for face in faces[:FACES_SHOWN]:
        yield _face_line(found, finger, int(face))
    if len(faces) > FACES_SHOWN:
        yield f"  ... and {len(faces) - FACES_SHOWN} faces more: --json has all of them"


def _face_line(found: PlacementMap, finger: int, face: int) -> str:
    table = found.problem.fingers.placements
    rows = np.flatnonzero(table.face == face)
    hold = sum(found.finding(finger, int(row)) is Finding.HOLDS for row in rows)
    best = int(rows[np.argmax(found.z[finger, rows])])
    text = f"  {table.labels[face]:8s} {hold:5d} {len(rows):4d}"
    if found.sets[finger, best, finger] < 0:
        return f"{text}         -"
    names = [f"{table.labels[table.face[r]]}:{table.cell[r][0]}.{table.cell[r][1]}"
             for r in found.sets[finger, best]]  # fmt: skip
    others = ", ".join(name for i, name in enumerate(names) if i != finger)
    return f"{text}  {found.z[finger, best]:8.4g}  {names[finger]}; {others or 'alone'}"
