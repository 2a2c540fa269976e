"""Runs what pages show: their blocks, in order, in a folder of their own.

A block is run as it stands. A comment before it says otherwise::

    <!-- in verify -->            it takes long: `python -m tests.verify pages` runs it
    <!-- elsewhere: why -->       it needs another machine, a network, or a person
    <!-- exit code: 3 -->         commands end with this

``yaml`` with a title is written to that file; ``python`` blocks of a page share their names, and a
``text`` block after one is what it prints.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from typer.testing import CliRunner

from gm_ompl.app.main import app

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
FENCE = re.compile(
    r"(?:^<!-- (?P<mark>[^>]*?) -->\n)?^```(?P<language>\w+)(?: title=\"(?P<title>[^\"]+)\")?\n"
    r"(?P<code>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
SNIPPET = re.compile(r"^--8<--\n(.+)\n--8<--\n", re.MULTILINE)
BREAK = "\x1e"
"""Printed between two blocks of Python."""


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes:
        language: what it is written in.
        title: the file that it is, or "".
        mark: the comment before it, or "".
        code: its text, snippets put in.
    """

    language: str
    title: str
    mark: str
    code: str

    @property
    def exit_code(self) -> int:
        """What its commands end with."""
        return int(self.mark.split(":")[1]) if self.mark.startswith("exit code") else 0

    def runs(self, long: bool) -> bool:
        """Whether it is to be run: among what is quick, or among what takes ``long``."""
        return not self.mark.startswith("elsewhere") and (long or self.mark != "in verify")


def pages() -> list[Path]:
    """Return all pages, README.md first."""
    return [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


def blocks(page: Path) -> Iterator[Block]:
    """Yield a page's blocks in order."""
    for found in FENCE.finditer(page.read_text(encoding="utf-8")):
        code = SNIPPET.sub(lambda one: (DOCS / one[1]).read_text(), found["code"])
        yield Block(found["language"], found["title"] or "", found["mark"] or "", code)


def run_page(page: Path, folder: Path, long: bool = False) -> None:
    """Run a page's blocks in ``folder``; with ``long`` those that take long as well.

    Raises:
        AssertionError: a command ends otherwise than it should, or Python prints something else
            than what is shown.
    """
    for part in (DOCS / "examples").glob("*.stl"):
        shutil.copy(part, folder)
    shown = list(blocks(page))
    here = [(one, following) for one, following in zip(shown, [*shown[1:], None], strict=False)
            if one.runs(long)]  # fmt: skip
    with contextlib.chdir(folder):
        for block, _ in here:
            if block.title:
                Path(block.title).write_text(block.code)
            elif block.language == "sh":
                for line in block.code.splitlines():
                    _command(line, block.exit_code)
        python = [(one.code, after) for one, after in here if one.language == "python"]
        if python:
            printed = _python([code for code, _ in python])
            for (code, after), text in zip(python, printed, strict=True):
                if after is not None and after.language == "text":
                    assert text == after.code, f"{code}\nprints\n{text}"


def _command(line: str, wanted: int) -> None:
    words = shlex.split(line, comments=True)
    if not words:
        return
    if words[0] == "gm-ompl" and "|" not in words and ">" not in words:
        done = CliRunner().invoke(app, words[1:])
        assert done.exit_code == wanted, f"{line}\n{done.output}"
        return
    command = f"{shlex.quote(sys.executable)} -P -m gm_ompl"
    run = subprocess.run(
        ["sh", "-c", re.sub(r"\bgm-ompl\b", command, line)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == wanted, f"{line}\n{run.stderr}"


def _python(codes: list[str]) -> list[str]:
    """Return what each block prints; OMPL's in a process of its own, for its global seeds."""
    if not any(re.search(r"\b(ompl|setup)\b", code) for code in codes):
        names: dict[str, object] = {"__name__": "page"}
        printed = []
        for code in codes:
            with contextlib.redirect_stdout(io.StringIO()) as caught:
                exec(compile(code, "page", "exec"), names)
            printed.append(caught.getvalue())
        return printed
    script = f"\nprint(end={BREAK!r})\n".join(codes)
    done = subprocess.run(
        [sys.executable, "-P", "-c", script], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONWARNINGS": "error"},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout.split(BREAK)
