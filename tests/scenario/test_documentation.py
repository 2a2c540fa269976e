"""docs/reference/scenario.md: every example works."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from gm_ompl.scenario.document import parse
from gm_ompl.scenario.load import read
from gm_ompl.scenario.model import ScenarioModel
from gm_ompl.scenario.scenario import Scenario

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "scenario.md"
PLANAR: dict[str, Any] = {
    "planar": {"x": [-2, 20], "y": [-10, 10], "yaw": ["-180 deg", "180 deg"]},
    "start": {"position": [0, 0, 5]},
    "goal": {"position": [12, 6, 5]},
}
FREE: dict[str, Any] = {
    "free": {"region": {"x": [-2, 20], "y": [-10, 10], "z": [0, 12]}},
    "start": {"position": [0, 0, "rest"]},
    "goal": {"position": [12, 6, "rest"]},
}
FREE_LATTICE: dict[str, Any] = {"steps": {"translation": 1, "rotation": "15 deg"}}


def fragments() -> list[tuple[str, str]]:
    """(heading, YAML) of every example under "Key by key"."""
    found = []
    for section in re.split(r"^### ", PAGE.read_text(encoding="utf-8"), flags=re.M)[1:]:
        heading = section.split("`")[1]
        found += [(heading, text) for text in re.findall(r"```yaml\n(.*?)```", section, re.S)]
    return found


def whole() -> dict[str, Any]:
    """The tree of the page's complete example."""
    match = re.search(r"```yaml\n(format: .*?cost.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    assert match is not None
    tree: Any = parse(match[1], "page").tree
    return dict(tree)


@pytest.mark.parametrize(("heading", "text"), fragments(), ids=lambda part: part[:30].strip())
def test_each_example_loads_in_the_pages_scenario(heading: str, text: str) -> None:
    """Put in its place in the complete example, each fragment makes a valid scenario."""
    tree, part = whole(), parse(text, "fragment").tree
    if heading == "hand":  # a robot has its size
        found = read("robot/trifinger-push").tree
        assert isinstance(found, dict)
        tree = dict(found)
    count = tree["fingers"]["count"]
    assert isinstance(part, dict)
    parent = heading.rpartition(".")[0]
    target: Any = tree[parent] if parent else tree
    if heading == "motion.free" or "translation" in text:
        tree["motion"], tree["lattice"] = dict(FREE), dict(FREE_LATTICE)
        target = tree["motion"] if parent else tree
    elif heading == "motion.planar" or "steps" in text:
        tree["motion"] = dict(PLANAR)
        tree["lattice"] = {"steps": {"x": 1, "y": 1, "yaw": "30 deg"}}
        target = tree["motion"] if parent else tree
    if heading == "motion.planar":  # its start suits a lower object
        tree["environment"] = {"floor": False}
    if heading.startswith("object"):  # another body, of another height
        tree["environment"] = {"floor": False}
        tree["motion"]["path"] = [{"slide": {"by": [1, 0, 0]}}]
    if "by: [15" in text or "segments: [10, 30]" in text:
        pieces = [{"slide": {"by": [15, 0, 0]}}, {"tumble": {"towards": "+x", "angle": "90 deg"}}]
        tree["motion"]["path"], tree["lattice"] = pieces, {"segments": [10, 30]}
    if "motion" in part:
        part = part["motion"]
        target = tree["motion"]
    target.update(part)
    assert Scenario.from_resolved(tree, "page").problem.fingers.count == count


def test_every_top_level_key_is_explained() -> None:
    """The page names every key of a scenario in a heading."""
    headings = re.findall(r"^### (.*)$", PAGE.read_text(encoding="utf-8"), re.M)
    explained = {key.partition(".")[0] for line in headings for key in re.findall("`(.*?)`", line)}
    assert explained == set(ScenarioModel.model_fields)
