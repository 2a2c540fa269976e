"""Compilation: the only import of numba, and where its cache lives.

Numba's own cache key knows the file of the decorated function alone: editing a helper in another
file would leave its callers' machine code stale. The cache folder is therefore named after a hash
of all sources that hold compiled functions.
"""

from __future__ import annotations

import gc
import hashlib
import logging
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, TypeVar

import numba

from gm_ompl import clock

_log = logging.getLogger(__name__)
_Function = TypeVar("_Function", bound=Callable[..., Any])


def _source_hash() -> str:
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        text = source.read_bytes()
        if b"@compiled" in text or b"@inlined" in text:
            digest.update(text)
    # Numba takes machine code of another place for stale.
    place = Path(__file__).resolve().parent
    digest.update(f"{numba.__version__} {sys.version_info[:2]} {place}".encode())
    return digest.hexdigest()[:16]


def _cache_folder() -> Path | None:
    """Return a writable folder for machine code, or None where nothing is writable."""
    home = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    folder = Path(home) / "gm_ompl" / f"kernel-{_source_hash()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".probe-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError:
        return None
    return folder


CACHE = _cache_folder()
if CACHE is None:
    _log.warning("no writable cache folder: the mechanics kernel is compiled anew in each process")
else:
    numba.config.CACHE_DIR = str(CACHE)


def _load_without_blas() -> None:
    """Load numba's array functions without SciPy's linear algebra, a tenth of a first plan.

    They load it only to see whether it is there. It is (SciPy is required), and a function that
    multiplies matrices loads it when it is compiled.
    """
    from numba.np import linalg

    asks = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        import numba.np.arraymath  # noqa: F401
    finally:
        linalg.ensure_blas = asks


_load_without_blas()


def is_compiled() -> bool:
    """Whether machine code of an earlier run is there to be loaded."""
    return CACHE is not None and any(CACHE.rglob("*.nbi"))


# A division by zero gives an infinity; a product and a sum may become one operation.
_ARITHMETIC: Final[dict[str, Any]] = {"error_model": "numpy", "fastmath": {"contract"}}

_announced = False


def announce() -> None:
    """Say that the first use takes a while, before it does."""
    global _announced
    if not _announced and not is_compiled():
        _log.info("compiling the mechanics kernel, once: this takes about a minute")
    _announced = True


_compiling = False


@contextmanager
def _making() -> Iterator[None]:
    """Make or load machine code inside the block; the budgets' clock stands still.

    Garbage waits meanwhile: looking for it takes a tenth of the time, and little is left behind.
    """
    global _compiling
    if _compiling:  # a callee: its time is its caller's
        yield
        return
    announce()
    collects, started = gc.isenabled(), time.monotonic()
    _compiling = True
    gc.disable()
    try:
        yield
    finally:
        _compiling = False
        if collects:
            gc.enable()
        clock.stand_still(time.monotonic() - started)


def compiled(function: _Function) -> _Function:
    """Compile ``function`` on first call; the machine code is kept for later runs."""
    jitted = numba.njit(cache=CACHE is not None, nogil=True, no_cfunc_wrapper=True, **_ARITHMETIC)(
        function
    )
    if not numba.config.DISABLE_JIT:
        general = jitted.compile

        def compile_once(signature: Any) -> Any:
            # Else numba compiles anew, callers included, for every constant in a call.
            arguments, _ = numba.core.sigutils.normalize_signature(signature)
            with _making():
                return general(tuple(map(numba.types.unliteral, arguments)))

        jitted.compile = compile_once
    typed: _Function = jitted
    return typed


def inlined(function: _Function) -> _Function:
    """Compile ``function`` into each of its callers.

    For what is called in the innermost loops; and for large functions with one caller, since a
    compiled callee's code is optimised anew within each caller.
    """
    typed: _Function = numba.njit(inline="always", nogil=True, **_ARITHMETIC)(function)
    return typed
