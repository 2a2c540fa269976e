"""The way out of the command: exit codes, closed streams, and who looks on."""

from __future__ import annotations

import pstats
import subprocess
import sys
from pathlib import Path

import pytest

from gm_ompl.scenario.load import shipped

COMMAND = (sys.executable, "-P", "-m", "gm_ompl")


@pytest.mark.parametrize(("closed", "verb", "code"), [
    (">&-", "list", 0), ("2>&-", "list", 0), ("<&-", "list", 0), (">&- 2>&- <&-", "list", 0),
    (">&-", "check no-such-file", 2), ("2>&-", "check no-such-file", 2),
])  # fmt: skip
def test_closed_streams_change_no_exit_code(closed: str, verb: str, code: int) -> None:
    """As cron and daemons start programs."""
    shell = f'"$@" {verb} {closed}'
    done = subprocess.run(["sh", "-c", shell, "sh", *COMMAND], capture_output=True, timeout=60)
    assert (done.returncode, done.stderr.count(b"Traceback")) == (code, 0)


def test_all_output_arrives_in_a_pipe() -> None:
    """What was written last, too, though the process ends at once."""
    done = subprocess.run([*COMMAND, "list"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1].startswith(max(shipped()))


def test_what_is_registered_for_the_end_is_done() -> None:
    """An exit function runs, and what it writes arrives."""
    code = "import atexit; atexit.register(print, 'the end'); import gm_ompl.app.main as m; m.run()"
    done = subprocess.run(
        [sys.executable, "-P", "-c", code, "--version"], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "the end")


def test_a_profiler_gets_what_it_came_for(tmp_path: Path) -> None:
    """Whoever looks on is given the time to write."""
    file = tmp_path / "profile"
    watched = (sys.executable, "-P", "-m", "cProfile", "-o", str(file), "-m", "gm_ompl", "list")
    subprocess.run(watched, capture_output=True, check=True, timeout=60)
    assert pstats.Stats(str(file)).total_calls > 1000  # type: ignore[attr-defined]
