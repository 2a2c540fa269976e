"""Plans that verbs show or play: what is wrong with one is told with its file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gm_ompl.errors import MisfitError, PlanError, ScenarioError
from gm_ompl.plan.fit import in_file
from gm_ompl.plan.model import Plan


@contextmanager
def opened(path: Path) -> Iterator[Plan]:
    """Give the plan in ``path``; what is found wrong with it meanwhile is told with file and line.

    Raises:
        PlanError: the file cannot be read, is no plan, or its steps or its scenario cannot
            be used.
    """
    plan = Plan.load(path)
    try:
        yield plan
    except MisfitError as error:
        raise in_file(error, path) from None
    except ScenarioError as error:
        raise PlanError("\n".join(f"{path}: {line}" for line in error.problems)) from None
