"""The examples run as scripts; their notebooks are the same, and one runs in Jupyter."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from docs.tables.notebooks import EXAMPLES, SCRIPT, notebook

SCRIPTS = sorted(EXAMPLES.glob("*.py"))
LONG = {"03", "04", "06", "07", "08", "09", "12"}
"""Left to `python -m tests.verify examples`; OMPL's are run as blocks of a page, too."""

DEPENDENCIES = {"gm-ompl", "gm-ompl[plot]", "gm-ompl[view,plot]", "gm-ompl[sim]"}


def test_there_are_a_dozen() -> None:
    """Numbered from 01 on, without gaps."""
    assert [path.stem[:2] for path in SCRIPTS] == [f"{k:02d}" for k in range(1, 13)]


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_it_says_what_it_needs(script: Path) -> None:
    """PEP 723: the block is TOML with Python's versions and the package with its extras."""
    found = SCRIPT.fullmatch(script.read_text())
    assert found is not None
    lines = [line.removeprefix("#").strip() for line in found["needs"].splitlines()[1:-1]]
    needs = tomllib.loads("\n".join(lines))
    assert needs["requires-python"] == ">=3.11,<3.14"
    assert set(needs["dependencies"]) <= DEPENDENCIES


@pytest.mark.parametrize(
    "script", [path for path in SCRIPTS if path.stem[:2] not in LONG], ids=lambda path: path.stem
)
def test_it_runs(script: Path) -> None:
    """It ends well, prints something, and nothing warns."""
    done = subprocess.run(
        [sys.executable, "-P", "-W", "error", script], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.strip()


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_its_notebook_is_the_same(script: Path) -> None:
    """`python -m docs.tables.notebooks` writes it anew."""
    made = EXAMPLES / "notebooks" / f"{script.stem}.ipynb"
    assert made.read_text() == notebook(script.read_text())


def test_a_notebook_runs_in_jupyter_with_the_scene_inline(tmp_path: Path) -> None:
    """The plan's cell shows a picture and a table, the last one meshcat's scene in a frame."""
    import nbformat
    from nbclient import NotebookClient

    read: Any = nbformat.read(EXAMPLES / "notebooks" / "01_first_plan.ipynb", as_version=4)  # type: ignore[no-untyped-call]
    client: Any = NotebookClient(
        read, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    shown = [
        output["data"]["text/html"]
        for cell in read.cells
        for output in cell.get("outputs", ())
        if "text/html" in output.get("data", {})
    ]
    assert len(shown) == 2
    assert "data:image/svg+xml" in shown[0] and "proven optimal" in shown[0]
    assert shown[1].startswith("<iframe") and "meshcat" in shown[1]
