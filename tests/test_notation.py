"""docs/reference/notation.md stays true."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ROW = re.compile(r"\| `(\w+)` \| `([\w/.]+)` \|")


def test_every_name_is_defined_in_its_file() -> None:
    """The table's names are defined (a class, a function, a field) where the table says."""
    rows = ROW.findall((ROOT / "docs" / "reference" / "notation.md").read_text())
    assert len(rows) > 20
    for name, path in rows:
        definition = rf"^\s*(class|def) {name}\b|^\s*{name}:"
        source = (ROOT / path).read_text()
        assert re.search(definition, source, re.MULTILINE), (name, path)
