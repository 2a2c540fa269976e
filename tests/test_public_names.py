"""The public surface: what ``gm_ompl`` offers, and that it stays what it says."""

from __future__ import annotations

import importlib
import inspect
import pkgutil

import pytest

import gm_ompl


def test_all_names_exist() -> None:
    """Every name in __all__ loads, and dir() shows it."""
    for name in gm_ompl.__all__:
        assert getattr(gm_ompl, name) is not None
        assert name in dir(gm_ompl)


def test_all_is_sorted_and_complete() -> None:
    """__all__ lists each lazily loaded name once, in order, and the version."""
    assert list(gm_ompl.__all__) == sorted(gm_ompl.__all__)
    assert set(gm_ompl.__all__) == {*gm_ompl._HOMES, "__version__"}


def test_public_functions_have_docstrings_and_types() -> None:
    """Every public function says what it does and is typed throughout."""
    for name in gm_ompl.__all__:
        value = getattr(gm_ompl, name)
        if not inspect.isroutine(value):
            continue
        assert inspect.getdoc(value), name
        signature = inspect.signature(value)
        assert signature.return_annotation is not inspect.Signature.empty, name
        for parameter in signature.parameters.values():
            assert parameter.annotation is not inspect.Parameter.empty, (name, parameter)


def test_no_package_has_the_name_of_something_public() -> None:
    """Importing one would take its place: ``gm_ompl.plan`` is a function, whatever is imported."""
    names = {module.name for module in pkgutil.iter_modules(gm_ompl.__path__)} - {"__main__"}
    assert not names & set(gm_ompl.__all__)
    for name in names:
        importlib.import_module(f"gm_ompl.{name}")
    for name in ("plan", "check", "judge", "load", "explain", "tolerate"):
        assert inspect.isfunction(getattr(gm_ompl, name)), name


def test_unknown_names_are_refused() -> None:
    """A misspelt name is an AttributeError, as for any module."""
    with pytest.raises(AttributeError, match="plam"):
        getattr(gm_ompl, "plam")  # noqa: B009 - mypy would refuse the attribute, too
