"""``explain`` on free motion: what is in reach, what blocks the rest, what would help."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple, final

import numpy as np

from gm_ompl import limits
from gm_ompl.diagnosis import SECONDS, free_remedies, remedies
from gm_ompl.diagnosis.free_regions import FreeRegion, Leaving
from gm_ompl.diagnosis.free_values import Explored
from gm_ompl.diagnosis.instants import Explainer
from gm_ompl.diagnosis.pockets import pocket_line
from gm_ompl.diagnosis.regions import names
from gm_ompl.diagnosis.roaming import (
    HELD_POSES,
    POSES,
    Roaming,
    off_goal,
    place_of,
)
from gm_ompl.diagnosis.surveys import Scored, known, sets_at, survey
from gm_ompl.diagnosis.values import (
    Attempt,
    Explanation,
    InstantLine,
    Remedy,
    SetLine,
    Survey,
)
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.geometry.pose import Pose
from gm_ompl.limits import Limits
from gm_ompl.motion.free import angle_between
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.planners.planner import Status
from gm_ompl.problem import Placements
from gm_ompl.scenario.scenario import Scenario

SAMPLES = 24
"""Sets of placements judged per survey; each has a whole region."""

ALONE = 10.0
"""What all of it may take where no time is given for searches [s]."""


class _Ends(NamedTuple):
    """Where a survey begins, and where it should come to."""

    where: str
    pose: Pose
    required: tuple[int | None, ...]
    sources: Sequence[int]
    leaving: Leaving
    off: Callable[[int], float]


@final
class FreeExplaining:
    """Explains a scenario of free motion.

    Args:
        scenario: what is to be explained.
        samples: sets judged per survey.
        seed: of the sampling.
        seconds: what all of it may take, up to one step of each part; 0 for no searches.
    """

    def __init__(self, scenario: Scenario, samples: int | None, seed: int, seconds: float) -> None:
        self._scenario, self._problem = scenario, scenario.problem
        self._judge = Judge(self._problem, make_backend(self._problem))
        self._searching = seconds > 0.0
        self._deadline = Limits(seconds if self._searching else ALONE)
        self._part = self._deadline
        self._explainer = Explainer(self._problem, self._judge, lambda: self._part.passed())
        self._samples = samples or SAMPLES
        self._rng = np.random.default_rng(seed)

    def _made(self, verdict: str, **parts: object) -> Explanation:
        z_min = self._problem.mechanics.z_min
        return Explanation(self._problem.name, z_min, verdict, **parts)  # type: ignore[arg-type]

    def of_set(self, placements: Placements) -> Explanation:
        """Return how far a set of placements comes from the start."""
        self._part = self._deadline.part(0.5, SECONDS)
        line = self._line(placements, self._forward())
        failure = line.forward
        why = "the goal is not reached" if failure is None else failure.finding.value
        if line.cut_short:
            why = "the goal was not reached in the time or among the poses visited"
        if line.holds:
            return self._made("these placements hold from start to goal", placements=line)
        return self._made(
            f"these placements {'are not known to' if line.cut_short else 'do not'} hold from "
            f"start to goal without regrasping: {why}",
            placements=line,
        )

    def everywhere(self) -> Explanation:
        """Return why there is no plan, or that there is one."""
        status = None
        if self._searching:
            status = remedies.search(self._problem, self._deadline.part(0.35, SECONDS).left())
        open_ = status not in (None, Status.SOLVED)
        roaming, alone = self._explored(None, 0.2 if open_ else 0.3)
        surveys, sets = self._surveys(roaming)
        explored = (alone, self._explored(sets, 0.25)[1]) if sets else (alone,)
        attempts: tuple[Attempt, ...] = ()
        tried: tuple[Remedy, ...] = ()
        if status is not None and open_:
            attempts = tuple(known(self._attempts(status)))
            blocked = any(found.possible == 0 for found in surveys)
            tried = () if blocked else tuple(known(self._remedies(alone, status)))
        return self._made(
            _sentence(status, explored, surveys),
            search=None if status is None else status.sentence,
            attempts=attempts,
            surveys=surveys,
            explored=explored,
            remedies=tried,
        )

    def _attempts(self, status: Status) -> Iterator[Attempt]:
        if status is Status.INFEASIBLE:
            closer = remedies.finer(self._scenario, self._deadline.part(0.2, SECONDS).left())
            yield from () if closer is None else (closer,)

    def _remedies(self, alone: Explored, status: Status) -> Iterator[Remedy]:
        """Yield what was tried; no force or friction helps where the object cannot get there."""
        vain = alone.whole and not alone.arrived
        share = self._deadline.part(1.0 if vain else 0.3, SECONDS)
        yield from free_remedies.of_motion(self._scenario, alone, share)
        if not vain:
            yield from remedies.for_scenario(
                self._scenario, self._deadline, status, off_lattice=False
            )

    def _explored(
        self, sets: Sequence[Placements] | None, share: float
    ) -> tuple[Roaming, Explored]:
        self._part = self._deadline.part(share, ALONE)
        roaming, most = Roaming(self._explainer, sets), self._part.part(0.7, ALONE)
        with limits.holding(most.left()):
            roaming.grow(POSES if sets is None else HELD_POSES, most.passed)
        with limits.holding(self._part.left()):
            return roaming, roaming.explored(self._part.passed)

    def _surveys(self, alone: Roaming) -> tuple[tuple[Survey, ...], list[Placements]]:
        """Return what sets come to from the start, and from the goal where that was seen."""
        found, sets = list[Survey](), list[Placements]()
        for ends in (self._forward(), self._backward(alone)):
            if ends is None:
                continue
            self._part = self._deadline.part(0.2, ALONE)
            try:
                with limits.holding(self._part.left()):
                    found.append(self._survey(ends, sets))
            except LimitError:
                found.append(Survey(ends.where, None, 0, True, 0, {}, (), ()))
        return tuple(found), sets

    def _survey(self, ends: _Ends, sets: list[Placements]) -> Survey:
        """Survey one end; note the sets in ``sets``."""
        problem, judge = self._problem, self._judge
        drawn, possible = sets_at(
            problem, judge, ends.pose, ends.required, self._samples, self._rng
        )
        sets += [placements for placements in drawn if placements not in sets]
        half, scored = self._part.part(0.6, ALONE), list[Scored]()
        for placements in drawn:
            if scored and half.passed():
                break
            scored += known(self._score(p, ends) for p in (placements,))
        return survey(
            problem, ends.where, possible, scored, lambda p: self._line(p, ends), self._part.passed
        )

    def _score(self, placements: Placements, ends: _Ends) -> Scored:
        region = self._region(placements, ends)
        line = region.failure()
        blocked, ratio = (None, None) if line is None else (line.finding, line.ratio)
        if ends.where == "start" and not self._part.passed() and self._pocket(placements):
            blocked = Finding.POCKET
        return placements, blocked, ratio, -region.nearest

    def _pocket(self, placements: Placements) -> InstantLine | None:
        line = pocket_line(self._explainer, (), placements)
        if line is None:
            return None
        return replace(line, place=place_of(self._problem, self._problem.motion.pose(())))

    def _region(self, placements: Placements, ends: _Ends) -> FreeRegion:
        return FreeRegion(self._explainer, placements, ends.sources, ends.leaving, ends.off)

    def _line(self, placements: Placements, ends: _Ends) -> SetLine:
        region = self._region(placements, ends)
        line, forward = region.failure(), ends.where == "start"
        pocket = self._pocket(placements) if forward else None
        line = line if pocket is None else pocket
        return SetLine(
            placements=names(self._problem, placements),
            holds=region.arrived and pocket is None,
            forward=line if forward else None,
            backward=None if forward else line,
            ratio=None if line is None else line.ratio,
            nodes_from_start=len(region.nodes) if forward else None,
            nodes_to_goal=None if forward else len(region.nodes),
            cut_short=region.cut_short and not region.arrived,
        )

    def _forward(self) -> _Ends:
        problem, graph = self._problem, self._problem.object_graph

        def leaving(node: int) -> Iterator[tuple[int, GraphArc]]:
            return ((arc.head, arc) for arc in graph.arcs_from(node))

        return _Ends(
            "start", graph.pose(graph.start), problem.fingers.start, (graph.start,), leaving,
            lambda node: off_goal(problem, graph.pose(node)),
        )  # fmt: skip

    def _backward(self, alone: Roaming) -> _Ends | None:
        """Return the way back from the goal along arcs that were seen; None without a goal."""
        problem, graph = self._problem, self._problem.object_graph
        into: dict[int, list[tuple[int, GraphArc]]] = {}
        for tail, arcs in alone.leaving.items():
            for arc in arcs:
                into.setdefault(arc.head, []).append((tail, arc))
        goals = [node for node in {*alone.leaving, *into} if graph.in_goal(node)]
        if not goals:
            return None
        start = graph.pose(graph.start)

        def off(node: int) -> float:
            pose = graph.pose(node)
            arm = float(np.linalg.norm(pose.position - start.position))
            near = arm / problem.body.diagonal + angle_between(start.rotation, pose.rotation)
            return 0.0 if node == graph.start else max(near, 1e-12)

        return _Ends(
            "goal", graph.pose(goals[0]), problem.fingers.goal, goals,
            lambda node: into.get(node, ()), off,
        )  # fmt: skip


def _sentence(
    search: Status | None, explored: Sequence[Explored], surveys: Sequence[Survey]
) -> str:
    if search is Status.SOLVED:
        return "there is a plan on the lattice"
    found = "whether there is a plan was not searched" if search is None else search.sentence
    if explored[0].whole and not explored[0].arrived:
        found = Status.INFEASIBLE.sentence
    for end in surveys:
        if end.possible == 0:
            return f"{found}; no set of placements is geometrically possible at the {end.where}"
    alone, *held = explored
    if not alone.arrived:
        why = (
            "nowhere on the lattice is the object in the goal, whatever holds it"
            if alone.whole
            else f"among the {alone.nodes:,} poses looked at the object is nowhere in the goal"
        )
    elif not held or held[0].arrived:
        return found
    else:
        why = "by itself the object gets to the goal, held by the sets of placements tried it does"
        why += " not" if held[0].whole else " not among the poses looked at"
    return f"{found}; {why}"
