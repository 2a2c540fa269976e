"""What callers from Python hand over: numpy's numbers become Python's, wrong types are named.

Nothing else looks at types: whatever is asked for by a public function goes through here first.
"""

from __future__ import annotations

import math
import numbers
import os
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from gm_ompl.errors import InputError

Wrong = Callable[[tuple[str | int, ...], str], None]
"""Called with the keys and indices that lead to a value that cannot be used, and why."""


def kind_of(value: object) -> str:
    """Return a value and its type for a message."""
    text = repr(value)
    text = text if len(text) <= 60 else text[:57] + "..."
    return f"{text} ({type(value).__name__})"


def whole(name: str, value: object, least: int) -> int:
    """Return a whole number: Python's or numpy's, also a float without a fraction.

    Raises:
        InputError: it is something else, or less than ``least``.
    """
    number = _real(value)
    if number is None or not number.is_integer() or number < least:
        shown = value if number is not None else kind_of(value)
        raise InputError(f"{name}: {shown}: must be a whole number >= {least}")
    return int(value) if isinstance(value, numbers.Integral) else int(number)


def positive(name: str, value: object, unit: str) -> float:
    """Return a positive, finite number.

    Raises:
        InputError: it is something else.
    """
    number = _real(value)
    if number is None or not (math.isfinite(number) and number > 0.0):
        shown = value if number is not None else kind_of(value)
        raise InputError(f"{name}: {shown}: must be a positive number of {unit}")
    return number


def finite(name: str, values: object, names: Sequence[str]) -> tuple[float, ...]:
    """Return one finite number per name.

    Raises:
        InputError: there are more, fewer or something else.
    """
    wanted = f"must be finite numbers for ({', '.join(names)})"
    try:
        items = list(values)  # type: ignore[call-overload]
    except TypeError:
        raise InputError(f"{name}: {kind_of(values)}: {wanted}") from None
    found = [_real(value) for value in items]
    numbers_found = tuple(value for value in found if value is not None and math.isfinite(value))
    if isinstance(values, str) or not len(numbers_found) == len(found) == len(names):
        shown = values if isinstance(values, str) else plain(items)
        raise InputError(f"{name}: {shown}: {wanted}")
    return numbers_found


def plain(value: object, wrong: Wrong | None = None, path: tuple[str | int, ...] = ()) -> object:
    """Return ``value`` in numbers, text, lists and mappings of Python's own.

    Args:
        value: also numpy's numbers and arrays, tuples, paths, any mapping.
        wrong: told what has another type; without it, that stays as it is.
        path: where the value stands.
    """
    if isinstance(value, np.ndarray):
        value = value.tolist()
    elif isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, Mapping):
        return _mapping(value, wrong, path)
    if isinstance(value, (list, tuple)):
        return [plain(item, wrong, (*path, i)) for i, item in enumerate(value)]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if wrong is not None and not isinstance(value, (bool, int, float, str, type(None))):
        wrong(path, f"value {kind_of(value)}: must be a number, text, a list or a mapping")
    return value


def _mapping(
    value: Mapping[object, object], wrong: Wrong | None, path: tuple[str | int, ...]
) -> dict[str, object]:
    made: dict[str, object] = {}
    for key, item in value.items():
        if wrong is not None and not isinstance(key, str):
            wrong(path, f"the key {kind_of(key)} must be text")
            continue
        made[str(key)] = plain(item, wrong, (*path, str(key)))
    return made


def _real(value: object) -> float | None:
    """Return a real number as Python's float; None for all else, truth values among it."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real):
        return None
    try:
        return float(value)
    except OverflowError:
        return None
