"""docs/ompl.md's example does what the page says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"


def test_example_is_the_file_and_prints_what_is_shown() -> None:
    """The first example is the file, whose output, errors included, is the block after it."""
    file = DOCS / "examples" / "ompl_example.py"
    blocks = re.findall(r"```(\w+)\n(.*?)```", (DOCS / "ompl.md").read_text(), re.DOTALL)
    assert blocks[0] == ("python", file.read_text())
    done = subprocess.run(
        [sys.executable, file], capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert ("text", done.stdout) == blocks[1]
