"""docs/planar.md: the table is what its program prints, and z converges from below in it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[1] / "docs" / "planar.md"


def table(text: str) -> list[list[float]]:
    rows = re.findall(r"^\| \d.*\|$", text, re.M)
    return [[float(cell) for cell in row.strip("|").split("|")] for row in rows]


def test_the_table_of_patch_points(capsys: pytest.CaptureFixture[str]) -> None:
    """Run as printed, the page's program prints its table; each column grows to its limit."""
    page = PAGE.read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", page, re.S)
    exec(compile(program, str(PAGE), "exec"), {})
    shown, computed = table(page), table(capsys.readouterr().out)
    assert [row[0] for row in shown] == [0, 1, 2, 4, 8]
    for row, want in zip(shown, computed, strict=True):
        assert row == pytest.approx(want, abs=2e-3)
    for column in list(zip(*computed, strict=True))[1:]:
        assert list(column[1:]) == sorted(column[1:]) and column[0] <= column[1] + 1e-9
        assert column[4] - column[3] <= 0.1 * (column[4] - column[0])
