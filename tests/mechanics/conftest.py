"""Fixtures for tests of the kernel."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest


def _load(name: str) -> ModuleType:
    """Import a helper module beside this file; importlib mode puts no folder on the path."""
    qualified = f"gm_ompl_tests_mechanics_{name}"
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
def agreement() -> ModuleType:
    """Kernel against reference at one instant: ``agreement.compare(instant)``."""
    return _load("agreement")
