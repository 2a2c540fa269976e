"""Compiled code for callers that ask thousands of times, always with the same types."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from gm_ompl.compilation import numba_module

_Function = TypeVar("_Function", bound=Callable[..., Any])


def direct(function: _Function) -> _Function:
    """Return a compiled function that looks at its arguments' types in the first call alone.

    To tell which types tuples of arrays have takes as long as many a function. For callers whose
    arguments have the same types each time: others would be misread. See ``Types``.
    """
    code: Any = None
    types: tuple[Any, ...] = ()

    def call(*arguments: Any) -> Any:
        nonlocal code, types
        if code is None or Types.looked_at:
            code, types = _code_for(function, arguments, types)
        return code(*arguments)

    typed: Any = call
    return typed


class Types:
    """Whether types are looked at in every call of ``direct``: tests hold callers to them."""

    looked_at = False


def _code_for(
    kernel: Any, arguments: tuple[Any, ...], before: tuple[Any, ...]
) -> tuple[Any, tuple[Any, ...]]:
    """Return the machine code for arguments of these types, and the types.

    Raises:
        TypeError: they are not as before.
    """
    numba = numba_module()
    if numba.config.DISABLE_JIT:
        return kernel, ()
    types = tuple(map(numba.typeof, arguments))
    if before not in ((), types):
        raise TypeError(f"{kernel.py_func.__name__} was given {types} after {before}")
    return kernel.made.compile(types), types
