"""The exception tree.

GmOmplError                  everything this package raises on purpose
|-- InputError               the user's input is wrong (command line: exit code 2)
|   |-- ScenarioError        a scenario file or name; carries file, line, key and value
|   |-- PlanError            a plan file
|   |   `-- MisfitError      a plan whose steps cannot be those of its scenario; carries places
|   |-- GeometryError        impossible or unusable shapes
|   |-- HandError            a robot hand that cannot be used; carries the key inside `hand`
|   |-- UnknownPlannerError  no planner of that name; carries the valid names
|   |-- UnsoundPlannerError  a planner that ignores that motions are one-way
|   `-- MissingExtraError    an optional library is not installed
|-- LimitError               a limit on time or memory is reached (command line: exit code 4)
|-- ShapeError               an array of the wrong shape, or with NaN (a caller's mistake)
|-- PathError                a planner's path does not hold when judged anew
`-- SolverError              an LP solver ended in a way that allows no verdict

ScenarioWarning              a scenario that can be used but is perhaps not what was meant
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence


class GmOmplError(Exception):
    """Base class of all exceptions raised by gm_ompl."""


class InputError(GmOmplError):
    """The input is wrong; the message says what, where and what would be right."""


class ScenarioError(InputError):
    """A scenario cannot be used.

    Attributes:
        problems: one line per mistake, each with file, line, key path, value and remedy.
    """

    def __init__(self, problems: str | Sequence[str]) -> None:
        self.problems = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(self.problems))


class ScenarioWarning(UserWarning):
    """A scenario can be used, but is perhaps not what was meant.

    Attributes:
        key: dotted path of what may be wrong, such as "motion.start".
        kind: "floats" (nearly touches what is below) or "touches nothing".
        gap: the distance, in the scenario's units of length; None where nothing is there at all.
        relative: the same over D; None likewise.
    """

    def __init__(
        self, text: str, key: str, kind: str, gap: float | None, relative: float | None
    ) -> None:
        self.key, self.kind, self.gap, self.relative = key, kind, gap, relative
        super().__init__(text)


class PlanError(InputError):
    """A plan file cannot be read."""


class MisfitError(PlanError):
    """A plan's steps cannot be those of the scenario inside it.

    Attributes:
        mistakes: per mistake the keys and indices that lead to it in the plan's file, and what is
            wrong there.
    """

    def __init__(self, mistakes: Sequence[tuple[Sequence[int | str], str]]) -> None:
        self.mistakes = tuple(mistakes)
        super().__init__(
            "\n".join(f"{'.'.join(map(str, place))}: {wrong}" for place, wrong in self.mistakes)
        )


class GeometryError(InputError):
    """A shape is impossible or cannot be used (degenerate, not convex, NaN)."""


class HandError(InputError):
    """A robot hand cannot be used.

    Attributes:
        key: keys and indices from the scenario's ``hand`` down to what is wrong.
    """

    def __init__(self, key: tuple[str | int, ...], text: str) -> None:
        self.key = key
        super().__init__(text)


class UnknownPlannerError(InputError):
    """No planner has the given name.

    Attributes:
        name: what was asked for.
        valid: the names that exist.
    """

    def __init__(self, name: str, valid: Iterable[str]) -> None:
        self.name, self.valid = name, tuple(valid)
        super().__init__(
            f"unknown planner {name!r}{did_you_mean(name, self.valid)}; "
            f"planners are: {', '.join(self.valid)}"
        )


class UnsoundPlannerError(InputError):
    """A planner does not respect that motions are one-way.

    Attributes:
        name: the planner.
        reason: what it does wrong.
    """

    def __init__(self, name: str, reason: str) -> None:
        self.name, self.reason = name, reason
        super().__init__(f"planner {name!r} is not offered, as motions here are one-way: {reason}")


class MissingExtraError(InputError):
    """An optional library is missing; the message says how to install it."""

    def __init__(self, library: str, extra: str) -> None:
        self.library, self.extra = library, extra
        super().__init__(f'{library} is not installed; run: pip install "gm-ompl[{extra}]"')


class LimitError(GmOmplError):
    """Work was broken off: a limit in force is reached, or a caller wanted no more of it.

    The text says which limit it was; it is empty where the caller knows.
    """


class ShapeError(GmOmplError):
    """An array has the wrong shape or an entry that is not finite."""

    def __init__(
        self, name: str, have: tuple[int, ...], want: tuple[int | None, ...], why: str = ""
    ) -> None:
        expected = "(" + ", ".join("any" if n is None else str(n) for n in want) + ")"
        super().__init__(f"{name}: {why or f'shape {have}, expected {expected}'}")


class PathError(GmOmplError):
    """A path that a planner offered cannot be executed."""


class SolverError(GmOmplError):
    """An LP solver returned neither an answer nor a certificate."""


def did_you_mean(name: str, valid: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the closest of ``valid``, or an empty string."""
    close = difflib.get_close_matches(name, list(valid), n=1)
    return f"; did you mean {close[0]!r}?" if close else ""
