"""docs/results/continuous.md: its tables and its picture are what the command makes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs.tables import anywhere

PAGE = Path(__file__).parents[2] / "docs" / "results" / "continuous.md"


def test_rows_have_the_page_s_columns() -> None:
    """The smallest grid and gap make rows as wide as the page's, and the bound is below."""
    rows = list(anywhere.converging(("paper/slide",), (3,), ("1%",)))
    assert all(len(row) == len(anywhere.HEAD) for row in rows)
    assert rows[1][2] == "solved"
    assert float(rows[1][4]) <= float(rows[1][3]) <= float(rows[0][3])
    text = PAGE.read_text(encoding="utf-8")
    for head, mark in ((anywhere.HEAD, "converging"), (anywhere.TIMES, "placements")):
        table = re.search(rf"<!-- begin {mark} -->\n(.*?)<!-- end", text, re.DOTALL)
        assert table is not None
        assert table[1].splitlines()[0] == "| " + " | ".join(head) + " |"


def test_rows_of_sampled_plans() -> None:
    """Medians of few draws; the best plan costs no more than the first, the bound no more."""
    (row,) = anywhere.sampled({"paper/slide": 0.5}, 1, 0.5)
    assert len(row) == len(anywhere.SAMPLED)
    first, best, bound = float(row[3]), float(row[4]), float(row[6])
    assert bound <= best <= first
    text = PAGE.read_text(encoding="utf-8")
    assert "<!-- begin sampled -->\n| " + " | ".join(anywhere.SAMPLED) + " |" in text


def test_the_exponent_is_the_slope() -> None:
    """Times that grow with the root of the sets have the exponent 0.5; one time has none."""
    known = {"a, cells": [(1e3, 0.1), (1e5, 1.0), (1e7, 10.0)], "b, cells": [(1e3, 0.1)]}
    (row,) = anywhere.exponents(known)
    assert row[0] == "a, cells"
    assert float(row[1]) == pytest.approx(0.5)
