"""One run of one of OMPL's planners: limits, progress, the path judged anew, the trees told of."""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import final

import numpy as np
from ompl import util as ou

from gm_ompl import limits
from gm_ompl.errors import LimitError, PathError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.growth import Vertices
from gm_ompl.planners.ompl.adapter import ExploredTrees
from gm_ompl.planners.ompl.ends import why_no_start
from gm_ompl.planners.ompl.motions import HybridMotions
from gm_ompl.planners.ompl.parts import motions_from
from gm_ompl.planners.ompl.setup import HybridSetup
from gm_ompl.planners.outcome import Log, result_of
from gm_ompl.planners.planner import Budget, Planner, Report, SearchResult, Status
from gm_ompl.planners.trace import Trace, Vertex, tracer
from gm_ompl.problem import Displacement, Move, Problem, Regrasp
from gm_ompl.sampling.motions import UNPLACED, HybridState
from gm_ompl.sampling.stages import after


@contextmanager
def silence() -> Iterator[None]:
    """Keep OMPL's own messages off the terminal."""
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    try:
        yield
    finally:
        ou.setLogLevel(level)


def run(
    planner: Planner, judge: Judge, budget: Budget, rng: np.random.Generator, report: Report
) -> SearchResult:
    """Search with the OMPL planner that ``planner`` names and sets."""
    log = Log(budget.start(), judge, report)
    watch = _Watch(planner.specs.optimal, log)
    with silence():
        setup = HybridSetup(judge, rng)
        status, refuted = Status.BUDGET, 0
        moves: tuple[Move, ...] | None = None
        try:
            if not setup.draws.start_and_goal_possible():
                status = Status.INFEASIBLE
            else:
                moves = _search(setup, planner, budget, watch)
                status = Status.BUDGET if moves is None else Status.SOLVED
        except PathError:
            refuted = 1
        except LimitError:
            pass  # before the search began
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
        watch.cost = math.inf if moves is None else math.fsum(move.cost for move in moves)
        watch.event()
        trace = tracer(report)
        if trace is not None and watch.planner is not None:
            tell(setup.explored(), setup.motions, trace)
        statistics = log.statistics(
            watch.iterations, setup.motions.asked, valid_motions=setup.motions.valid,
            refuted_paths=refuted,
        )  # fmt: skip
        bound = math.inf if status is Status.INFEASIBLE else 0.0
        return result_of(status, watch.cost, bound, moves or (), statistics)


def _search(
    setup: HybridSetup, planner: Planner, budget: Budget, watch: _Watch
) -> tuple[Move, ...] | None:
    """Return the moves of the path that OMPL found; None where it found none."""
    setup.use(planner)
    endless = budget.time_limit is None and budget.max_iterations is None and budget.stop is None
    if endless:
        setup.stop_at_first_plan()
    watch.planner = setup.getPlanner()
    with suppress(LimitError):  # in the middle of an answer: what was found before stands
        setup.run(watch, watch.log.meter.spent)
        if setup.shortcuts:
            setup.shorten(watch.log.meter.spent)
    states = setup.solution()
    with limits.lifted():
        return None if states is None else judged_anew(setup.judge.problem, states)


@final
class _Watch:
    """Counts a run's iterations and tells when to stop; OMPL asks it once per iteration."""

    def __init__(self, anytime: bool, log: Log) -> None:
        self.log, self.planner = log, None
        self.iterations, self.cost = 0, math.inf
        self._anytime = anytime

    def __call__(self) -> bool:
        """Count an iteration; whether the run is over."""
        over = self.log.meter.spent(self.iterations)
        self.iterations += 1
        if self._anytime and (cost := float(self.planner.bestCost().value())) < self.cost:  # type: ignore[attr-defined]
            self.cost = cost
            self.event()
        elif self.log.due():
            self.event()
        return over

    def event(self) -> None:
        """Tell of the progress."""
        self.log.event(self.cost, 0.0, self.iterations, 0)


def judged_anew(problem: Problem, states: Sequence[HybridState]) -> tuple[Move, ...]:
    """Return the moves along ``states``, expanded and judged with nothing remembered.

    Raises:
        PathError: the path does not lead from start to goal, or a motion on it is infeasible.
    """
    motions = motions_from(Judge(problem, make_backend(problem)))
    model = motions.model
    if not states or not model.in_goal(states[-1]):
        raise PathError("the path does not end in the goal")
    wrong = why_no_start(model, states[0])
    if wrong is not None:
        raise PathError(f"the path does not begin at a start: {wrong}")
    moves: list[Move] = []
    here = HybridState(model.start, states[0].placements)
    motions.starts.add(here)
    for number, state in enumerate(states):
        found = motions.expand(here, state) if number else ()
        if found is None:
            raise PathError(
                f"motion {number} of the path, from {_shown(here)} to {_shown(state)}, cannot be "
                "executed in this direction"
            )
        if number:
            # The moves' own ends count: unwrapped, and free of OMPL's rounding.
            ends = [move.end for move in found if isinstance(move, Displacement)]
            here = HybridState((ends[-1] if ends else here.q) or state.q, state.placements)
        moves.extend(found)
    return tuple(moves)


def _shown(state: HybridState) -> str:
    return f"(q = {list(state.q)}, placements {list(state.placements)})"


def tell(tree: ExploredTrees, motions: HybridMotions, trace: Trace) -> None:
    """Tell ``trace`` of what one of OMPL's planners explored.

    A motion is told as what it consists of: a vertex after each regrasp, one at its end.

    Args:
        tree: what was explored.
        motions: what motions consist of; those of the tree are remembered.
        trace: who hears of it.
    """
    vertices = Vertices(trace)
    for root in ("start", "goal"):
        for tail, head in _outward(tree, root):
            a, b = (head, tail) if root == "goal" else (tail, head)
            parent: Vertex | None = None
            way = _way(tree.states[a], tree.states[b], motions)
            for state in reversed(way) if root == "goal" else way:
                parent = vertices.reached(root, state, parent)


def _outward(tree: ExploredTrees, root: str) -> Iterator[tuple[int, int]]:
    """Yield (known, new vertex) from the roots of one of the trees to its leaves; roots first."""
    backward = root == "goal"
    onward = defaultdict[int, list[int]](list)
    for a, b in tree.edges:
        if (a in tree.backward) == (b in tree.backward) == backward:
            tail, head = (b, a) if backward else (a, b)
            onward[tail].append(head)
    ends = sorted(tree.goals & tree.backward if backward else tree.starts)
    for end in ends:
        if UNPLACED not in tree.states[end].placements:
            yield end, end
    seen, waiting = set(ends), deque(ends)
    while waiting:
        tail = waiting.popleft()
        for head in onward[tail]:
            if head not in seen:
                seen.add(head)
                waiting.append(head)
                yield tail, head


def _way(origin: HybridState, target: HybridState, motions: HybridMotions) -> list[HybridState]:
    """Return the states between which the motion changes one thing at a time."""
    here = zip(origin.placements, target.placements, strict=True)
    way = [HybridState(origin.q, tuple(b if a == UNPLACED else a for a, b in here))]
    for move in motions.expand(origin, target) or ():
        if isinstance(move, Regrasp):
            at = motions.model.where(move)
            way += [HybridState(at, move.placements), HybridState(at, after(move))]
    if way[-1].placements == target.placements and motions.model.same(way[-1].q, target.q):
        way.pop()
    return [state for k, state in enumerate([*way, target]) if k == 0 or state != way[k - 1]]
