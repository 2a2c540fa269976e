"""``explain``: why there is no plan, or none through there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import final

import numpy as np

from gm_ompl import limits
from gm_ompl.diagnosis import SECONDS, remedies
from gm_ompl.diagnosis.free import FreeExplaining
from gm_ompl.diagnosis.instants import Explainer, contact_lines
from gm_ompl.diagnosis.pockets import pocket_line
from gm_ompl.diagnosis.regions import Region, names, whole_lane, whole_region
from gm_ompl.diagnosis.remedies import certain, finer, sampled, search
from gm_ompl.diagnosis.surveys import Scored, known, sets_at, survey
from gm_ompl.diagnosis.values import (
    Attempt,
    ContactLine,
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
from gm_ompl.limits import Limits
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planners.planner import Status
from gm_ompl.problem import Placements
from gm_ompl.scenario.scenario import Scenario

SAMPLES = 300
"""Sets of placements judged per survey."""
PLANAR_SAMPLES = 12
"""The same in the plane, where each set has a whole region."""
SURVEYS_ALONE = 10.0
"""What the surveys may take where no time is given for searches [s]."""
SAMPLER_SECONDS = 3.0
"""What a sampler may take: what it finds it mostly finds at once."""


def explain(
    scenario: Scenario,
    at: Coordinates | None = None,
    placements: Placements | None = None,
    *,
    samples: int | None = None,
    seed: int = 0,
    seconds: float = SECONDS,
) -> Explanation:
    """Explain a scenario.

    Args:
        scenario: what is to be explained.
        at: object coordinates; None for the whole motion.
        placements: per finger, rows of the placement table; None for many sets.
        samples: sets judged per survey; more sets than that are sampled.
        seed: of the sampling.
        seconds: what all of it may take, up to one step of each part; 0 for no searches.

    Raises:
        InputError: the start or the goal is off the lattice, or coordinates are asked for where
            the motion is free.
        LimitError: a limit is reached before there is anything to tell.
        KeyboardInterrupt: it was interrupted.
    """
    with limits.holding(seconds or SURVEYS_ALONE):
        if isinstance(scenario.problem.motion, FreeMotion):
            free = FreeExplaining(scenario, samples, seed, seconds)
            return free.everywhere() if placements is None else free.of_set(placements)
        return _Explaining(scenario, samples, seed, seconds).run(at, placements)


@final
class _Explaining:
    def __init__(self, scenario: Scenario, samples: int | None, seed: int, seconds: float) -> None:
        self._scenario, self._problem = scenario, scenario.problem
        self._judge = Judge(self._problem, make_backend(self._problem))
        self._searching, self._seed = seconds > 0.0, seed
        self._deadline = Limits(seconds if self._searching else SURVEYS_ALONE)
        self._part = self._deadline
        self._explainer = Explainer(self._problem, self._judge, lambda: self._part.passed())
        self._on_path = self._problem.motion.dimension == 1
        self._samples = samples or (SAMPLES if self._on_path else PLANAR_SAMPLES)
        self._rng = np.random.default_rng(seed)

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
        pocket = pocket_line(self._explainer, at, placements)
        if pocket is not None:
            verdict, lines = f"{verdict}; {pocket.finding.value}", (*lines, pocket)
        return self._made(verdict, instants=lines, contacts=self._contacts(at))

    def _line(self, placements: Placements) -> SetLine:
        whole = whole_lane if self._on_path else whole_region
        line = whole(self._explainer, placements)
        pocket = pocket_line(self._explainer, self._problem.start, placements)
        return line if pocket is None else replace(line, holds=False, forward=pocket)

    def _set(self, placements: Placements) -> Explanation:
        line = self._line(placements)
        if line.holds:
            return self._made("these placements hold from start to goal", placements=line)
        failure = line.forward or line.backward
        tried = remedies.for_placements(self._problem, placements, line, self._deadline)
        why = "the goal is not reached" if failure is None else failure.finding.value
        if line.cut_short:
            why = "the goal was not reached in the time or among the nodes visited"
        return self._made(
            f"these placements {'are not known to' if line.cut_short else 'do not'} hold from "
            f"start to goal: {why}",
            placements=line,
            remedies=tuple(known(tried)) if self._searching else (),
        )

    def _contacts(self, at: Coordinates) -> tuple[ContactLine, ...]:
        return contact_lines(self._problem, at, self._directions(at))

    def _at(self, at: Coordinates) -> Explanation:
        none, pose = (None,) * self._problem.fingers.count, self._problem.motion.pose(at)
        sets, possible = sets_at(self._problem, self._judge, pose, none, self._samples, self._rng)
        scored = self._scored(sets, lambda placements: self._score_at(at, placements))
        found = survey(
            self._problem, "at", possible, scored, lambda p: self._line_at(at, p),
            self._part.passed,
        )  # fmt: skip
        if possible == 0:
            verdict = "no set of placements is geometrically possible here"
        else:
            verdict = f"{found.holding} of {found.judged} sets of placements judged here hold"
        return self._made(verdict, surveys=(found,), contacts=self._contacts(at))

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
        return SetLine(
            names(self._problem, placements), holds, None if holds else line, None, ratio=line.ratio
        )

    def _everywhere(self) -> Explanation:
        status = None
        if self._searching:
            status = search(self._problem, self._deadline.part(0.3, SECONDS).left())
        open_ = status not in (None, Status.SOLVED)
        attempts = tuple(known(self._attempts(status))) if status is not None and open_ else ()
        share = 0.25 if open_ else 0.45
        surveys = (self._survey(False, share), self._survey(True, share))
        tried: tuple[Remedy, ...] = ()
        blocked = any(found.possible == 0 for found in surveys)
        if status is not None and open_ and not blocked:
            elsewhere = attempts[0].status == Status.SOLVED.value if attempts else False
            tried = tuple(
                known(
                    remedies.for_scenario(
                        self._scenario, self._deadline, status, off_lattice=not elsewhere
                    )
                )
            )
        return self._made(
            _sentence(status, attempts, surveys),
            search=None if status is None else status.sentence,
            attempts=attempts,
            surveys=surveys,
            remedies=tried,
        )

    def _attempts(self, lattice: Status) -> Iterator[Attempt]:
        if not self._problem.fingers.count:
            return  # samplers draw placements
        seconds = self._deadline.part(0.2, SAMPLER_SECONDS).left()
        found = sampled(self._problem, lattice, seconds, self._seed)
        yield found
        if lattice is Status.INFEASIBLE and found.status != Status.INFEASIBLE.value:
            closer = finer(self._scenario, self._deadline.part(0.2, SECONDS).left())
            yield from () if closer is None else (closer,)
        if self._problem.uncertainty:
            yield certain(self._problem, self._deadline.part(0.2, SECONDS).left())

    def _survey(self, backwards: bool, share: float) -> Survey:
        where = "goal" if backwards else "start"
        self._part = self._deadline.part(share, SURVEYS_ALONE)
        try:
            with limits.holding(self._part.left()):
                return self._surveyed(backwards, where)
        except LimitError:
            return survey(self._problem, where, None, (), self._line, self._part.passed)

    def _surveyed(self, backwards: bool, where: str) -> Survey:
        problem, judge = self._problem, self._judge
        hand, end = problem.fingers, problem.start
        if backwards:
            end = problem.object_graph.coordinates((problem.object_graph.goal_nodes or ())[0])
        required = hand.goal if backwards else hand.start
        sets, possible = sets_at(
            problem, judge, problem.motion.pose(end), required, self._samples, self._rng
        )
        scored = self._scored(sets, lambda placements: self._score(placements, backwards))
        return survey(problem, where, possible, scored, self._line, self._part.passed)

    def _scored(
        self, sets: Sequence[Placements], score: Callable[[Placements], Scored]
    ) -> list[Scored]:
        """Return the scores of as many sets as there is time for, at least of one."""
        half, scored = self._part.part(0.6, SURVEYS_ALONE), list[Scored]()
        for placements in sets:
            if scored and half.passed():
                break
            scored += known(map(score, (placements,)))
        return scored

    def _starts_in_pocket(self, placements: Placements) -> bool:
        return pocket_line(self._explainer, self._problem.start, placements) is not None

    def _score(self, placements: Placements, backwards: bool) -> Scored:
        region = Region(self._explainer, placements, backwards)
        line = region.failure()
        blocked, ratio = (None, None) if line is None else (line.finding, line.ratio)
        if not (backwards or self._part.passed()) and self._starts_in_pocket(placements):
            blocked = Finding.POCKET
        return placements, blocked, ratio, -region.nearest


def _sentence(search: Status | None, attempts: Sequence[Attempt], surveys: Sequence[Survey]) -> str:
    if search is Status.SOLVED:
        return "there is a plan on the lattice"
    found = "whether there is a plan was not searched" if search is None else search.sentence
    for end, where in zip(surveys, ("start", "goal"), strict=True):
        if end.possible == 0:
            return f"{found}; no set of placements is geometrically possible at the {where}"
    elsewhere = [
        attempt
        for attempt in attempts
        if attempt.status == Status.SOLVED.value and attempt.kind != "no uncertainty"
    ]
    return f"{found}, but there is one elsewhere" if elsewhere else found
