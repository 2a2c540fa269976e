"""A scenario text to change, and a way to load changed ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario

PATH_TEXT = """\
format: gm-ompl-scenario/1
name: test/tumble
object:
  shape: {box: [5, 5, 10]}
  mass: 1
friction: {environment: 0.5, finger: 0.7}
gravity: 9.8
fingers:
  count: 2
  radius: 1
  max_normal_force: 10
  placements: {grid: [7, 7], faces: all}
environment:
  floor: true
  obstacles:
    wall: {box: {min: [-100, -100, 0], max: [-3, 100, 100]}}
motion:
  start: {position: [0, 0, 5]}
  path:
    - tumble: {towards: +x, angle: 90 deg}
lattice: {segments: 30}
mechanics: {cone_edges: 6, directions: 76, z_min: 0.5}
cost: {regrasp: 100, stability: 0.01, samples_per_arc: 3}
"""

PLANAR_TEXT = """\
format: gm-ompl-scenario/1
name: test/planar
object:
  shape: {box: [2, 4, 5]}
  mass: 1
friction: {environment: 0.5, finger: 0.7}
fingers: {count: 2, radius: 1, max_normal_force: 10}
motion:
  planar: {x: [-2, 20], y: [-10, 10], yaw: [-180 deg, 180 deg]}
  start: {position: [0, 0, 2.5], yaw: 0 deg}
  goal: {position: [12, 6, 2.5], yaw: 90 deg}
lattice: {steps: {x: 0.5, y: 0.5, yaw: 5 deg}}
"""

FREE_TEXT = """\
format: gm-ompl-scenario/1
name: test/free
object:
  shape: {box: [2, 2, 1]}
  mass: 1
friction: {environment: 0.5, finger: 0.7}
fingers: {count: 2, radius: 0.3, max_normal_force: 10, placements: {grid: [3, 3]}}
environment:
  obstacles:
    step: {box: {min: [3, -2, 0], max: [9, 2, 0.5]}}
motion:
  free: {region: {x: [-4, 8], y: [0, 0], z: [0, 4]}, translate: [x, z], rotate: [y]}
  start: {position: [0, 0, rest]}
  goal:
    position: [5, 0, 1.5]
    rotation: {axis: [0, 1, 0], angle: 90 deg}
    within: {position: 0.1, rotation: 1 deg}
lattice: {steps: {translation: 0.5, rotation: 15 deg}}
"""

LoadChanged = Callable[..., Scenario]


@pytest.fixture
def texts() -> dict[str, str]:
    """A valid scenario of each kind of motion."""
    return {"path": PATH_TEXT, "planar": PLANAR_TEXT, "free": FREE_TEXT}


@pytest.fixture
def load_changed(tmp_path: Path, texts: dict[str, str]) -> LoadChanged:
    """Load one of the texts with ``old`` replaced by ``new``."""

    def changed(which: str, old: str = "", new: str = "", *overrides: str) -> Scenario:
        assert old in texts[which], f"the test's own text lacks {old!r}"
        file = tmp_path / "scenario.yaml"
        file.write_text(texts[which].replace(old, new, 1), encoding="utf-8")
        return load(file, overrides)

    return changed
