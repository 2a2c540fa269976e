"""docs/gallery.md says what the command says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from gm_ompl import api
from gm_ompl.app.planning import summary

PAGE = Path(__file__).resolve().parents[2] / "docs" / "gallery.md"


@pytest.mark.parametrize("name", ["fingers/three", "paper/push", "paper/slide"])
def test_the_gallery_shows_what_plan_prints(name: str) -> None:
    """Cost, regrasps, placements and modes are those of ``gm-ompl plan``, ties included.

    A search that meets equals in another order names other placements: then `make gallery`.
    """
    (section,) = re.findall(rf"^## {name}\n(.*?)(?=^## |\Z)", PAGE.read_text(), re.M | re.S)
    scenario = api.load(name)
    printed = [line.strip() for line in summary(api.plan(scenario), scenario.problem)]
    shown = [line for line in printed if not line.startswith(("search", name))]
    assert re.findall(r"^\* (.*)$", section, re.M) == shown
