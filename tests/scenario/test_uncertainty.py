"""The key ``uncertainty``: ranges in numbers, and one line for each mistake."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.contact.environment import contacts_at
from gm_ompl.errors import ScenarioError
from gm_ompl.motion.arc import Moment
from gm_ompl.scenario.scenario import Scenario

WALL = {"floor": True, "obstacles": {"wall": {"box": {"min": [2.5, -50, 0], "max": [9, 50, 50]}}}}


def pushed(**uncertainty: Any) -> Scenario:
    """A box that slides along a wall, with ranges."""
    return Scenario.from_mapping({
        "object": {"shape": {"box": [5, 5, 10]}, "mass": 2},
        "friction": {"environment": 0.5, "finger": [0.7, 0.4]},
        "fingers": {"count": 2, "radius": 1, "max_normal_force": 10},
        "environment": WALL,
        "motion": {"start": {"position": [0, 0, 5]}, "path": [{"slide": {"by": [0, 15, 0]}}]},
        "lattice": {"segments": 3},
        "uncertainty": uncertainty,
    })  # fmt: skip


def test_percentages_are_of_the_nominal_values() -> None:
    """Of coefficients, mass, sides, the size D, and what is commanded."""
    ranges = pushed(
        environment_friction="10 %", finger_friction="20%", mass="5 %", centre_of_mass="10 %",
        command="3 %", tilt="2 deg",
    ).problem.uncertainty  # fmt: skip
    assert ranges.environment_friction == pytest.approx((0.05,))
    assert ranges.finger_friction == pytest.approx((0.14, 0.08))
    assert ranges.mass == pytest.approx(0.1)
    assert ranges.centre_of_mass == pytest.approx((0.5, 0.5, 1.0))
    assert pushed(position="1 %").problem.uncertainty.position == pytest.approx(
        0.01 * math.sqrt(150)
    )
    assert (ranges.command, ranges.tilt) == pytest.approx((0.03, math.tan(math.radians(2.0))))


def test_numbers_are_half_widths() -> None:
    """In the scenario's units; a list counts for each finger, or axis."""
    ranges = pushed(
        finger_friction=[0.1, 0], mass=0.3, centre_of_mass=[0.1, "2 %", 0], position=0.2
    ).problem.uncertainty
    assert ranges.finger_friction == (0.1, 0.0)
    assert (ranges.mass, ranges.position) == (0.3, 0.2)
    assert ranges.centre_of_mass == pytest.approx((0.1, 0.1, 0.0))


def test_nothing_is_uncertain_by_default() -> None:
    """No key, an empty one, and ranges of no width are all the nominal problem."""
    for scenario in (gm_ompl.load("paper/slide"), pushed(), pushed(mass=0, command="0 %")):
        assert not scenario.problem.uncertainty


def test_the_resolved_scenario_says_the_same() -> None:
    """As it stands in a plan file."""
    scenario = pushed(environment_friction={"wall": "10 %"}, tilt="2 deg", mass=0.1)
    again = Scenario.from_resolved(scenario.resolved())
    assert again.problem.uncertainty == scenario.problem.uncertainty
    assert "uncertainty" not in gm_ompl.load("paper/slide").resolved()


def test_each_surface_has_its_own_range() -> None:
    """Contacts know what they are on; what is not named is known exactly."""
    problem = pushed(environment_friction={"wall": 0.2}).problem
    assert problem.uncertainty.environment_friction == (0.0, 0.2)
    contacts = contacts_at(Moment(problem.motion.pose((0.0,))), problem.body, problem.environment)
    on_wall = np.abs(contacts.normals @ contacts.rotation[0]) > 0.5
    assert on_wall.any() and not on_wall.all()
    assert (contacts.surfaces == on_wall).all()


@pytest.mark.parametrize(
    ("given", "key", "remedy"),
    [
        ({"mas": 1}, "uncertainty.mas", "did you mean 'mass'"),
        ({"mass": "lots"}, "uncertainty.mass", "a percentage, for example 0.05 or 10 %"),
        ({"mass": -1}, "uncertainty.mass", "a number >= 0"),
        ({"mass": True}, "uncertainty.mass", "a number >= 0"),
        ({"mass": 2}, "uncertainty.mass", "at most 90 % of object.mass, 2"),
        ({"mass": "95 %"}, "uncertainty.mass", "some mass must be left"),
        (
            {"environment_friction": 0.6},
            "environment_friction",
            "at most friction.environment, 0.5",
        ),
        ({"environment_friction": {"wal": 0.1}}, "environment_friction.wal", "did you mean 'wall'"),
        ({"environment_friction": {"wall": "110 %"}}, "environment_friction.wall", "100 %"),
        ({"environment_friction": {"wall": "a"}}, "environment_friction.wall", "or 10 %"),
        ({"finger_friction": 0.5}, "finger_friction", "at most friction.finger, 0.4"),
        ({"finger_friction": [0.1, 0.5]}, "finger_friction.1", "at most friction.finger, 0.4"),
        ({"finger_friction": [0.1]}, "finger_friction", "one entry per finger: 2"),
        ({"centre_of_mass": [1, 2]}, "centre_of_mass", "3"),
        ({"centre_of_mass": [1, "x", 2]}, "centre_of_mass.1", "percentage"),
        ({"command": 0.1}, "uncertainty.command", "from 0 % to 90 %"),
        ({"command": "100 %"}, "uncertainty.command", "from 0 % to 90 %"),
        ({"tilt": 2}, "uncertainty.tilt", "90 deg or 1.57 rad"),
        ({"tilt": "45 deg"}, "uncertainty.tilt", "from 0 deg to 30 deg"),
        ({"tilt": "-1 deg"}, "uncertainty.tilt", "from 0 deg to 30 deg"),
    ],
)
def test_mistakes_are_named(given: dict[str, Any], key: str, remedy: str) -> None:
    """Key, value and what would be right; a message each."""
    with pytest.raises(ScenarioError) as caught:
        pushed(**given)
    (line,) = caught.value.problems
    assert key in line and remedy in line


def test_too_many_cases_are_refused_with_a_remedy() -> None:
    """Each is judged in every decision."""
    everything = {
        "environment_friction": "1 %", "mass": "1 %", "centre_of_mass": "1 %", "tilt": "1 deg",
        "position": 0.1, "command": "1 %",
    }  # fmt: skip
    with pytest.raises(ScenarioError, match=r"8192 cases.*leave out position or command"):
        pushed(**everything)
