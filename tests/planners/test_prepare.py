"""Compiling on two cores: it prepares just what searches use, and only where nothing is there."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from gm_ompl import compilation
from gm_ompl.planners import kernels, prepare
from gm_ompl.scenario.load import load

WHAT_IS_MISSING = """
import json
import os
from gm_ompl import api
from gm_ompl.planners import kernels
from gm_ompl import compiled
kernels.edges(), kernels.passes(), kernels.decision(), kernels.cells(), kernels.sweeps()
kernels.lanes(), kernels.hubs_and_routes()
before = compiled.compiled_versions()
for name, planner in (("slide", "astar"), ("regrasp", "astar"), ("regrasp", "HybridRRTConnect")):
    api.plan(f"paper/{name}", planner, max_iterations=300, time_limit=10.0)
fine = api.load("paper/regrasp", ["fingers.placements.grid=[13, 13]"])
api.plan(fine, max_iterations=300, time_limit=10.0)
missed = compiled.compiled_versions() - before
print(json.dumps([len(before), sorted(f"{module}.{name}" for module, name, _ in missed)]))
"""


def test_searches_compile_nothing_more() -> None:
    """Every function that is called from Python, with the very types that searches use."""
    ran = subprocess.run(
        [sys.executable, "-P", "-c", WHAT_IS_MISSING],
        capture_output=True,
        text=True,
        check=True,
    )
    prepared, missed = json.loads(ran.stdout)
    assert missed == []
    assert prepared > 20


class Other:
    """Stands for the other process."""

    started = 0
    stdout = io.BytesIO()

    def __init__(self, command: list[str], **_: Any) -> None:
        assert command[-1] == kernels.__name__
        Other.started += 1

    def __enter__(self) -> Other:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def wait(self) -> None:
        pass

    def kill(self) -> None:
        pass


@pytest.mark.parametrize("cold", [True, False])
def test_another_process_helps_only_where_nothing_is_compiled(
    cold: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """With machine code on disk nothing happens."""
    monkeypatch.setattr(compilation, "CACHE", tmp_path)
    monkeypatch.setattr(compilation, "is_compiled", lambda: not cold)
    monkeypatch.setattr(prepare, "cores", lambda: 2)
    for part in ("passes", "decision", "sweeps"):
        monkeypatch.setattr(kernels, part, lambda: None)
    monkeypatch.setattr(subprocess, "Popen", Other)
    Other.started, problem = 0, load("paper/slide").problem
    prepare.prepare(problem)
    assert Other.started == cold
    prepare.prepare(load("paper/slide", ["mechanics.backend=highs"]).problem)
    assert Other.started == cold


def test_one_core_compiles_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A second process could only take turns."""
    monkeypatch.setattr(compilation, "CACHE", tmp_path)
    monkeypatch.setattr(compilation, "is_compiled", lambda: False)
    monkeypatch.setattr(prepare, "cores", lambda: 1)
    monkeypatch.setattr(subprocess, "Popen", None)
    prepare.prepare(load("paper/slide").problem)


def test_where_no_process_can_be_started_searches_compile(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Python may be part of a program, or the machine have no more processes."""
    monkeypatch.setattr(compilation, "CACHE", tmp_path)
    monkeypatch.setattr(compilation, "is_compiled", lambda: False)
    monkeypatch.setattr(prepare, "cores", lambda: 2)
    for nothing in ("", str(tmp_path / "nowhere")):
        monkeypatch.setattr(sys, "executable", nothing)
        prepare.prepare(load("paper/slide").problem)
