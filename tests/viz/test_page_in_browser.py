"""The page, opened offline in a real browser."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from gm_ompl.viz.page import page
from PIL import Image

import gm_ompl
from gm_ompl.planfile.model import Plan
from tests.browsers import SIZES

HOSTILE = {
    "markup": "<script>document.title='hacked'</script> </script><img src=x onerror=alert(1)> "
    "\"'><b onclick='x'>&amp;&#60; @@SCORE@@ {{x}} ${y} \\u003c",
    "long": "тест 掴まない操作 بدون إمساك \u202eabc " + "long " * 300 + "x" * 500,
}


def turned(quaternion: tuple[float, ...], vector: Any) -> Any:
    """Return ``vector`` turned by a quaternion (w, x, y, z), by its own formula."""
    w, u = quaternion[0], np.array(quaternion[1:])
    v = np.asarray(vector)
    return v + 2.0 * w * np.cross(u, v) + 2.0 * np.cross(u, np.cross(u, v))


def expected(plan: Plan) -> Iterator[tuple[Any, Any, list[Any], list[Any], list[Any], float]]:
    """Yield per step: pose, placements, modes, f_com and z at its start, from the plan alone."""
    pose = None
    for step in plan.steps:
        if step.kind == "displacement":
            pose, first = step.pose_from, step.segments[0]
            yield step, pose, list(step.placements), list(first.modes), list(first.f_com), first.z
            pose = step.pose_to
        else:
            yield step, pose, list(step.placements), list(step.modes), list(step.f_com), step.z


@pytest.mark.parametrize("size", SIZES)
def test_the_page_shows_what_the_plan_says(
    visit: Callable[..., Any], regrasp: Plan, size: str
) -> None:
    """At each step's start pose, fingertips, looks, arrows and numbers are the plan's."""
    seen = visit(page(regrasp), *SIZES[size])
    radius = regrasp.scenario["fingers"]["radius"]
    limit = regrasp.scenario["fingers"]["max_normal_force"]
    starts = seen.tab.evaluate("gmOmpl.steps")
    states = seen.tab.evaluate("gmOmpl.steps.map((t) => gmOmpl.state(t))")
    assert len(starts) == len(regrasp.steps)
    for state, (step, pose, places, modes, forces, z) in zip(
        states, expected(regrasp), strict=True
    ):
        np.testing.assert_allclose(state["object"]["position"], pose.position, atol=1e-9)
        assert abs(np.dot(state["object"]["quaternion"], pose.quaternion)) == pytest.approx(1.0)
        for i, place in enumerate(places):
            local = np.array(place.point) - radius[i] * np.array(place.normal)
            centre = np.array(pose.position) + turned(pose.quaternion, local)
            finger, row = state["fingers"][i], state["text"]["rows"][i]
            np.testing.assert_allclose(finger["position"], centre, atol=1e-9)
            assert finger["looks"] == [modes[i] or "lifted"] == [row[2]]
            assert finger["arrow"] == pytest.approx((forces[i] or 0.0) / limit[i])
            assert row[1].startswith(place.words)
            shown = None if row[3] == "\u2013" else float(row[3])
            assert shown == (None if forces[i] is None else pytest.approx(forces[i], rel=1e-3))
        assert float(state["text"]["z"]) == pytest.approx(z, rel=1e-3)
        assert step.kind in state["text"]["step"]
    assert (seen.errors, seen.requests) == ([], [])


def test_the_end_is_the_goal(visit: Callable[..., Any], regrasp: Plan) -> None:
    """Scrubbed to its end, the page shows the last pose; slider and cursor stand at the end."""
    seen = visit(page(regrasp))
    state = seen.tab.evaluate("gmOmpl.state(gmOmpl.duration)")
    last = regrasp.steps[-1]
    assert last.kind == "displacement"
    np.testing.assert_allclose(state["object"]["position"], last.pose_to.position, atol=1e-9)
    assert (state["slider"], state["cursor"]) == (1.0, 1.0)


def test_it_plays_pauses_steps_and_scrubs(visit: Callable[..., Any], regrasp: Plan) -> None:
    """Buttons, keys, the slider and the plot move the time; playing draws frames."""
    seen = visit(page(regrasp))
    tab = seen.tab
    tab.click("#play")
    seen.wait("gmOmpl.frames > 8 && gmOmpl.state().time > 0.3")
    assert tab.evaluate("gmOmpl.playing")
    tab.click("#play")
    paused = tab.evaluate("gmOmpl.state().time")
    tab.wait_for_timeout(120)
    assert tab.evaluate("[gmOmpl.playing, gmOmpl.state().time]") == [False, paused]
    tab.evaluate("gmOmpl.seek(0)")
    tab.click("#forth")
    tab.click("#forth")
    assert tab.evaluate("gmOmpl.state().step") == 2
    tab.click("#back")
    assert tab.evaluate("gmOmpl.state().step") == 1
    tab.locator("#slider").fill("0.5")
    middle = tab.evaluate("gmOmpl.duration / 2")
    assert tab.evaluate("gmOmpl.state().time") == pytest.approx(middle)
    box = tab.locator(".band svg").first.bounding_box()
    tab.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + 20)
    assert tab.evaluate("gmOmpl.state().cursor") == pytest.approx(0.25, abs=0.01)


def test_keys_move_the_time(visit: Callable[..., Any], regrasp: Plan) -> None:
    """Space plays and pauses, arrows step, Home and End go to the ends, wherever the focus is."""
    tab = visit(page(regrasp)).tab
    for focused in ("body", "#play", "#slider", "summary"):
        tab.evaluate("gmOmpl.seek(0); document.activeElement.blur()")
        if focused != "body":
            tab.focus(focused)
        tab.keyboard.press("ArrowRight")
        tab.keyboard.press("ArrowRight")
        assert tab.evaluate("gmOmpl.state().step") == 2, focused
        tab.keyboard.press("ArrowLeft")
        assert tab.evaluate("gmOmpl.state().step") == 1, focused
        tab.keyboard.press("End")
        assert tab.evaluate("gmOmpl.state().time === gmOmpl.duration"), focused
        tab.keyboard.press("Home")
        assert tab.evaluate("gmOmpl.state().time") == 0, focused
        if focused == "summary":  # opens and closes the legend
            continue
        for playing in (True, False):
            tab.keyboard.press("Space")
            assert tab.evaluate("gmOmpl.playing") == playing, focused
    tab.evaluate("gmOmpl.seek(0)")
    tab.focus("#speed")
    tab.keyboard.press("ArrowRight")
    assert tab.evaluate("gmOmpl.state().step") == 0, "the list of speeds has its own arrows"


def test_controls_have_names_and_show_the_focus(visit: Callable[..., Any], regrasp: Plan) -> None:
    """Tab reaches every control in turn; each is outlined while focused and has a name."""
    tab = visit(page(regrasp)).tab
    reached = []
    for _ in range(8):
        tab.keyboard.press("Tab")
        name, outline, label = tab.evaluate(
            """() => {
              const e = document.activeElement;
              return [e.id || e.tagName, getComputedStyle(e).outlineStyle,
                      e.ariaLabel || (e.labels && e.labels.length ? e.labels[0] : e).innerText];
            }"""
        )
        if name != "BODY":
            reached.append(name)
            assert outline == "solid", name
            assert label.strip(), name
    assert {"back", "play", "forth", "speed", "slider"} <= set(reached)
    assert "step 1 of" in tab.locator("#slider").get_attribute("aria-valuetext")


def test_nothing_moves_by_itself(visit: Callable[..., Any], regrasp: Plan) -> None:
    """An opened page stands still until it is told to play."""
    tab = visit(page(regrasp)).tab
    tab.wait_for_timeout(300)
    assert tab.evaluate("[gmOmpl.playing, gmOmpl.state().time]") == [False, 0]
    assert tab.evaluate("document.getAnimations().length") == 0


def test_speed_scales_the_time_that_passes(visit: Callable[..., Any], regrasp: Plan) -> None:
    """A tenth of a second between two frames moves the plan's time by a tenth times the speed."""
    tab = visit(page(regrasp)).tab
    for speed in (0.25, 1, 4):
        tab.select_option("#speed", f"{speed:g}")
        tab.evaluate(
            """() => {
              const real = window.requestAnimationFrame, waiting = [];
              window.requestAnimationFrame = (f) => waiting.push(f);
              gmOmpl.seek(0);
              gmOmpl.play();
              waiting.shift()(1000);
              waiting.shift()(1100);
              gmOmpl.pause();
              window.requestAnimationFrame = real;
            }"""
        )
        assert tab.evaluate("gmOmpl.state().time") == pytest.approx(0.1 * speed)


def test_a_phone_needs_no_sideways_scrolling(visit: Callable[..., Any], regrasp: Plan) -> None:
    """At phone width everything fits; scene and controls are on the first screen."""
    tab = visit(page(regrasp), *SIZES["phone"]).tab
    assert tab.evaluate("document.documentElement.scrollWidth") <= SIZES["phone"][0]
    for part in ("#scene", "#play", "#slider"):
        box = tab.locator(part).bounding_box()
        assert box["y"] + box["height"] <= SIZES["phone"][1], part


@pytest.mark.parametrize("kind", HOSTILE)
def test_hostile_names_are_text(
    visit: Callable[..., Any], renamed: Callable[[str], Plan], kind: str
) -> None:
    """Whatever a name says is shown as text; nothing runs, nothing overflows a phone."""
    name = HOSTILE[kind]
    seen = visit(page(renamed(name)), *SIZES["phone"])
    shown = seen.tab.evaluate("document.querySelector('h1').textContent")
    assert shown.replace("\ufffd", "\u202e").split() == name.split()
    assert seen.tab.evaluate("document.title").split()[0] == name.split()[0]
    assert seen.tab.evaluate("document.documentElement.scrollWidth") <= SIZES["phone"][0]
    assert (seen.errors, seen.requests) == ([], [])


def picture(tab: Any) -> Any:
    """Return the scene as drawn, (h, w, 3)."""
    tab.evaluate("gmOmpl.state(0.3 * gmOmpl.duration)")
    tab.wait_for_timeout(150)
    shot = Image.open(io.BytesIO(tab.locator("#scene").screenshot()))
    return np.asarray(shot.convert("RGB"), dtype=float)


def test_pictures_are_the_same_at_every_scale(
    visit: Callable[..., Any], regrasp: Plan, rescaled: Callable[[Plan, float], Plan]
) -> None:
    """A scene of 1 mm, 1 m or 10 units gives one picture: the unit of length is not seen."""
    original = picture(visit(page(regrasp)).tab)
    assert original.std() > 10.0, "nothing is drawn"
    for factor in (1e-4, 0.1):
        other = picture(visit(page(rescaled(regrasp, factor))).tab)
        assert np.abs(other - original).mean() < 0.5


def test_a_thousand_steps_open_and_play(visit: Callable[..., Any], long_plan: Plan) -> None:
    """A plan of 1,000 steps is small enough to open, and plays."""
    text = page(long_plan)
    assert len(text) < 2_500_000
    seen = visit(text)
    assert len(seen.tab.evaluate("gmOmpl.steps")) == 1000
    state = seen.tab.evaluate("gmOmpl.state(gmOmpl.steps[777])")
    step = long_plan.steps[777]
    assert step.kind == "displacement"
    np.testing.assert_allclose(state["object"]["position"], step.pose_from.position, atol=1e-9)
    seen.tab.evaluate("gmOmpl.seek(0); gmOmpl.play()")
    seen.wait("gmOmpl.frames > 8 && gmOmpl.state().time > 0.3")
    assert seen.errors == []


def test_without_a_plan_the_start_is_shown(visit: Callable[..., Any], infeasible: Plan) -> None:
    """A result without steps shows the object at its start and says why."""
    seen = visit(page(infeasible))
    state = seen.tab.evaluate("gmOmpl.state(0)")
    start = infeasible.scenario["motion"]["start"]["position"]
    np.testing.assert_allclose(state["object"]["position"], start, atol=1e-12)
    assert "no plan exists on the scenario's lattice" in seen.tab.locator("#summary").text_content()
    assert not seen.tab.locator("#time").is_visible(), "there is nothing to play"
    seen.tab.keyboard.press("Space")
    seen.tab.keyboard.press("ArrowRight")
    assert not seen.tab.evaluate("gmOmpl.playing")
    assert seen.errors == []


def test_free_motion_is_told_in_words(visit: Callable[..., Any]) -> None:
    """What happens is listed, the present link marked; the object's place is said, and its turn."""
    seen = visit(page(gm_ompl.plan("random/free/2")))
    items = seen.tab.locator("#links li")
    assert items.count() >= 2
    first = seen.tab.evaluate("gmOmpl.state(0).text")
    assert items.first.get_attribute("aria-current") is not None
    assert items.first.inner_text() in first["step"]
    assert first["coordinates"].startswith("at [0, 0, ")
    last = seen.tab.evaluate("gmOmpl.state(gmOmpl.duration).text")
    assert items.last.get_attribute("aria-current") is not None
    assert last["coordinates"].endswith("turned 180.0 deg about +y")
