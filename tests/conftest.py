"""Fixtures shared by all tests."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

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


BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ["--no-sandbox", "--enable-unsafe-swiftshader"]


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Headless Chromium; where it is missing the test is skipped, but under CI=true fails."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    problem = "" if found else "no Chromium; on Debian or Ubuntu: apt-get install chromium"
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        problem = "playwright is not installed"
    if problem:
        if os.environ.get("CI") == "true":
            pytest.fail(problem)
        pytest.skip(problem)
    with sync_playwright() as driver:
        program = driver.chromium.launch(executable_path=found, args=FLAGS)
        yield program
        program.close()
