"""Fixtures for tests of the kernel."""

from __future__ import annotations

import importlib
from types import ModuleType

import pytest


@pytest.fixture(scope="session")
def agreement() -> ModuleType:
    """Kernel against reference at one instant: ``agreement.compare(instant)``."""
    return importlib.import_module("tests.mechanics.agreement")
