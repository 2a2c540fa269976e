"""README.md's example does what README.md says."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

README = Path(__file__).resolve().parents[1] / "README.md"


def test_example_prints_what_is_shown() -> None:
    """The Python example, run as it stands, prints the lines that follow it."""
    blocks = re.findall(r"```(\w+)\n(.*?)```", README.read_text(), re.DOTALL)
    (_, code), (_, shown) = blocks[:2]
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, str(README), "exec"), {})
    assert printed.getvalue() == shown


def test_first_two_languages_are_python_and_text() -> None:
    """The example is the first block, its output the second."""
    languages = re.findall(r"```(\w+)\n", README.read_text())
    assert languages[:2] == ["python", "text"]
