"""The workflows on GitHub: they parse, run what they should, and say what the project says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def read(name: str) -> dict[str, Any]:
    text = (ROOT / ".github" / "workflows" / name).read_text()
    # As GitHub reads it, `on` is a word, not a truth value.
    tree: dict[str, Any] = yaml.load(text, Loader=yaml.BaseLoader)
    return tree


def supported() -> list[str]:
    """Return the Pythons that pyproject.toml's requires-python lets in."""
    text = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["requires-python"]
    low, end = re.fullmatch(r">=3\.(\d+),<3\.(\d+)", text).groups()  # type: ignore[union-attr]
    return [f"3.{minor}" for minor in range(int(low), int(end))]


def commands(job: dict[str, Any]) -> str:
    return "\n".join(step.get("run", "") for step in job["steps"])


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_a_workflow_has_a_start_few_rights_and_pinned_actions(path: Path) -> None:
    """Each starts on pushes and pull requests, may only read, and takes actions by version."""
    tree = read(path.name)
    assert {"push", "pull_request"} <= set(tree["on"])
    assert tree["permissions"] == {"contents": "read"}
    for job in tree["jobs"].values():
        assert int(job["timeout-minutes"]) <= 60
        actions = [step["uses"] for step in job["steps"] if "uses" in step]
        assert actions
        assert [use for use in actions if not re.fullmatch(r"[\w-]+/[\w-]+@v\d+", use)] == []


def test_checks_run_on_every_supported_python() -> None:
    """.ci/run is run with each Python of requires-python, by name."""
    job = read("checks.yml")["jobs"]["checks"]
    assert job["strategy"]["matrix"]["python-version"] == supported()
    (step,) = [step for step in job["steps"] if step.get("run") == ".ci/run"]
    assert step["env"] == {"GM_OMPL_PYTHON": "python${{ matrix.python-version }}"}


def test_the_wheel_is_tried_on_both_systems() -> None:
    """The wheel is built, installed alone and plans and checks, on Linux and on macOS >= 15."""
    job = read("wheel.yml")["jobs"]["wheel"]
    matrix = job["strategy"]["matrix"]
    assert set(matrix["python-version"]) <= set(supported())
    systems = dict(name.split("-", 1) for name in matrix["os"])
    assert set(systems) == {"ubuntu", "macos"} and int(systems["macos"]) >= 15
    text = commands(job)
    for part in ("-m build ", ".whl", "--version", " list", " plan paper/push -o", " check "):
        assert part in text, part


def test_a_named_python_is_taken_or_refused() -> None:
    """GM_OMPL_PYTHON decides for .ci/find-python; what cannot be is refused by name."""
    taken, refused = find(sys.executable), find("no-such-python")
    assert (taken.returncode, taken.stdout.strip()) == (0, sys.executable)
    assert (refused.returncode, refused.stdout) == (1, "")
    assert "GM_OMPL_PYTHON=no-such-python" in refused.stderr
    assert "GM_OMPL_PYTHON" in (ROOT / ".ci" / "run").read_text()


def test_find_python_accepts_what_the_project_supports() -> None:
    """.ci/find-python names the supported Pythons, no more and no fewer."""
    text = (ROOT / ".ci" / "find-python").read_text()
    assert sorted(set(re.findall(r"python(3\.\d+)", text))) == supported()


def find(python: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [ROOT / ".ci" / "find-python"], env={**os.environ, "GM_OMPL_PYTHON": python},
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
