"""What a plan tolerates, on its page and as a figure."""

from __future__ import annotations

import pytest
from gm_ompl.viz.animation import animate
from gm_ompl.viz.page import page
from gm_ompl.viz.tolerance import tolerance_figure

import gm_ompl
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.tolerance.report import IntervalEnd
from tests.check.conftest import SCENARIO, Author


def test_it_is_shown() -> None:
    """The page has the table and the factors; the figure a plot per quantity that has an end."""
    author = Author(Scenario.from_resolved(SCENARIO))
    rows = (author.row("+z", 2, 2), author.row("-x", 2, 2))
    plan = author.plan([author.slide(0.0, 0.25, rows)])
    found = gm_ompl.tolerate(plan)
    text = page(plan, found)
    assert "What it tolerates" in text and "ranges may be widened by" in text
    assert "What it tolerates" not in page(plan)
    pytest.importorskip("matplotlib")
    ended = sum(
        any(end.ending is not IntervalEnd.LIMIT for end in (interval.low, interval.high))
        for interval in found.intervals
    )
    assert len(tolerance_figure(animate(plan), found).axes) == ended + 1
