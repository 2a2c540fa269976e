"""What would help, tried out: nothing is suggested that was not judged again."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import numpy as np

from gm_ompl.errors import ScenarioError
from gm_ompl.explain.attempts import SAMPLER, SAMPLER_ITERATIONS, search
from gm_ompl.explain.deadline import Deadline
from gm_ompl.explain.instants import Explainer
from gm_ompl.explain.limits import Answer, Holds, Words, knobs, least
from gm_ompl.explain.regions import Region
from gm_ompl.explain.values import Remedy, SetLine
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.geometry.surface import face_labels
from gm_ompl.planners.planner import Status
from gm_ompl.problem import Placements, Problem
from gm_ompl.scenario.scenario import Scenario

SHORTEST = 0.02
"""With less time than this left [s], nothing more is tried."""

PLAN = Words("a plan exists", "none on the lattice", "none found")
ON_LATTICE = Words("a plan on the lattice exists", "none on the lattice", "none found")
KEPT = Words("these placements hold", "not", "not known")

_ANSWERS = {Status.SOLVED: Answer.YES, Status.INFEASIBLE: Answer.NO}


def for_placements(
    problem: Problem, placements: Placements, line: SetLine, deadline: Deadline
) -> Iterator[Remedy]:
    """Yield what was tried to let these placements hold from start to goal.

    Where geometry blocks them neither strength nor friction nor a smaller z_min can help: nothing
    is tried.
    """
    findings = {part.finding for part in line.stretches}
    findings |= {end.finding for end in (line.forward, line.backward) if end is not None}
    if Finding.GEOMETRY in findings:
        return

    def holds(changed: Problem, seconds: float) -> Answer:
        return _kept(changed, placements, Deadline(seconds))

    today = Answer.UNKNOWN if line.cut_short else Answer.NO
    yield from _turned(problem, holds, KEPT, today, deadline)


def _kept(problem: Problem, placements: Placements, deadline: Deadline) -> Answer:
    """Whether placements hold from start to goal."""
    explainer = Explainer(problem, Judge(problem, make_backend(problem)), deadline.passed)
    region = Region(explainer, placements, backwards=False)
    if region.arrived:
        return Answer.YES
    return Answer.UNKNOWN if region.cut_short else Answer.NO


def for_scenario(
    scenario: Scenario, deadline: Deadline, today: Status, off_lattice: bool
) -> Iterator[Remedy]:
    """Yield what was tried to let the scenario have a plan, each by searches of limited time.

    Args:
        scenario: it has none on its lattice, or none was found.
        deadline: of all that is tried.
        today: how the search on the scenario's lattice ended.
        off_lattice: whether a plan off the lattice counts, too: a sampler looks for one where the
            search on the lattice does not end in its time.
    """
    problem = scenario.problem
    table = problem.fingers.placements
    if len(np.unique(table.face)) < len(face_labels(problem.body)):
        yield from _all_faces(scenario, deadline.part(0.25, 5.0))

    def holds(changed: Problem, seconds: float) -> Answer:
        status = search(changed, seconds / 2 if off_lattice else seconds)
        if status is Status.BUDGET and off_lattice:
            sampler = search(changed, seconds / 2, SAMPLER, max_iterations=SAMPLER_ITERATIONS)
            return Answer.YES if sampler is Status.SOLVED else Answer.UNKNOWN
        return _ANSWERS.get(status, Answer.UNKNOWN)

    words = PLAN if off_lattice else ON_LATTICE
    now = _ANSWERS.get(today, Answer.UNKNOWN)
    yield from _turned(problem, holds, words, now, deadline)


def _turned(
    problem: Problem, holds: Holds, words: Words, today: Answer, deadline: Deadline
) -> Iterator[Remedy]:
    """Yield the least change of each value by itself."""
    every = list(knobs(problem))
    for k, knob in enumerate(every):
        if deadline.left() < SHORTEST:
            return
        yield least(
            knob, holds, words, today, deadline.part(1.0 / (len(every) - k), deadline.left())
        )


def _all_faces(scenario: Scenario, deadline: Deadline) -> Iterator[Remedy]:
    tree, key = copy.deepcopy(scenario.resolved()), "fingers.placements.faces"
    tree["fingers"]["placements"]["faces"] = "all"
    try:
        changed = Scenario.from_resolved(tree).problem
    except ScenarioError:  # smallest_face leaves none, or there are too many
        return
    if len(changed.fingers.placements) == len(scenario.problem.fingers.placements):
        return
    status = search(changed, deadline.left())
    found = {
        Status.SOLVED: "a plan exists with all faces",
        Status.INFEASIBLE: "none with all faces",
    }.get(status, "not settled in the time")
    yield Remedy(f"{key}=all", status is Status.SOLVED, found)
