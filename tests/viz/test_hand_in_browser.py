"""A robot hand's run, opened offline in a real browser: its links move as the joint paths say."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gm_ompl.viz.animation import animate
from gm_ompl.viz.page import page

import gm_ompl
from gm_ompl.planfile.model import Plan

pytest.importorskip("mujoco")


@pytest.fixture(scope="module")
def pushed() -> Plan:
    return gm_ompl.plan("robot/trifinger-push", "HybridRRTConnect", seed=1)


def drawn(seen: Any, time: float) -> Any:
    """Where the page has the links at a time: positions and quaternions (s, 7)."""
    links = seen.tab.evaluate(f"gmOmpl.state({time!r}).links")
    return np.array([[*link["position"], *link["quaternion"]] for link in links])


def test_links_are_where_the_joint_paths_put_them(visit: Callable[..., Any], pushed: Plan) -> None:
    """At each step's beginning and middle row every solid is where forward kinematics has it."""
    seen, poses = visit(page(pushed)), animate(pushed).link_poses()
    starts = [*seen.tab.evaluate("gmOmpl.steps"), seen.tab.evaluate("gmOmpl.duration")]
    assert len(starts) == len(pushed.steps) + 1 == len(poses) + 1
    for step, rows in enumerate(poses):
        middle = (len(rows) - 1) // 2
        share = middle / (len(rows) - 1)
        inside = starts[step] + (share or 1e-6) * (starts[step + 1] - starts[step])
        for time, wanted in ((starts[step], rows[0]), (inside, rows[middle])):
            found = drawn(seen, time)
            np.testing.assert_allclose(found[:, :3], wanted[:, :3], atol=1e-6)
            turned = np.abs((found[:, 3:] * wanted[:, 3:]).sum(axis=1))
            np.testing.assert_allclose(turned, 1.0, atol=1e-6)
    assert (seen.errors, seen.requests) == ([], [])


def test_links_move_while_it_plays(visit: Callable[..., Any], pushed: Plan) -> None:
    """Played, most links have moved, and the picture of the scene is another."""
    seen = visit(page(pushed))
    before, shot = drawn(seen, 0.0), seen.tab.locator("#scene").screenshot()
    seen.tab.click("#play")
    seen.wait("gmOmpl.frames > 8 && gmOmpl.state().time > 0.5 * gmOmpl.duration")
    seen.tab.evaluate("gmOmpl.pause()")  # at the end it has stopped by itself
    after = drawn(seen, seen.tab.evaluate("gmOmpl.state().time"))
    assert (np.abs(after - before).max(axis=1) > 1e-3).sum() >= 6
    assert seen.tab.locator("#scene").screenshot() != shot
    assert (seen.errors, seen.requests) == ([], [])
