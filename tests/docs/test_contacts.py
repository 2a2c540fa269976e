"""docs/results/contacts.md: its tables are what its programs print, and they converge."""

from __future__ import annotations

import re

import pytest

from tests.docs.running import DOCS, blocks

PAGE = DOCS / "results" / "contacts.md"
PATCH, CYLINDER = (block.code for block in blocks(PAGE))


def table(text: str) -> list[list[float]]:
    rows = re.findall(r"^\| \d.*\|$", text, re.M)
    return [[float(cell) for cell in row.strip("|").split("|")] for row in rows]


def compared(program: str, section: str, capsys: pytest.CaptureFixture[str]) -> list[list[float]]:
    """Run a program and return its table, once it is that of the section."""
    exec(compile(program, str(PAGE), "exec"), {})
    shown = table(PAGE.read_text(encoding="utf-8").split(f"## {section}")[1].split("\n## ")[0])
    computed = table(capsys.readouterr().out)
    for row, want in zip(shown, computed, strict=True):
        assert row == pytest.approx(want, abs=2e-3)
    return computed


def test_the_table_of_patch_points(capsys: pytest.CaptureFixture[str]) -> None:
    """Each column grows to its limit."""
    computed = compared(PATCH, "Points inside", capsys)
    assert [row[0] for row in computed] == [0, 1, 2, 4, 8]
    for column in list(zip(*computed, strict=True))[1:]:
        assert list(column[1:]) == sorted(column[1:]) and column[0] <= column[1] + 1e-9
        assert column[4] - column[3] <= 0.1 * (column[4] - column[0])


def test_the_table_of_the_cylinder(capsys: pytest.CaptureFixture[str]) -> None:
    """Each z is within 8 / n^2 of that with 192 facets."""
    computed = compared(CYLINDER, "A cylinder", capsys)
    assert [row[0] for row in computed] == [12, 24, 48, 96, 192]
    for n, *values in computed[:-1]:
        for z, limit in zip(values, computed[-1][1:], strict=True):
            assert abs(z - limit) <= 8.0 / n**2 * limit
