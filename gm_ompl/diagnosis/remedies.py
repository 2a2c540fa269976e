"""What a sampler, a finer lattice and changes of the scenario bring: all of it is tried."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Iterator
from shlex import quote
from typing import Any

import numpy as np

from gm_ompl import limits
from gm_ompl.diagnosis.instants import Explainer
from gm_ompl.diagnosis.knobs import Holds, TrialOutcome, Words, knobs, least
from gm_ompl.diagnosis.narrower import narrower
from gm_ompl.diagnosis.regions import Region
from gm_ompl.diagnosis.values import Attempt, Remedy, SetLine
from gm_ompl.errors import LimitError, ScenarioError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.geometry.surface import face_labels
from gm_ompl.limits import Limits
from gm_ompl.planners.planner import Budget, Progress, Status
from gm_ompl.planners.registry import make_planner, roams
from gm_ompl.problem import Placements, Problem
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.uncertainty.ranges import Uncertainty

SAMPLER = "HybridRRTConnect"
"""The planner that is not bound to the lattice."""

SAMPLER_ITERATIONS = 2000
"""What it may spend at most, beside its time."""

LEAST_SECONDS = 0.01
"""A search's budget must be more than nothing."""


def search(
    problem: Problem,
    seconds: float,
    planner: str = "astar",
    seed: int = 0,
    max_iterations: int | None = None,
) -> Status:
    """Return how a search for any plan ends.

    Where the planner cannot place fingers as the problem asks, ``SAMPLER`` searches: it proves
    nothing.

    Raises:
        InputError: the start or the goal is off the lattice.
        KeyboardInterrupt: it was interrupted.
    """
    seconds, plans = max(seconds, LEAST_SECONDS), list[float]()

    def heed(progress: Progress) -> None:
        if progress.cost is not None:
            plans.append(progress.cost)

    asked = Budget(seconds, max_iterations, stop=lambda: bool(plans))
    rng = np.random.default_rng(seed)
    try:
        with limits.holding(seconds):
            judge = Judge(problem, make_backend(problem))
            searcher = make_planner(planner)
            if problem.fingers.anywhere is not None and not roams(searcher.specs, problem):
                searcher = make_planner(SAMPLER)
            status = searcher.solve(problem, judge, asked, rng, heed).status
    except LimitError:  # before the search could begin
        return Status.BUDGET
    if status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return status


def sampled(problem: Problem, lattice: Status, seconds: float, seed: int) -> Attempt:
    """Return what a sampler finds that may leave the lattice.

    Args:
        problem: the problem.
        lattice: how the search on the lattice ended.
        seconds: time limit.
        seed: of the sampler.
    """
    status = search(problem, seconds, SAMPLER, seed, SAMPLER_ITERATIONS)
    off = " that is not on the lattice" if lattice is Status.INFEASIBLE else ""
    with_seed = f" --seed {seed}" if seed else ""
    sentence = {
        Status.SOLVED: f"a sampler finds a plan{off}: plan with --planner {SAMPLER}{with_seed}",
        Status.INFEASIBLE: "no lattice of the object's motion can help: at the start or at the "
        "goal no set of placements is geometrically possible",
    }.get(status, f"a sampler ({SAMPLER}) finds none in its time, which proves nothing")
    return Attempt("sampler", status.value, sentence)


def certain(problem: Problem, seconds: float) -> Attempt:
    """Return what a search finds where all is known exactly that the problem gives ranges of."""
    status = search(dataclasses.replace(problem, uncertainty=Uncertainty()), seconds)
    sentence = {
        Status.SOLVED: "were all known exactly there would be a plan on the lattice: it is the "
        "ranges in uncertainty that leave none",
        Status.INFEASIBLE: "even were all known exactly there would be none on the lattice",
    }.get(status, "whether there is one were all known exactly was not settled in its time")
    return Attempt("no uncertainty", status.value, sentence)


def finer(scenario: Scenario, seconds: float) -> Attempt | None:
    """Return what a search on a lattice twice as fine finds; None where there can be no such."""
    change, tree = _twice_as_fine(scenario)
    try:
        problem = Scenario.from_resolved(tree).problem
    except ScenarioError:  # more nodes than can be numbered
        return None
    status = search(problem, seconds)
    sentence = {
        Status.SOLVED: f"a lattice twice as fine has a plan: --set {quote(change)}",
        Status.INFEASIBLE: "a lattice twice as fine has none either, which is proven",
    }.get(status, "whether a lattice twice as fine has one was not settled in its time")
    return Attempt("finer lattice", status.value, sentence, change)


def _twice_as_fine(scenario: Scenario) -> tuple[str, dict[str, Any]]:
    """Return the change as for --set, and the scenario's tree with it."""
    tree = copy.deepcopy(scenario.resolved())
    steps = scenario.model.lattice.steps
    if steps is None:
        tree["lattice"]["segments"] = [2 * n for n in tree["lattice"]["segments"]]
        return f"lattice.segments={tree['lattice']['segments']}", tree
    halves = {
        key: f"{step / 2!r} rad" if key in ("yaw", "rotation") else step / 2
        for key, step in steps.given.items()
    }
    tree["lattice"]["steps"] = halves
    shown = ", ".join(f"{key}: {value}" for key, value in halves.items())
    depth = tree["lattice"].get("depth")
    if depth is None:
        return f"lattice.steps={{{shown}}}", tree
    tree["lattice"]["depth"] = 2 * depth  # as far as before takes twice the arcs
    return f"lattice={{steps: {{{shown}}}, depth: {2 * depth}}}", tree


SHORTEST = 0.02
"""With less time than this left [s], nothing more is tried."""

PLAN = Words("a plan exists", "none on the lattice", "none found")
ON_LATTICE = Words("a plan on the lattice exists", "none on the lattice", "none found")
KEPT = Words("these placements hold", "not", "not known")

_ANSWERS = {Status.SOLVED: TrialOutcome.YES, Status.INFEASIBLE: TrialOutcome.NO}


def for_placements(
    problem: Problem, placements: Placements, line: SetLine, deadline: Limits
) -> Iterator[Remedy]:
    """Yield what was tried to let these placements hold from start to goal.

    Where geometry blocks them neither strength nor friction nor a smaller z_min can help: nothing
    is tried.
    """
    findings = {part.finding for part in line.stretches}
    findings |= {end.finding for end in (line.forward, line.backward) if end is not None}
    if Finding.GEOMETRY in findings:
        return

    def holds(changed: Problem, seconds: float) -> TrialOutcome:
        judge = Judge(changed, make_backend(changed))
        explainer = Explainer(changed, judge, Limits(seconds).passed)
        region = Region(explainer, placements, backwards=False)
        if region.arrived:
            return TrialOutcome.YES
        return TrialOutcome.UNKNOWN if region.cut_short else TrialOutcome.NO

    today = TrialOutcome.UNKNOWN if line.cut_short else TrialOutcome.NO
    yield from _turned(problem, holds, KEPT, today, deadline)


def for_scenario(
    scenario: Scenario, deadline: Limits, today: Status, off_lattice: bool
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

    def holds(changed: Problem, seconds: float) -> TrialOutcome:
        status = search(changed, seconds / 2 if off_lattice else seconds)
        if status is Status.BUDGET and off_lattice:
            sampler = search(changed, seconds / 2, SAMPLER, max_iterations=SAMPLER_ITERATIONS)
            return TrialOutcome.YES if sampler is Status.SOLVED else TrialOutcome.UNKNOWN
        return _ANSWERS.get(status, TrialOutcome.UNKNOWN)

    words = PLAN if off_lattice else ON_LATTICE
    now = _ANSWERS.get(today, TrialOutcome.UNKNOWN)
    yield from _turned(problem, holds, words, now, deadline)


def _turned(
    problem: Problem, holds: Holds, words: Words, today: TrialOutcome, deadline: Limits
) -> Iterator[Remedy]:
    """Yield the least change of each value by itself."""
    every = [*knobs(problem), *narrower(problem)]
    for k, knob in enumerate(every):
        if deadline.left() < SHORTEST:
            return
        yield least(
            knob, holds, words, today, deadline.part(1.0 / (len(every) - k), deadline.left())
        )


def _all_faces(scenario: Scenario, deadline: Limits) -> Iterator[Remedy]:
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
