"""What pages and examples show and `make test` leaves out, because it takes long."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from tests.docs.running import blocks, pages, run_page
from tests.verify.counting import Result, count

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "docs" / "examples").glob("*.py"))
LONG = [page for page in pages() if any(block.mark == "in verify" for block in blocks(page))]


@count(instances=len(LONG))
def long_pages(instance: int) -> Result:
    """Every block of a page runs, those that take long included."""
    page = LONG[instance]
    with tempfile.TemporaryDirectory() as folder:
        try:
            run_page(page, Path(folder), long=True)
        except AssertionError as error:
            return Result(holds=False, note=f"{page.name}: {str(error)[:200]}")
    return Result(holds=True, outcome=page.stem)


@count(instances=len(EXAMPLES))
def examples(instance: int) -> Result:
    """Every example runs as a script."""
    script = EXAMPLES[instance]
    options = ["--trials", "2"] if "robustness" in script.name else []
    done = subprocess.run(
        [sys.executable, "-P", script, *options], capture_output=True, text=True, check=False
    )
    return Result(holds=done.returncode == 0, note=f"{script.name}: {done.stderr[-200:]}")
