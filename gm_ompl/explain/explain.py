"""``explain``: why there is no plan, or none through there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.explain import remedies
from gm_ompl.explain.instants import Explainer
from gm_ompl.explain.lanes import first_failure, names, progress, whole_lane
from gm_ompl.explain.regions import Region, whole_region
from gm_ompl.explain.surveys import Scored, sets_at, survey
from gm_ompl.explain.values import (
    SEARCH_SECONDS,
    Explanation,
    InstantLine,
    Remedy,
    SetLine,
    Survey,
)
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.goals import GoalNodes
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planners.planner import Budget, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Placements
from gm_ompl.scenario.scenario import Scenario

SAMPLES = 300
"""Sets of placements judged per survey."""
PLANAR_SAMPLES = 12
"""The same in the plane, where each set has a whole region."""
REMEDY_SECONDS = 8.0
"""What each search with a changed scenario may take."""


def explain(
    scenario: Scenario,
    at: Coordinates | None = None,
    placements: Placements | None = None,
    *,
    samples: int | None = None,
    seed: int = 0,
    search_seconds: float = SEARCH_SECONDS,
) -> Explanation:
    """Explain a scenario.

    Args:
        scenario: what is to be explained.
        at: object coordinates; None for the whole motion.
        placements: per finger, rows of the placement table; None for many sets.
        samples: sets judged per survey; more sets than that are sampled.
        seed: of the sampling.
        search_seconds: time limit of the search that says whether there is a plan; 0 for none.

    Raises:
        InputError: the start or the goal is off the lattice.
    """
    return _Explaining(scenario, samples, seed, search_seconds).run(at, placements)


@final
class _Explaining:
    def __init__(
        self, scenario: Scenario, samples: int | None, seed: int, search_seconds: float
    ) -> None:
        self._scenario, self._problem = scenario, scenario.problem
        self._judge = Judge(self._problem, make_backend(self._problem))
        self._explainer = Explainer(self._problem, self._judge)
        self._on_path = self._problem.motion.dimension == 1
        self._samples = samples or (SAMPLES if self._on_path else PLANAR_SAMPLES)
        self._rng = np.random.default_rng(seed)
        self._seconds = search_seconds

    def run(self, at: Coordinates | None, placements: Placements | None) -> Explanation:
        if at is not None and placements is not None:
            return self._instant(at, placements)
        if placements is not None:
            return self._set(placements)
        return self._everywhere() if at is None else self._at(at)

    def _made(self, verdict: str, **parts: object) -> Explanation:
        z_min = self._problem.mechanics.z_min
        return Explanation(self._problem.name, z_min, verdict, **parts)  # type: ignore[arg-type]

    def _directions(self, at: Coordinates) -> list[Coordinates | None]:
        """Return the directions of motion that matter at a point, and rest (None)."""
        if self._on_path:
            return [(1.0,), None]
        unit = np.eye(len(at))
        ways = [tuple((sign * axis).tolist()) for axis in unit for sign in (1.0, -1.0)]
        return [*ways, None]

    def _instant(self, at: Coordinates, placements: Placements) -> Explanation:
        lines = tuple(
            self._explainer.detailed(at, direction, placements)
            for direction in self._directions(at)
        )
        moving = [line for line in lines if line.direction is not None]
        good = sum(line.finding.name == "HOLDS" for line in moving)
        if len(moving) == 1:
            verdict = f"these placements at this point: {moving[0].finding.value}"
        else:
            verdict = f"these placements hold here in {good} of {len(moving)} directions of motion"
        return self._made(verdict, instants=lines)

    def _line(self, placements: Placements) -> SetLine:
        whole = whole_lane if self._on_path else whole_region
        return whole(self._explainer, placements)

    def _set(self, placements: Placements) -> Explanation:
        line = self._line(placements)
        if line.holds:
            return self._made("these placements hold from start to goal", placements=line)
        failure = line.forward or line.backward
        why = "the goal is not reached" if failure is None else failure.finding.value
        return self._made(
            f"these placements do not hold from start to goal: {why}",
            placements=line,
            remedies=tuple(remedies.for_placements(self._problem, placements, line)),
        )

    def _at(self, at: Coordinates) -> Explanation:
        none = (None,) * self._problem.fingers.count
        sets, possible = sets_at(self._problem, self._judge, at, none, self._samples, self._rng)
        scored = [self._score_at(at, placements) for placements in sets]
        found = survey(self._problem, "at", possible, scored, lambda p: self._line_at(at, p))
        if possible == 0:
            verdict = "no set of placements is geometrically possible here"
        else:
            verdict = f"{found.holding} of {found.judged} sets of placements judged here hold"
        return self._made(verdict, surveys=(found,))

    def _best_at(self, at: Coordinates, placements: Placements) -> InstantLine:
        """Return the direction of motion with the largest margin."""
        lines = []
        for direction in self._directions(at):
            if direction is not None:
                verdict = self._explainer.verdict(at, direction, placements)
                lines.append(self._explainer.line(at, direction, placements, verdict))
        return max(lines, key=lambda line: -1.0 if line.ratio is None else line.ratio)

    def _score_at(self, at: Coordinates, placements: Placements) -> Scored:
        line = self._best_at(at, placements)
        blocked = None if line.finding.name == "HOLDS" else line.finding
        return placements, blocked, line.ratio, -1.0 if line.ratio is None else line.ratio

    def _line_at(self, at: Coordinates, placements: Placements) -> SetLine:
        line = self._best_at(at, placements)
        holds = line.finding.name == "HOLDS"
        return SetLine(names(self._problem, placements), holds, line, None, ratio=line.ratio)

    def _everywhere(self) -> Explanation:
        search = self._search()
        surveys = (self._survey(backwards=False), self._survey(backwards=True))
        tried: tuple[Remedy, ...] = ()
        if search is not None and search is not Status.SOLVED:
            tried = tuple(remedies.for_scenario(self._scenario, REMEDY_SECONDS))
        return self._made(
            _sentence(search, surveys),
            search=None if search is None else search.sentence,
            surveys=surveys,
            remedies=tried,
        )

    def _search(self) -> Status | None:
        if self._seconds <= 0:
            return None
        planner, budget = make_planner("astar"), Budget(time_limit=self._seconds)
        return planner.solve(self._problem, self._judge, budget, self._rng).status

    def _survey(self, backwards: bool) -> Survey:
        problem, judge = self._problem, self._judge
        hand, end = problem.fingers, problem.start
        if backwards:
            end = problem.lattice.coordinates(GoalNodes(problem).nodes[0])
        required = hand.goal if backwards else hand.start
        sets, possible = sets_at(problem, judge, end, required, self._samples, self._rng)
        scored = [self._score(placements, backwards) for placements in sets]
        where = "goal" if backwards else "start"
        return survey(problem, where, possible, scored, self._line)

    def _score(self, placements: Placements, backwards: bool) -> Scored:
        if not self._on_path:
            region = Region(self._explainer, placements, backwards)
            line = region.failure()
            blocked = None if line is None else line.finding
            return placements, blocked, None if line is None else line.ratio, -region.nearest
        line = first_failure(self._explainer, placements, backwards)
        far = progress(self._problem, line, backwards)
        if line is None:
            return placements, None, None, far
        return placements, line.finding, line.ratio, far


def _sentence(search: Status | None, surveys: Sequence[Survey]) -> str:
    if search is Status.SOLVED:
        return "there is a plan"
    found = "whether there is a plan was not searched" if search is None else search.sentence
    if surveys[0].possible == 0:
        return f"{found}; no set of placements is geometrically possible at the start"
    if surveys[1].possible == 0:
        return f"{found}; no set of placements is geometrically possible at the goal"
    return found
