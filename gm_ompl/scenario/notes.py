"""Mistakes that only show when shapes are made."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from gm_ompl.errors import GeometryError, ScenarioError
from gm_ompl.scenario.document import Document, Path
from gm_ompl.scenario.messages import value_problem

T = TypeVar("T")


class Notes:
    """Collects mistakes, so that the user sees all at once."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.problems: list[str] = []

    def attempt(self, path: Path, make: Callable[[], T]) -> T | None:
        """Return ``make()``, or None after noting its GeometryError at ``path``."""
        try:
            return make()
        except GeometryError as error:
            self.problems.append(self.document.line(path, str(error)))
            return None

    def wrong(self, path: Path, value: object, wanted: str) -> None:
        """Note that ``value`` at ``path`` is wrong."""
        self.problems.append(value_problem(self.document, path, value, wanted))

    def stop(self) -> None:
        """Raise what was noted, if anything."""
        if self.problems:
            raise ScenarioError(self.problems)
