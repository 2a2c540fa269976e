"""What a notebook shows of plans and scenarios, and what a prompt prints."""

from __future__ import annotations

import base64
import re
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from typing import Any

import pytest

import gm_ompl
from gm_ompl.planfile.model import Plan


def shown(value: Any) -> str:
    """Return what a notebook shows; every element in it is closed."""
    html: str = value._repr_html_()
    Balanced().feed(html)
    return html


class Balanced(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, _attrs: object) -> None:
        if tag != "img":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_a_plan_is_a_line_at_the_prompt(slide: Plan, infeasible: Plan) -> None:
    """One short line that says how it ended."""
    assert re.fullmatch(
        r"<Plan for paper/slide: solved by astar, cost [\d.]+, optimal, 3 steps, regrasps: 0>",
        repr(slide),
    )
    assert repr(infeasible) == "<Plan for paper/slide: infeasible>"


def test_a_scenario_is_a_line_at_the_prompt() -> None:
    """Its name, object, hand and motion."""
    line = repr(gm_ompl.load("planar/corner"))
    assert line.startswith("<Scenario planar/corner: object ") and "motion planar" in line
    assert "\n" not in line and len(line) < 200


def test_a_plan_shows_a_picture_and_a_table(slide: Plan, infeasible: Plan) -> None:
    """The picture is an SVG that needs no network; the table has cost and what the object does."""
    html = shown(slide)
    (data,) = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', html)
    assert b"<svg" in base64.b64decode(data)
    assert "proven optimal on the lattice" in html and "slides 15 along +x" in html
    assert "no plan exists" in shown(infeasible)


@pytest.mark.parametrize("name", ["paper/cork", "planar/turn", "free/stairs"])
def test_a_scenario_shows_where_the_object_starts(name: str) -> None:
    """A picture and a table, whatever the motion."""
    html = shown(gm_ompl.load(name))
    assert "data:image/svg+xml" in html and name in html


def test_names_are_text_whatever_they_say(renamed: Callable[[str], Plan]) -> None:
    """Nothing in a scenario becomes markup."""
    assert "<script" not in shown(renamed("<script>alert(1)</script>"))


def test_the_scene_is_a_frame_that_cannot_reach_its_notebook(slide: Plan) -> None:
    """The page stands in a sandboxed frame, all of it."""
    scene = slide.scene()
    html = shown(scene)
    assert 'sandbox="allow-scripts"' in html
    assert "window.gmOmpl" in html
    assert len(repr(scene)) < 40


def test_without_matplotlib_the_table_is_left(slide: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is missing is said where the picture would be."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    html = shown(slide)
    assert "gm-ompl[plot]" in html and "<table>" in html


def test_without_meshcat_the_scene_says_what_to_install(
    slide: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A line with the command, not a traceback of imports."""
    for name in ("gm_ompl.viz.page", "gm_ompl.viz.scene"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, "meshcat", None)
    with pytest.raises(gm_ompl.MissingExtraError, match=r"gm-ompl\[view\]"):
        slide.scene()
