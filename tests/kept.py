"""The two searches of free motion, each by itself."""

from __future__ import annotations

import math
from unittest import mock

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.planners.free_search import FreeSearch
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget, SearchResult, silent
from gm_ompl.problem import Problem


def kept(problem: Problem, enough: float = math.inf) -> KeptSearch:
    """A search for plans without regrasping that are cheaper than ``enough``."""
    judge = Judge(problem, KernelBackend(problem))
    search = KeptSearch.of(judge, Log(Budget().start(), judge))
    assert search is not None
    while not search.done:
        search.step(enough)
    return search


def lanes(problem: Problem, seconds: float | None = None) -> SearchResult:
    """What the search over lanes finds by itself."""
    judge = Judge(problem, KernelBackend(problem))
    with mock.patch.object(KeptSearch, "of", return_value=None):
        return FreeSearch(problem, judge, Log(Budget(seconds).start(), judge), silent).run()
