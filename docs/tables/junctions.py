"""``python -m docs.tables.junctions [PAGE]``: how many junctions hold.

Every plan found is put under steady control leaving junctions aside; and minding them, where a
randomised planner searches again as ``plan`` does. The reference then judges all junctions of
both. Takes ten minutes on one core.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from docs.tables.pages import growing, write_page
from gm_ompl import api
from gm_ompl.contact.junction import JunctionVerdict
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.links import Link
from gm_ompl.feasibility.steady_force import Undecided
from gm_ompl.planners.again import settled
from gm_ompl.planners.choosing import Chooser
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.prepare import prepare
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Move
from gm_ompl.scenario.families import FAMILIES
from gm_ompl.scenario.load import shipped

SEEDS = 20  # of each random family
RUNS = (("astar", 1, 60.0), ("HybridRRTstar", 3, 3.0))
"""Planners of the shipped scenarios, their seeds and time limits [s]."""
FIRST = ("HybridRRT", 1, 20.0)
"""That of the random families, which ends with its first plan."""

FREE, FREE_RUN, FREE_SEEDS = ("free/", "tasks/"), ("astar", 1, 10.0), 8
"""Free motion, which only `astar` plans."""

HEAD = (
    "scenarios", "planner", "plans", "junctions",
    "before: not in motion", "of these not at rest", "now: not in motion", "of these not at rest",
)  # fmt: skip


class Careless(Chooser):
    """Steady control that leaves junctions aside."""

    def _links(self, commands: Sequence[Undecided], which: Sequence[int]) -> list[Link]:
        del commands, which
        return []


def verdicts(
    judge: Judge, before: Sequence[Move], now: Sequence[Move]
) -> tuple[Counter[JunctionVerdict], Counter[JunctionVerdict]]:
    """Return the verdicts on the junctions of plans, the first without steady control."""
    found = []
    for chooser in (Careless(judge, before), Chooser(judge, now)):
        chosen = [instant.decision for instant in chooser.instants]
        if isinstance(chooser, Careless):
            chosen = chooser.choose(set())[0]
        pairs = range(len(chosen) - 1)
        found.append(Counter(chooser.passage(number, chosen) for number in pairs))
    return found[0], found[1]


def rows() -> Iterator[tuple[object, ...]]:
    """Yield the rows of the table."""
    for name in shipped():
        for run in RUNS[:1] if name.startswith(FREE) else RUNS:
            yield _row(name, [name], *run)
    for family in FAMILIES:
        run, seeds = (FREE_RUN, FREE_SEEDS) if family.startswith("free") else (FIRST, SEEDS)
        yield _row(family, [f"random/{family}/{seed}" for seed in range(seeds)], *run)


def _row(
    title: str, names: Sequence[str], planner: str, seeds: int, limit: float
) -> tuple[object, ...]:
    plans, before, now = 0, Counter[JunctionVerdict](), Counter[JunctionVerdict]()
    for name in names:
        problem = api.load(name).problem
        prepare(problem)
        for seed in range(seeds):
            judge, rng = Judge(problem, make_backend(problem)), np.random.default_rng(seed)
            searcher, budget = make_planner(planner), Budget(limit)
            result = searcher.solve(problem, judge, budget, rng)
            if result.moves:
                _, steady = settled(searcher, judge, result, budget, rng)
                found = verdicts(judge, result.moves, steady.moves)
                plans, before, now = plans + 1, before + found[0], now + found[1]
    cells = [
        number
        for found in (before, now)
        for number in (
            found[JunctionVerdict.RESTS] + found[JunctionVerdict.FAILS],
            found[JunctionVerdict.FAILS],
        )
    ]
    return title, planner, plans, before.total(), *cells


def main() -> None:
    """Measure and write the page."""
    write_page("junctions", {"junctions": growing(HEAD, rows())})


if __name__ == "__main__":
    main()
