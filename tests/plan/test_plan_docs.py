"""The examples in the documentation of the plan file are valid."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from docs.tables.site import on_page_markdown
from gm_ompl.planfile.model import Plan

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "plan.md"


def _blocks() -> list[str]:
    return re.findall(r"```json\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)


def test_the_worked_example_is_a_plan() -> None:
    """The page's blocks, put together, are a plan file in which the totals add up."""
    top, *steps = (json.loads(block) for block in _blocks())
    plan = Plan.model_validate_json(json.dumps({**top, "steps": steps}))
    assert plan.cost == pytest.approx(sum(step.cost for step in plan.steps))
    assert plan.regrasps == sum(step.kind == "regrasp" for step in plan.steps)


def test_every_key_is_explained() -> None:
    """Every top-level key of the format has its line on the page as the site has it."""
    text = on_page_markdown(PAGE.read_text(encoding="utf-8"))
    for key in Plan.model_fields:
        assert f"`{key}`" in text, key
