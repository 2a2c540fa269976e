"""Tables of the documentation: made from measurements, put where they belong."""

from __future__ import annotations

from pathlib import Path

import pytest

import gm_ompl
from docs.tables import ablation, reproduction
from docs.tables.measure import Measured, graph_nodes, measure
from docs.tables.pages import write_tables
from gm_ompl.errors import InputError
from gm_ompl.scenario.load import load
from gm_ompl.study.report import number, table

SMALL = ("lattice.segments=3", "fingers.placements.grid=[2, 2]")
PAGES = Path(__file__).resolve().parents[2] / "docs" / "results"


def test_graph_has_as_many_nodes_as_the_paper_says() -> None:
    """7 x 7 x 6 placements, pairs of them, 31 lattice nodes: 1,335,201."""
    assert graph_nodes(load("paper/tumble").problem) == 1_335_201


def test_unequal_fingers_are_counted_as_ordered_pairs() -> None:
    """Fingers with different limits keep their places."""
    problem = load("paper/tumble", [*SMALL, "fingers.max_normal_force=[10, 9]"]).problem
    assert graph_nodes(problem) == 24 * 24 * 4


def test_a_measurement_is_that_of_the_planner(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a process of its own, the three heuristics find the same optimum."""
    (tmp_path / "docs").symlink_to(PAGES.parent)  # all of the checkout that the process may import
    monkeypatch.syspath_prepend(tmp_path)
    plan = gm_ompl.plan(gm_ompl.load("paper/slide", SMALL))
    for heuristic in ("lanes", "none"):
        found = measure("paper/slide", heuristic=heuristic, overrides=SMALL, repeat=False)
        assert found.optimal
        assert found.cost == pytest.approx(plan.cost, rel=1e-9)
        assert found.seconds > 0 and found.megabytes > 10


def test_exponents_are_those_of_power_laws() -> None:
    """x^2 in time and a constant in memory give 2 and 0."""
    points = [(x, Measured("solved", True, 1.0, x, x, 3.0 * x**2, 100.0, x)) for x in (2, 5, 9)]
    assert ablation.slope(points, "seconds") == pytest.approx(2.0)
    assert ablation.slope(points, "megabytes") == pytest.approx(0.0, abs=1e-12)


def test_tables_replace_what_stands_between_their_marks(tmp_path: Path) -> None:
    """Text around the marks stays; a second call changes nothing; missing marks are an error."""
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- begin t -->\nold\n<!-- end t -->\nb\n")
    new = table(("x", "y"), [(1, r"\1")])
    for _ in range(2):
        write_tables(page, {"t": new})
        assert page.read_text() == f"a\n<!-- begin t -->\n{new}<!-- end t -->\nb\n"
    with pytest.raises(InputError, match="begin other"):
        write_tables(page, {"other": new})


def test_the_pages_have_their_marks(tmp_path: Path) -> None:
    """What the two commands write has its place in the documentation."""
    for name, marks in (
        ("ablation", ("heuristics", "scaling")),
        ("reproduction", ("results", "cork")),
    ):
        copy = tmp_path / f"{name}.md"
        copy.write_text((PAGES / f"{name}.md").read_text())
        write_tables(copy, dict.fromkeys(marks, "new\n"))


def test_stages_tell_a_plan() -> None:
    """One stage per placement set and modes; a pinch has one of each mode throughout."""
    plan = gm_ompl.plan("paper/cork")
    assert list(reproduction.stages(plan)) == ["0.00 to 1.00: +y position, -y force"]
    assert reproduction.one_finger_in_force_control(plan)
    assert not reproduction.one_finger_in_force_control(gm_ompl.plan("paper/push"))


def test_numbers_are_short() -> None:
    """Few digits, thousands separated, a dash for none."""
    assert [number(x) for x in (None, 1335201, 0.12345, 15.0247, 12345.6)] == [
        "-", "1,335,201", "0.123", "15", "12,346",
    ]  # fmt: skip
