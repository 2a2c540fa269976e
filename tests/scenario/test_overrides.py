"""``--set KEY=VALUE``: changes before validation, mistakes named by their key."""

from __future__ import annotations

import pytest

from gm_ompl.errors import ScenarioError
from gm_ompl.scenario.load import load


@pytest.mark.parametrize(
    ("override", "read", "value"),
    [
        ("fingers.max_normal_force=5", lambda p: p.fingers.max_normal_force.tolist(), [5, 5]),
        ("fingers.max_normal_force=[10, 4]",
         lambda p: p.fingers.max_normal_force.tolist(), [10, 4]),
        ("object.shape.box.2=6", lambda p: p.body.vertices[:, 2].max(), 3),
        ("mechanics.backend=highs", lambda p: p.mechanics.backend, "highs"),
        ("mechanics.margin=strong", lambda p: p.mechanics.strong, True),
        ("lattice.segments=7", lambda p: p.lattice.size, 8),
        ("motion.path.0.slide.by.0=1e1", lambda p: p.motion.pose([1.0]).position[0], 10),
        ("environment.obstacles.wall={box: {min: [50, 0, 0], max: [60, 1, 1]}}",
         lambda p: p.environment.obstacles[0].name, "wall"),
        ("environment.obstacles.wall.box={min: [50, 0, 0], max: [60, 1, 1]}",
         lambda p: len(p.environment.obstacles), 1),
        ("fingers.placements.faces=[-x, +z]", lambda p: len(p.fingers.placements), 98),
        ("fingers.count=3", lambda p: p.fingers.count, 3),
        ("name=a = b", lambda p: p.name, "a = b"),
    ],
)  # fmt: skip
def test_an_override_changes_one_value(override, read, value) -> None:  # type: ignore[no-untyped-def]
    """A dotted path reaches keys, list items by number, and keys that were not there."""
    overrides = [override]
    if "shape.box.2" in override:
        overrides.append("motion.start.position.2=3")
    assert read(load("paper/slide", overrides).problem) == value


def test_later_overrides_win() -> None:
    """They apply in order."""
    scenario = load("paper/slide", ["fingers.radius=2", "fingers.radius=0.5"])
    assert scenario.problem.fingers.radius.tolist() == [0.5, 0.5]


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("fingers.max_normal_forc=5",
         "--set fingers.max_normal_forc=5: unknown key; did you mean 'max_normal_force'?"),
        ("zzz.y=1", "--set zzz.y=1: zzz: unknown key"),
        ("motion.path.3.slide.by=1", "motion.path is a list; no item '3', items are 0 to 0"),
        ("motion.path.x=1", "no item 'x'"),
        ("motion.path.-1.slide=1", "no item '-1'"),
        ("object.mass.x=3", "object.mass is 1; it has no keys"),
        ("fingers.radius.1=3", "fingers.radius is 1; it has no keys or items, set it as a whole"),
        ("object.mass", "expected KEY=VALUE"),
        ("=3", "expected KEY=VALUE"),
        ("object..mass=3", "expected KEY=VALUE"),
        ("object.mass=", "--set object.mass=: value None: must be a finite number"),
        ("object.mass=heavy", "--set object.mass=heavy: value 'heavy': must be a finite number"),
        ("object.mass=[1", "not valid YAML"),
        ("object.mass=1\nfriction: 3", "not one YAML value"),
        ("object.mass=!!python/name:os.system", "not valid YAML"),
        ("motion.path.0.slide.by=[1, 0]",
         "--set motion.path.0.slide.by=[1, 0]: value [1, 0]: must have at least 3 entries"),
        ("object.shape.box.1=-4", "--set object.shape.box.1=-4: value -4: must be > 0"),
        ("motion.start.position.2=1", "--set motion.start.position.2=1: "),
    ],
)  # fmt: skip
def test_a_wrong_override_is_named(override: str, message: str) -> None:
    """The message starts with the override itself and says what would be right."""
    with pytest.raises(ScenarioError) as caught:
        load("paper/slide", [override])
    lines = caught.value.problems
    if override != "motion.start.position.2=1":
        assert any(message in line for line in lines), lines
    assert all("\n" not in line for line in lines)


def test_all_wrong_overrides_are_reported() -> None:
    """Several wrong overrides and what follows from them come together."""
    with pytest.raises(ScenarioError) as caught:
        load("paper/slide", ["nokey", "object.mas=1", "cost.regrasp=-1"])
    assert len(caught.value.problems) == 3
