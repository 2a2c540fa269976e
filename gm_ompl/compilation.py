"""Compilation: the only import of numba, and where its cache lives.

Numba's own cache key knows the file of the decorated function alone: editing a helper in another
file would leave its callers' machine code stale. The cache folder is therefore named after a hash
of all sources that hold compiled functions.
"""

from __future__ import annotations

import functools
import gc
import hashlib
import logging
import os
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, TypeVar, final

from gm_ompl import clock

_log = logging.getLogger(__name__)
MARKS: Final = re.compile(rb"@(compiled|inlined|lean)")
"""What a file holds that has compiled functions."""

_Function = TypeVar("_Function", bound=Callable[..., Any])


def _sources(folder: str) -> Iterator[tuple[str, bytes]]:
    """Yield the files below a folder that hold compiled functions."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                yield from _sources(entry.path)
            elif entry.name.endswith(".py"):
                with open(entry.path, "rb") as file:
                    text = file.read()
                if MARKS.search(text):
                    yield entry.path, text


def _source_hash() -> str:
    digest = hashlib.sha256()
    place = Path(__file__).resolve().parent
    for _, text in sorted(_sources(str(place))):
        digest.update(text)
    numba = find_spec("numba")
    if numba is not None and numba.origin is not None:
        digest.update(Path(numba.origin).with_name("_version.py").read_bytes())
    # Numba takes machine code of another place for stale.
    digest.update(f"{sys.version_info[:2]} {place}".encode())
    return digest.hexdigest()[:16]


def _cache_folder() -> Path | None:
    """Return a writable folder for machine code, or None where nothing is writable."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
        folder = Path(home) / "gm_ompl" / f"kernel-{_source_hash()}"
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".probe-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except (OSError, RuntimeError):  # the user may have no home
        return None
    return folder


CACHE = _cache_folder()
if CACHE is None:
    _log.warning("no writable cache folder: the mechanics kernel is compiled anew in each process")


@functools.cache
def numba_module() -> Any:
    """Load numba, without SciPy's linear algebra: a tenth of a first plan.

    Its array functions load that only to see whether it is there. It is (SciPy is required), and a
    function that multiplies matrices loads it when it is compiled.
    """
    import numba

    if CACHE is not None:
        numba.config.CACHE_DIR = str(CACHE)
    from numba.np import linalg

    asks = getattr(linalg, "ensure_blas", None)
    if asks is not None:  # another numba may not ask at all
        linalg.ensure_blas = lambda: None
        try:
            import numba.np.arraymath
        finally:
            linalg.ensure_blas = asks
    return numba


def is_compiled() -> bool:
    """Whether machine code of an earlier run is there to be loaded."""
    return CACHE is not None and any(CACHE.rglob("*.nbi"))


# A division by zero gives an infinity; a product and a sum may become one operation.
_ARITHMETIC: Final[dict[str, Any]] = {"error_model": "numpy", "fastmath": {"contract"}}

_announced = False


def announce() -> None:
    """Say that the first use takes a while, before it does."""
    global _announced
    known, _announced = _announced, True
    if not known and not is_compiled():
        _log.info("compiling the mechanics kernel, once: this takes about a minute")


@final
class _Making:
    """Machine code is made or loaded inside the block; the budgets' clock stands still.

    Garbage waits meanwhile: looking for it takes a tenth of the time, and little is left behind.
    Callees and other threads may be inside as well: their time counts once.
    """

    def __init__(self) -> None:
        self._lock, self._inside = threading.Lock(), 0
        self._collects, self._started = False, 0.0

    def __enter__(self) -> None:
        announce()
        with self._lock:
            self._inside += 1
            if self._inside == 1:
                self._collects, self._started = gc.isenabled(), time.monotonic()
                gc.disable()

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                if self._collects:
                    gc.enable()
                clock.stand_still(time.monotonic() - self._started)


_MAKING: Final = _Making()


_LOCK: Final = threading.RLock()
"""Held while numba is loaded, or makes a function: threads may call the same one first."""


def _saving(save: Callable[..., None]) -> Callable[..., None]:
    """Return what saves machine code where it can: a full disk ends no search."""

    def saved(*arguments: Any) -> None:
        try:
            save(*arguments)
        except OSError as error:
            _unsaved(str(error.strerror))

    return saved


@functools.cache
def _unsaved(why: str) -> None:
    """Say so, once."""
    _log.warning("machine code cannot be kept in %s (%s): it will be compiled anew", CACHE, why)


@final
class Kernel:
    """A function that numba makes when it is first called, or when a caller is compiled.

    To numba it is what numba makes of it. Most of what a process loads it never calls, and each
    costs as much as reading a file.

    Attributes:
        py_func: the function.
    """

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        functools.update_wrapper(self, function)
        self.py_func, self._options = function, options

    def __call__(self, *arguments: Any) -> Any:
        """Call the machine code for these types of arguments."""
        return self.made(*arguments)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.made, name)

    @cached_property
    def made(self) -> Any:
        """What numba makes of the function."""
        with _LOCK:
            known = vars(self).get("made")
            if known is None:
                known = vars(self)["made"] = self._make()
        return known

    def _make(self) -> Any:
        numba = numba_module()
        jitted = numba.njit(nogil=True, **{**_ARITHMETIC, **self._options})(self.py_func)
        if not numba.config.DISABLE_JIT:
            general = jitted.compile

            def compile_once(signature: Any) -> Any:
                # Else numba compiles anew, callers included, for every constant in a call.
                arguments, _ = numba.core.sigutils.normalize_signature(signature)
                with _MAKING:
                    return general(tuple(map(numba.types.unliteral, arguments)))

            jitted.compile = compile_once
            if self._options.get("cache"):
                jitted._cache.save_overload = _saving(jitted._cache.save_overload)
        return jitted

    @property
    def overloads(self) -> Any:
        """The types of arguments for which there is machine code."""
        return self.made.overloads if "made" in vars(self) else {}


def compiled(function: _Function) -> _Function:
    """Compile ``function`` on first call; the machine code is kept for later runs."""
    typed: Any = Kernel(function, cache=CACHE is not None, no_cfunc_wrapper=True)
    return typed


def compiled_as_written(function: _Function) -> _Function:
    """Compile ``function`` likewise, each sum and product rounded by itself, as Python does it."""
    options = {"cache": CACHE is not None, "no_cfunc_wrapper": True, "fastmath": False}
    typed: Any = Kernel(function, **options)
    return typed


def lean(function: _Function) -> _Function:
    """Compile ``function``, uses of its arrays not counted: most of the time of a short loop.

    For what makes no array, returns none, and calls nothing that does: what it calls is made alike.
    """
    options = {"cache": CACHE is not None, "no_cfunc_wrapper": True, "_nrt": False}
    typed: Any = Kernel(function, **options)
    return typed


def inlined(function: _Function) -> _Function:
    """Compile ``function`` into each of its callers.

    For what is called in the innermost loops; and for large functions with one caller, since a
    compiled callee's code is optimised anew within each caller.
    """
    typed: Any = Kernel(function, inline="always")
    return typed
