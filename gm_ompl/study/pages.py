"""Tables written into documentation pages, between the marks that name them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from gm_ompl.errors import InputError
from gm_ompl.writing import write_text


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a Markdown table."""
    lines = [list(head), ["---"] * len(head), *[[str(cell) for cell in row] for row in rows]]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


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


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with few digits and thousands separated; a dash for None."""
    if value is None:
        return "-"
    if isinstance(value, int) or abs(value) >= 10**digits:
        return f"{value:,.0f}"
    return f"{value:.{digits}g}"
