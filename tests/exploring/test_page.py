"""The page of ``gm-ompl explore``, in a real browser."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import gm_ompl
from gm_ompl.planfile.model import Plan
from tests.browsers import SIZES, Visit
from tests.exploring.conftest import NAME, OBSTACLE, Explored, settled

Visitor = Callable[..., Visit]


def slid(seen: Visit, label: str, part: int) -> Any:
    """Move a slider to ``part`` of 1000; return the answer that comes."""
    knob = seen.tab.locator(".knob", has_text=re.compile(f"^{re.escape(label)}"))
    knob.locator("input[type=range]").fill(str(part))
    assert seen.tab.evaluate("document.body.dataset.state") == "planning"
    return settled(seen)


def changes(seen: Visit) -> list[str]:
    texts: list[str] = seen.tab.locator("#changed code").all_text_contents()
    return texts


def test_hostile_names_are_text_and_nothing_is_wrong(visit: Visitor) -> None:
    """Names from the file are shown as they are; no script of theirs runs, at either width."""
    from axe_playwright_python.sync_playwright import Axe

    for size in SIZES.values():
        seen = visit(*size)
        assert seen.tab.locator("h1").text_content() == NAME
        assert OBSTACLE in seen.tab.locator("#handles button").all_text_contents()
        assert seen.tab.evaluate("document.documentElement.scrollWidth") <= size[0]
        found = Axe().run(seen.tab).response["violations"]
        bad = [v["id"] for v in found if v["impact"] in ("serious", "critical")]
        assert (bad, seen.errors, seen.requests) == ([], [], [])


def test_a_slider_changes_the_plan_and_a_reload_keeps_it(seen: Visit) -> None:
    """A turned knob is planned with, shown, and still there when the page is loaded again."""
    before = settled(seen)
    after = slid(seen, "z_min", 400)
    assert changes(seen) == ["mechanics.z_min=0.8"]
    assert (before["score"]["zMin"], after["score"]["zMin"]) == (0.5, 0.8)
    assert "0.8" in seen.tab.locator("#bands").text_content()
    assert seen.tab.evaluate("gmOmpl.state(gmOmpl.duration).object.position")[0] == 10.0
    seen.tab.select_option("#planner", "HybridRRT")
    assert settled(seen)["planner"] == "HybridRRT"
    seen.tab.reload()
    seen.wait("window.gmExplore !== undefined")
    again = settled(seen)
    assert changes(seen) == ["mechanics.z_min=0.8"]
    assert (again["planner"], again["score"]["zMin"]) == ("HybridRRT", 0.8)
    assert seen.tab.locator(".knob", has_text="z_min").locator("input[type=number]").input_value() \
        == "0.8"  # fmt: skip
    assert seen.errors == []


def test_what_is_wrong_is_said_and_can_be_undone(seen: Visit) -> None:
    """A bad setting is refused in words; the last plan stays; undo plans again."""
    for word, told in (
        ("fingers.radius=-1", "must be > 0"),
        ("fingers.<b>1</b>=1", "<b>1</b>"),
    ):
        seen.tab.fill("#setting", word)
        seen.tab.press("#setting", "Enter")
        settled(seen)
        assert told in seen.tab.locator("#refused").text_content()
        assert seen.tab.locator("#refused b").count() == 0
        assert seen.tab.locator("#save-plan").is_disabled()
        seen.tab.locator("summary", has_text="Changed").click()
        seen.tab.locator("#changed button").click()
        settled(seen)
        seen.tab.locator("summary", has_text="Changed").click()
        assert seen.tab.locator("#refused").is_hidden()
        assert seen.tab.locator("#save-plan").is_enabled()
    seen.tab.fill("#setting", "nothing")
    seen.tab.press("#setting", "Enter")
    assert "KEY=VALUE" in seen.tab.locator("#refused").text_content()
    assert seen.errors == []


def test_obstacles_and_the_goal_are_dragged(seen: Visit) -> None:
    """A dragged obstacle moves by whole steps, in both corners alike; so do arrow keys."""
    grip = seen.tab.locator("#handles button", has_text="onerror")
    box = grip.bounding_box()
    seen.tab.mouse.move(box["x"] + 9, box["y"] + 9)
    seen.tab.mouse.down()
    seen.tab.mouse.move(box["x"] + 49, box["y"] - 20, steps=4)
    seen.tab.mouse.up()
    answer = settled(seen)
    moved = answer["handles"][1 + [h["name"] for h in answer["handles"][1:]].index(OBSTACLE)]
    low, high = (one["value"] for one in moved["moved"])
    assert [high[k] - low[k] for k in range(3)] == pytest.approx([6, 2, 3])
    assert low[:2] != [-3, 7] and low[2] == 0
    for k, start in enumerate((-3, 7)):
        steps = (low[k] - start) / moved["steps"][k]
        assert steps == pytest.approx(round(steps))
    goal = seen.tab.locator("#handles button", has_text="goal")
    goal.focus()
    goal.press("ArrowRight")
    goal.press("ArrowRight")
    answer = settled(seen)
    by = next(h for h in answer["handles"] if h["kind"] == "goal")["moved"][0]["value"]
    assert sum(abs(a - b) for a, b in zip(by, [10, 0, 0], strict=True)) == pytest.approx(0.4)
    assert seen.tab.evaluate("gmOmpl.state().time") == 0, "arrow keys are the handle's"
    assert seen.errors == []


def test_what_is_saved_can_be_used(seen: Visit, tmp_path: Path) -> None:
    """The saved plan holds in check and has the settings; the saved scenario plans the same."""
    answer = slid(seen, "mass", 300)
    assert answer["solved"]
    files = []
    for button in ("#save-plan", "#save-scenario"):
        with seen.tab.expect_download() as caught:
            seen.tab.click(button)
        assert os.sep not in caught.value.suggested_filename
        files.append(tmp_path / caught.value.suggested_filename)
        caught.value.save_as(files[-1])
    plan = Plan.load(files[0])
    assert gm_ompl.check(plan).holds
    scenario = gm_ompl.load(files[1])
    assert scenario.resolved() == {**plan.scenario, "expect": scenario.resolved()["expect"]}
    assert plan.scenario["object"]["mass"] == pytest.approx(0.398)
    assert scenario.model.expect.status is None, "what the file expects need not hold any more"


def test_the_map_of_the_instant_is_shown(seen: Visit) -> None:
    """On demand: where fingers may be now, as an image and as text; a turned knob takes it away."""
    seen.tab.click("#ask-map")
    seen.wait("!document.getElementById('map-status').textContent.includes('mapping')")
    assert "placements" in seen.tab.locator("#map-lines").text_content()
    assert "moving" in seen.tab.locator("#map-lines").text_content()
    seen.wait("document.getElementById('map-image').naturalWidth > 100")
    slid(seen, "mass", 480)
    assert seen.tab.locator("#map").is_hidden()
    assert seen.errors == []


def test_two_windows_do_not_meet(seen: Visit, visit: Visitor) -> None:
    """Each window has its own settings and its own plan, also while both are planned."""
    first, second = seen, visit(more="#set=mechanics.z_min%3D0.75")
    for one, part in ((first, 100), (second, 900)):
        one.tab.locator(".knob", has_text="friction, env").locator("input[type=range]").fill(
            str(part)
        )
    for one, friction, z_min in ((first, 0.15, 0.5), (second, 1.35, 0.75)):
        scenario = json.loads(settled(one)["plan"])["scenario"]
        assert scenario["friction"]["environment"] == friction
        assert scenario["mechanics"]["z_min"] == z_min
        assert one.errors == []


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="reads /proc")
def test_an_outdated_search_is_dropped(seen: Visit, running: Explored) -> None:
    """Of many turns of a knob the last one is answered, and no other search is left running."""
    from tests.exploring.test_command import descendants

    count = seen.tab.evaluate("gmExplore.answers")
    for part in range(200, 600, 20):
        seen.tab.locator(".knob", has_text="z_min").locator("input[type=range]").fill(str(part))
    assert settled(seen)["score"]["zMin"] == 1.16
    assert seen.tab.evaluate("gmExplore.answers") <= count + 3
    for _ in range(100):
        left = descendants(running.process.pid)
        if len(left) == 1:  # the server that runs are forked from
            break
        seen.tab.wait_for_timeout(50)
    assert len(left) == 1
