"""Fixtures shared by all tests."""

from __future__ import annotations

import importlib
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


@pytest.fixture(scope="session")
def instances() -> ModuleType:
    """Random instants of manipulation: ``instances.random_instance(rng)`` and changes of unit."""
    return importlib.import_module("tests.instances")


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
