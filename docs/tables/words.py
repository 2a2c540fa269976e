"""``python -m docs.tables.words``: how many words of prose each page has, README.md included.

Tables, code, formulas, comments and what programs write (pages that say so, and what stands between
``<!-- begin NAME -->`` and ``<!-- end NAME -->``) do not count.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
MOST: Final = 15_000
"""All pages together have no more."""

WRITTEN: Final = "<!-- this page is written by a program -->"
NOT_PROSE: Final = re.compile(
    r"<!-- begin (.+?) -->.*?<!-- end \1 -->"
    r"|<!--.*?-->"
    r"|^```.*?^```$"  # code
    r"|^    .*?$"
    r"|^\|.*?$"  # tables
    r"|\$\$.*?\$\$|\$[^$\n]+\$"  # formulas
    r"|\]\([^)]*\)",  # where links lead
    re.MULTILINE | re.DOTALL,
)


def words(page: Path) -> int:
    """Return how many words of prose a page has."""
    text = page.read_text(encoding="utf-8")
    if WRITTEN in text:
        return 0
    return sum(any(map(str.isalnum, word)) for word in NOT_PROSE.sub(" ", text).split())


def pages() -> dict[str, int]:
    """Return the words of every page, by its path."""
    found = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return {page.relative_to(ROOT).as_posix(): words(page) for page in found}


def main() -> int:
    """Print the count; exit code 1 where there are too many."""
    found = pages()
    for name, count in found.items():
        sys.stdout.write(f"{count:6,} {name}\n")
    total = sum(found.values())
    sys.stdout.write(f"{total:6,} of at most {MOST:,}\n")
    return int(total > MOST)


if __name__ == "__main__":
    sys.exit(main())
