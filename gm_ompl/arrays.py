"""Array aliases, arrays made read-only, and arrays that grow."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias, TypeGuard, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gm_ompl.errors import ShapeError

Array: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]

Rows = TypeVar("Rows", bound=NDArray[Any])


def with_room(rows: Rows, count: int, wanted: int, fill: int | None = None) -> Rows:
    """Return rows with room for as many as wanted: themselves, or the first of them in new ones.

    Args:
        rows: (room, ...).
        count: how many of them are in use.
        wanted: how many will be.
        fill: what new rows are filled with; None leaves them as they come.
    """
    if wanted <= len(rows):
        return rows
    grown: Any = np.empty((max(2 * len(rows), wanted), *rows.shape[1:]), rows.dtype)
    grown[:count] = rows[:count]
    if fill is not None:
        grown[count:] = fill
    found: Rows = grown
    return found


def read_only(values: ArrayLike, shape: Sequence[int | None], name: str) -> Array:
    """Return ``values`` as a read-only float64 array, its shape checked: a copy, or itself.

    An array that owns its numbers and is read-only already comes back as it is.

    Args:
        values: numbers to copy.
        shape: expected length per axis; ``None`` accepts any length.
        name: what to call the array in the error message.

    Raises:
        ShapeError: the shape differs, or an entry is NaN or infinite.
    """
    array = values if _is_fixed(values) else np.array(values, dtype=np.float64)
    if array.shape != shape:
        array = _fitting(array, shape, name)
    # Where the sum of squares is finite all entries are, and it is quicker found.
    if not math.isfinite(np.vdot(array, array)) and not np.isfinite(array).all():
        raise ShapeError(name, array.shape, tuple(shape), "an entry is NaN or infinite")
    array.flags.writeable = False
    return array


def _fitting(array: Array, shape: Sequence[int | None], name: str) -> Array:
    """Return ``array``, given the columns that it should have where it has no rows.

    Raises:
        ShapeError: its shape is another.
    """
    if array.size == 0 and len(shape) == 2 and shape[1] is not None:
        array = array.reshape(0, shape[1])
    if array.ndim != len(shape):
        raise ShapeError(name, array.shape, tuple(shape))
    for have, want in zip(array.shape, shape, strict=True):
        if want is not None and have != want:
            raise ShapeError(name, array.shape, tuple(shape))
    return array


def fix(frozen: object, **shapes: Sequence[int | None]) -> None:
    """Make fields of a frozen dataclass read-only arrays of these shapes; see ``read_only``."""
    fields = vars(frozen)
    for name, shape in shapes.items():
        fields[name] = read_only(fields[name], shape, name)


def rows_of(array: IntArray) -> Iterator[tuple[int, ...]]:
    """Return the rows of an array (L, n) as tuples, each made when it is asked for.

    Lists and tuples of all rows at once are many objects for the garbage collector to look at.
    """
    if not array.shape[1]:
        return itertools.repeat((), len(array))
    return zip(*array.T.tolist(), strict=True)


def surfaces_of(surfaces: IntArray, count: int) -> IntArray:
    """Return what each of ``count`` contacts touches; all zero where it was left out.

    Raises:
        ShapeError: the length differs, though some are not zero.
    """
    if len(surfaces) == count:
        return surfaces
    if surfaces.any():
        raise ShapeError("surfaces", surfaces.shape, (count,))
    return np.zeros(count, dtype=np.int64)


def _is_fixed(values: ArrayLike) -> TypeGuard[Array]:
    return (
        type(values) is np.ndarray
        and values.base is None
        and not values.flags.writeable
        and values.dtype == np.float64
    )


def unit(vector: ArrayLike) -> Array:
    """Return ``vector`` scaled to length 1, shape (k,)."""
    array = np.asarray(vector, dtype=np.float64)
    scaled: Array = array / np.linalg.norm(array)
    return scaled


def cross(a: Array, b: Array) -> Array:
    """Return a x b for vectors (..., 3), broadcast.

    numpy's own treats axes in any place, and costs several times as much on the few vectors that
    one pose or one contact state has.
    """
    product = np.empty(a.shape if a.shape == b.shape else np.broadcast_shapes(a.shape, b.shape))
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    product[..., 0], product[..., 1], product[..., 2] = y * w - z * v, z * u - x * w, x * v - y * u
    return product
