"""Compiled code by name: what one process had to load, another of the same kind can load, too."""

from __future__ import annotations

import base64
import contextlib
import importlib
import pickle
import sys
from collections.abc import Iterable, Iterator
from typing import Any, TypeAlias

Version: TypeAlias = tuple[str, str, Any]  # module, name and argument types of a compiled function


def compiled_versions() -> set[Version]:
    """Return what is compiled in this process, of the package's own functions."""
    return {
        (module, name, signature)
        for module, name, function in _compiled_functions()
        for signature in function.overloads
    }


def _compiled_functions() -> Iterator[tuple[str, str, Any]]:
    """Yield module, name and function; they are told by what numba gives them."""
    for module, contents in list(sys.modules.items()):
        if module.startswith("gm_ompl."):
            for name, value in list(vars(contents).items()):
                if hasattr(value, "py_func") and value.py_func.__module__ == module:
                    yield module, name, value


def pack(versions: Iterable[Version]) -> str:
    """Return the versions as text; what cannot be written is left out."""
    written = []
    for version in versions:
        with contextlib.suppress(pickle.PicklingError, TypeError, AttributeError):
            written.append(pickle.dumps(version))
    return base64.b64encode(pickle.dumps(written)).decode() if written else ""


def load(text: str) -> None:
    """Load what a process told with ``pack``; nothing is executed.

    Only for text from a process that this one has forked: unpickling trusts it.
    """
    for written in pickle.loads(base64.b64decode(text)):
        module, name, signature = pickle.loads(written)
        getattr(importlib.import_module(module), name).compile(signature)
