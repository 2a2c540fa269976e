"""Compilation: announced, kept, and not done twice."""

from __future__ import annotations

import gc
import logging
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
from numba.core import caching

from gm_ompl import clock, compilation


def test_the_first_compilation_is_announced_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Without machine code of an earlier run one line says that it takes a while."""
    monkeypatch.setattr(compilation, "_announced", False)
    monkeypatch.setattr(compilation, "is_compiled", lambda: False)
    caplog.set_level(logging.INFO, "gm_ompl")
    double = compilation.compiled(_double)
    assert not caplog.records
    assert double(2) == 4
    assert double(2.0) == 4.0
    assert [record.name for record in caplog.records] == ["gm_ompl.compilation"]
    assert caplog.records[0].levelno == logging.INFO


def test_nothing_is_announced_when_machine_code_is_there(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """A later run is silent."""
    monkeypatch.setattr(compilation, "_announced", False)
    monkeypatch.setattr(compilation, "is_compiled", lambda: True)
    caplog.set_level(logging.INFO, "gm_ompl")
    assert compilation.compiled(_double)(3) == 6
    assert not caplog.records


def test_a_constant_in_a_call_compiles_nothing_anew() -> None:
    """A function that is called with constants and with variables is compiled once."""
    inner: Any = compilation.compiled(_plus)

    def outer(x: int) -> int:
        return int(inner(x, 1) + inner(x, 2) + inner(x, x))

    assert compilation.compiled(outer)(5) == 6 + 7 + 10
    assert len(inner.signatures) == 1


def test_without_a_writable_folder_there_is_no_cache(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Where the cache folder cannot be made, none is used."""
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    assert compilation._cache_folder() is None
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = compilation._cache_folder()
    assert folder is not None and folder.is_dir()


def test_without_a_home_there_is_no_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the user has no home, none is used."""
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", mock.Mock(side_effect=RuntimeError("no home")))
    assert compilation._cache_folder() is None


def test_machine_code_that_cannot_be_kept_is_used(caplog: pytest.LogCaptureFixture) -> None:
    """A full disk, or a folder that is gone, ends nothing; one line says so."""
    compilation._unsaved.cache_clear()
    functions: list[Any] = [compilation.compiled(_double), compilation.compiled(_plus)]
    with mock.patch.object(caching.IndexDataCacheFile, "save", side_effect=OSError(28, "full")):
        assert functions[0](1.5 + 0j) == 3 and functions[1](1 + 0j, 2) == 3
    assert [record.levelno for record in caplog.records].count(logging.WARNING) == 1


def test_threads_that_compile_at_once_stop_the_clock_once() -> None:
    """It never runs backwards."""
    making = compilation._Making()
    wall, counted = time.monotonic(), clock.now()
    with making, making, ThreadPoolExecutor(2) as threads:
        list(threads.map(lambda _: _inside(making), range(2)))
    wall, counted = time.monotonic() - wall, clock.now() - counted
    assert 0.0 <= counted < 0.5 * wall
    assert gc.isenabled()


def _inside(making: Any) -> None:
    with making:
        time.sleep(0.05)


def _plus(x: int, y: int) -> int:
    return x + y


def _double(x: float) -> float:
    return 2 * x


def test_budgets_do_not_pay_for_compiling() -> None:
    """The clock of time limits stands still while a function is compiled, callees included."""
    inner: Any = compilation.compiled(_plus)

    def outer(x: int) -> int:
        return int(inner(x, x))

    twice: Any = compilation.compiled(outer)
    wall, counted = time.monotonic(), clock.now()
    assert twice(3) == 6
    wall, counted = time.monotonic() - wall, clock.now() - counted
    assert 0.0 <= counted < 0.5 * wall


def _total(values: Any) -> float:
    total = 0.0
    for value in values:
        total += value
    return total


def _row(table: Any) -> Any:
    return table[0]


def _room(size: int) -> float:
    return float(np.zeros(size).sum())


def test_lean_functions_make_and_return_no_arrays() -> None:
    """Uses of arrays are not counted there: one that is made, or comes out, could be gone."""
    assert compilation.lean(_total)(np.array([1.0, 2.0])) == 3.0
    cases: list[tuple[Any, Any]] = [(_row, np.ones((2, 2))), (_room, 3)]
    for wrong, given in cases:
        with pytest.raises(Exception, match=r"returning of array|cannot allocate|nopython"):
            compilation.lean(wrong)(given)


def test_a_function_is_made_when_it_is_called() -> None:
    """What is loaded and not called costs nothing."""
    double: Any = compilation.compiled(_double)
    assert "made" not in vars(double)
    assert double.overloads == {}
    assert double(3) == 6
    assert len(double.overloads) == 1
