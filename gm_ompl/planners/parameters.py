"""A planner's parameters: declared with range and meaning, checked when given."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

from gm_ompl.arguments import kind_of, plain
from gm_ompl.errors import InputError, did_you_mean

Value: TypeAlias = float | int | bool | str


@dataclass(frozen=True)
class Parameter:
    """One named setting of a planner.

    Attributes:
        name: what users call it.
        kind: ``float``, ``int``, ``bool`` or ``str``.
        default: its value where none is given.
        meaning: one sentence for the user.
        low: least value (numbers only), or None.
        high: greatest value (numbers only), or None.
        choices: the values a ``str`` may take.
        logarithmic: whether a search over values should go by factors rather than by steps.
        was: what it was called before; refused with its present name.
    """

    name: str
    kind: type[float] | type[int] | type[bool] | type[str]
    default: Value
    meaning: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    logarithmic: bool = False
    was: str = ""

    def checked(self, value: object) -> Value:
        """Return ``value`` in this parameter's type.

        Raises:
            InputError: type or range is wrong; the message names both.
        """
        value = plain(value)  # numpy's numbers are Python's
        if self.kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        # bool is a subclass of int, yet no whole number.
        if not isinstance(value, self.kind) or (self.kind is int and isinstance(value, bool)):
            raise InputError(f"parameter {self.name}: {value!r}: must be {self.range()}")
        low = -math.inf if self.low is None else self.low
        high = math.inf if self.high is None else self.high
        inside = value in self.choices if isinstance(value, str) else low <= value <= high
        if not inside or (isinstance(value, float) and not math.isfinite(value)):
            raise InputError(f"parameter {self.name}: {value!r}: must be {self.range()}")
        return value

    def range(self) -> str:
        """Return in words what values are accepted."""
        if self.kind is bool:
            return "true or false"
        if self.kind is str:
            return "one of " + ", ".join(self.choices)
        noun = "a whole number" if self.kind is int else "a number"
        if self.low is not None and self.high is not None:
            return f"{noun} from {self.low:g} to {self.high:g}"
        if self.low is not None:
            return f"{noun} of at least {self.low:g}"
        return noun if self.high is None else f"{noun} of at most {self.high:g}"


def parameters_of(settings: type[Any]) -> tuple[Parameter, ...]:
    """Return the parameters that the fields of settings are, their metadata telling the rest."""
    return tuple(
        Parameter(name, type(default), default, **item.metadata)
        for item in dataclasses.fields(settings)
        for name, default in [(item.name, cast(Value, item.default))]
    )


def checked(
    planner: str, declared: Sequence[Parameter], given: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the value of every declared parameter: as given, else its default.

    Args:
        planner: the planner's name, for messages.
        declared: the planner's parameters.
        given: values by name.

    Raises:
        InputError: a name is unknown, or a value is of the wrong type or out of range.
    """
    if not isinstance(given, Mapping):
        raise InputError(f"parameters: {kind_of(given)}: must be a mapping of names to values")
    known = {parameter.name: parameter for parameter in declared}
    for name in given:
        if name not in known:
            offer = f"it has: {', '.join(known)}" if known else "it has none"
            now = [parameter.name for parameter in declared if parameter.was == name]
            hint = f"; it is called {now[0]!r} now" if now else did_you_mean(str(name), known)
            raise InputError(f"planner {planner!r}: unknown parameter {name!r}{hint}; {offer}")
    values = {name: parameter.default for name, parameter in known.items()}
    for name, value in given.items():
        try:
            values[name] = known[name].checked(value)
        except InputError as error:
            raise InputError(f"planner {planner!r}: {error}") from None
    return values
