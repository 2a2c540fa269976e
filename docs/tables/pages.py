"""Tables written into documentation pages, between the marks that name them."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from gm_ompl.errors import InputError
from gm_ompl.study.report import table
from gm_ompl.writing import write_text


def write_page(name: str, tables: Mapping[str, Iterable[str]]) -> None:
    """Write ``docs/results/NAME.md``, or the page named on the command line, as its tables grow.

    Args:
        name: of the page.
        tables: by their marks, each table longer and longer: a call that is stopped leaves what it
            has measured.
    """
    page = Path(sys.argv[1] if len(sys.argv) > 1 else f"docs/results/{name}.md")
    for mark, growing in tables.items():
        for content in growing:
            write_tables(page, {mark: content})


def growing(head: Sequence[str], rows: Iterable[Sequence[object]]) -> Iterator[str]:
    """Yield a Markdown table as its rows come, longer and longer."""
    known: list[Sequence[object]] = []
    for row in rows:
        known.append(row)
        yield table(head, known)


def write_tables(page: Path, tables: Mapping[str, str]) -> None:
    """Put each table between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``.

    Raises:
        InputError: the page has no such marks.
    """
    text = page.read_text(encoding="utf-8")
    for name, content in tables.items():
        marks = re.compile(rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
        parts = marks.search(text)
        if parts is None:
            raise InputError(f"{page}: has no <!-- begin {name} --> ... <!-- end {name} -->")
        text = text[: parts.start()] + parts[1] + content + parts[2] + text[parts.end() :]
    write_text(page, text)
