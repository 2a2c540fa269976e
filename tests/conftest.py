"""Fixtures shared by all tests."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

# What writes the pages is imported from the checkout also where the package comes from a wheel.
_docs = ModuleType("docs")
_docs.__path__ = [str(Path(__file__).resolve().parents[1] / "docs")]
sys.modules.setdefault("docs", _docs)


def _load(name: str) -> ModuleType:
    """Import a helper module beside this file; importlib mode puts no folder on the path."""
    qualified = f"gm_ompl_tests_{name}"
    if qualified not in sys.modules:
        spec = importlib.util.spec_from_file_location(
            qualified, Path(__file__).with_name(f"{name}.py")
        )
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[qualified] = module
        spec.loader.exec_module(module)
    return sys.modules[qualified]


@pytest.fixture(scope="session")
def instances() -> ModuleType:
    """Random instants of manipulation: ``instances.random_instance(rng)`` and changes of unit."""
    return _load("instances")
