"""docs/ompl.md's examples do what the page says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"


@pytest.mark.parametrize(("number", "name"), [(0, "ompl_example"), (1, "planner_data_example")])
def test_example_is_the_file_and_prints_what_is_shown(number: int, name: str) -> None:
    """Each example is its file, whose output, errors included, is the block after it."""
    file = DOCS / "examples" / f"{name}.py"
    blocks = re.findall(r"```(\w+)\n(.*?)```", (DOCS / "ompl.md").read_text(), re.DOTALL)
    assert len(blocks) == 4
    code, output = blocks[2 * number : 2 * number + 2]
    assert code == ("python", file.read_text())
    done = subprocess.run(
        [sys.executable, file], capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert ("text", done.stdout) == output
