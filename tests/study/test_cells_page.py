"""The page of ever finer grids of placements."""

from __future__ import annotations

from pathlib import Path

from docs.tables import cells

PAGE = Path(__file__).parents[2] / "docs" / "results" / "cells.md"


def test_the_exponent_is_the_slope() -> None:
    """Of times that grow as the cube root of the sets the exponent is a third."""
    points = [(m**3, 0.01 * m) for m in (10, 100, 1000)]
    assert list(cells.exponents({"paper/slide": points})) == [("`paper/slide`", "0.33")]


def test_the_page_has_a_row_per_search() -> None:
    """Every scenario stands there on every grid, and all over cells are proven."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    for scenario in cells.SCENARIOS:
        for m in cells.GRIDS:
            (line,) = [line for line in lines if line.startswith(f"| `{scenario}` | {m} x {m} | 2")]
            assert "| proven optimal |" in line
    for n in cells.FINGERS:
        assert any(line.startswith(f"| `paper/tumble` | 9 x 9 | {n} |") for line in lines)
