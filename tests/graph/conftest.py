"""Decisions that a test makes once."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from gm_ompl.problem import Problem
from tests.shared_decisions import SharedDecisions


@pytest.fixture(scope="session")
def remembered() -> Callable[[Problem], SharedDecisions]:
    """Per problem name its decisions; variants that differ in costs alone share them."""
    known: dict[str, SharedDecisions] = {}

    def of(problem: Problem) -> SharedDecisions:
        return known.setdefault(problem.name, SharedDecisions(problem))

    return of
