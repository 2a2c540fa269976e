"""docs/meshes.md: the cylinder's table is what its program prints, and it converges."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[1] / "docs" / "meshes.md"


def table(text: str) -> list[list[float]]:
    rows = re.findall(r"^\| \d.*\|$", text, re.M)
    return [[float(cell) for cell in row.strip("|").split("|")] for row in rows]


def test_the_table_of_the_cylinder(capsys: pytest.CaptureFixture[str]) -> None:
    """Run as printed, the program prints its table; each z is within 8 / n^2 of that with 192."""
    page = PAGE.read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", page, re.S)
    exec(compile(program, str(PAGE), "exec"), {})
    shown, computed = table(page), table(capsys.readouterr().out)
    assert [row[0] for row in shown] == [12, 24, 48, 96, 192]
    for row, want in zip(shown, computed, strict=True):
        assert row == pytest.approx(want, abs=2e-3)
    for n, *values in computed[:-1]:
        for z, limit in zip(values, computed[-1][1:], strict=True):
            assert abs(z - limit) <= 8.0 / n**2 * limit
