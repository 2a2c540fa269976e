"""Plans to look at, and a browser to look with."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gm_ompl import api
from gm_ompl.planfile.model import Plan
from tests.browsers import Visit

LENGTHS = ("position", "point", "translation")


@pytest.fixture(scope="session")
def regrasp() -> Plan:
    """The paper's problem with one regrasp, planned."""
    return api.plan("paper/regrasp")


@pytest.fixture(scope="session")
def slide() -> Plan:
    """A slide of three arcs on a coarse grid, planned."""
    few = ["lattice.segments=3", "fingers.placements.grid=[2, 2]"]
    return api.plan(api.load("paper/slide", few))


@pytest.fixture(scope="session")
def infeasible() -> Plan:
    """A result without steps."""
    few = ["lattice.segments=3", "fingers.placements.grid=[2, 2]", "mechanics.z_min=1000"]
    return api.plan(api.load("paper/slide", few))


@pytest.fixture(scope="session")
def renamed(slide: Plan) -> Callable[[str], Plan]:
    """Return the slide under another name and description."""

    def rename(name: str) -> Plan:
        document = copy.deepcopy(slide.to_dict())
        document["scenario"] |= {"name": name, "description": name}
        return _plan(document)

    return rename


@pytest.fixture(scope="session")
def rescaled() -> Callable[[Plan, float], Plan]:
    """Return a plan in another unit of length: a length of 1 becomes ``factor``."""

    def rescale(plan: Plan, factor: float) -> Plan:
        document = copy.deepcopy(plan.to_dict())
        scenario = document["scenario"]
        scenario["object"]["shape"]["box"] = _times(scenario["object"]["shape"]["box"], factor)
        scenario["fingers"]["radius"] = _times(scenario["fingers"]["radius"], factor)
        for obstacle in scenario["environment"]["obstacles"].values():
            obstacle["box"] = {k: _times(v, factor) for k, v in obstacle["box"].items()}
        start = scenario["motion"]["start"]
        start["position"] = _times(start["position"], factor)
        _scale_lengths(document["steps"], factor)
        return _plan(document)

    return rescale


@pytest.fixture(scope="session")
def long_plan(slide: Plan) -> Plan:
    """A plan of 1,000 steps: the slide's, each cut into many."""
    document = copy.deepcopy(slide.to_dict())
    model, by = document["steps"][0], np.array([15.0, 0.0, 0.0])
    begin = np.array(model["pose_from"]["position"])
    steps = []
    for k in range(1000):
        step = copy.deepcopy(model)
        for key, pose, s in (("from", "pose_from", k / 1000), ("to", "pose_to", (k + 1) / 1000)):
            step[key] = [s]
            step[pose]["position"] = (begin + s * by).tolist()
        step["arc"] = {"translation": (by / 1000).tolist()}
        steps.append(step)
    document["steps"] = steps
    return _plan(document)


def _plan(document: dict[str, Any]) -> Plan:
    return Plan.model_validate_json(json.dumps(document))


def _times(value: Any, factor: float) -> Any:
    return [_times(v, factor) for v in value] if isinstance(value, list) else value * factor


def _scale_lengths(value: Any, factor: float) -> None:
    for key, item in value.items() if isinstance(value, dict) else enumerate(value):
        if key in LENGTHS:
            value[key] = _times(item, factor)
        elif isinstance(item, dict | list):
            _scale_lengths(item, factor)


@pytest.fixture
def visit(browser: Any, tmp_path: Path) -> Iterator[Callable[..., Visit]]:
    """Return a function that opens a page's text, offline, in a window of the given size."""
    contexts = []

    def open_page(text: str, width: int = 1280, height: int = 900) -> Visit:
        path = tmp_path / "page.html"
        path.write_text(text, encoding="utf-8")
        context = browser.new_context(viewport={"width": width, "height": height}, offline=True)
        contexts.append(context)
        seen = Visit(context.new_page())
        address = path.as_uri()
        seen.listen(address)
        seen.tab.goto(address)
        seen.wait("window.gmOmpl !== undefined")
        return seen

    yield open_page
    for context in contexts:
        context.close()
