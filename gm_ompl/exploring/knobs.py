"""What can be turned and dragged in a scenario, as the keys and values of its file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from gm_ompl.scenario.scenario import Scenario
from gm_ompl.scenario.uncertain import half_width

LOG_SPAN: Final = 10.0  # a logarithmic slider goes from a tenth to ten times the file's value
FRICTION_TOP: Final = 1.5  # sliders of friction go this far at least
Z_MIN_SPAN: Final = 4.0  # those of z_min to so many times the file's value
WEIGHT_SHARE: Final = 0.2  # or, where that is 0, to this share of the object's weight
UNCERTAIN_TOP: Final = 30.0  # those of uncertainty to so many per cent at least


@dataclass(frozen=True)
class Slider:
    """A number of the scenario, and how far its slider goes."""

    key: str  # where it stands, as --set takes it
    label: str
    value: float  # in the file; angles in degrees
    low: float
    high: float
    step: float  # 0: as fine as the slider
    logarithmic: bool = False
    unit: str = ""  # what is written after the number in the file


def knobs(scenario: Scenario) -> list[Slider]:
    """Return the knobs of a scenario, in the order in which they are shown."""
    return [
        *_contacts(scenario), *_loads(scenario), *_uncertain(scenario), *_angles(scenario),
    ]  # fmt: skip


def _contacts(scenario: Scenario) -> Iterator[Slider]:
    model = scenario.model
    yield _friction("friction.environment", "friction, environment", model.friction.environment)
    for key, label, value in _each("friction.finger", "friction", model.friction.finger):
        yield _friction(key, label, value)
    fingers = model.fingers
    if fingers.count:
        for key, label, value in _each("fingers.radius", "radius", fingers.radius):
            yield Slider(key, label, value, value / 4, value * 2, 0.0, logarithmic=True)
        limits = _each("fingers.max_normal_force", "f_max", fingers.max_normal_force)
        for key, label, value in limits:
            yield _logarithmic(key, label, value)


def _friction(key: str, label: str, value: float) -> Slider:
    return Slider(key, label, value, 0.0, max(FRICTION_TOP, 2.0 * value), 0.01)


def _logarithmic(key: str, label: str, value: float) -> Slider:
    return Slider(key, label, value, value / LOG_SPAN, value * LOG_SPAN, 0.0, logarithmic=True)


def _each(key: str, label: str, given: float | Sequence[float]) -> Iterator[tuple[str, str, float]]:
    """Yield key, label and value; of a list, one by one."""
    if isinstance(given, Sequence):
        for i, value in enumerate(given):
            yield f"{key}.{i}", f"{label}, finger {i}", value
    else:
        yield key, f"{label}, fingers", given


def _loads(scenario: Scenario) -> Iterator[Slider]:
    model = scenario.model
    z_min = model.mechanics.z_min
    high = Z_MIN_SPAN * z_min or WEIGHT_SHARE * model.object.mass * model.gravity or 1.0
    yield Slider("mechanics.z_min", "z_min", z_min, 0.0, high, 0.0)
    yield _logarithmic("object.mass", "mass", model.object.mass)


def _uncertain(scenario: Scenario) -> Iterator[Slider]:
    """Yield the ranges that are one percentage, or could be."""
    model, given = scenario.model, scenario.model.uncertainty
    fingers = model.friction.finger
    nominal = {
        "environment_friction": model.friction.environment,
        "finger_friction": fingers if isinstance(fingers, float) else 0.0,
        "mass": model.object.mass,
        "centre_of_mass": 0.0,  # of the object's sides, which are several
    }
    for name, whole in nominal.items():
        amount = getattr(given, name, None)
        if isinstance(amount, float) and whole == 0.0:
            continue
        if amount is None or isinstance(amount, (float, str)):
            value = _tidy(100.0 * half_width(amount, whole or 1.0) / (whole or 1.0))
            label = f"uncertain {name.replace('_', ' ')}"
            high = max(UNCERTAIN_TOP, 2.0 * value)
            yield Slider(f"uncertainty.{name}", label, value, 0.0, high, 0.5, unit="%")


def _angles(scenario: Scenario) -> Iterator[Slider]:
    motion, steps = scenario.model.motion, scenario.model.lattice.steps
    step = math.degrees(steps.given.get("yaw", 0.0)) if steps else 0.0
    for k, piece in enumerate(motion.path or ()):
        if piece.tumble is not None:
            key, label = f"motion.path.{k}.tumble.angle", f"angle, tumble {k + 1}"
            angle = math.degrees(piece.tumble.angle)
            yield Slider(key, label, _tidy(angle), 1.0, 180.0, 1.0, unit="deg")
    for key, label, value in _turns(scenario):
        yield Slider(key, label, value, -180.0, 180.0, step or 1.0, unit="deg")


def _turns(scenario: Scenario) -> Iterator[tuple[str, str, float]]:
    """Yield the angles that start and goal give, in degrees, and their keys."""
    motion = scenario.model.motion
    free_to_turn = motion.planar is not None or motion.free is not None
    for name, part in (("start", motion.start), ("goal", motion.goal)):
        if part is None or not free_to_turn:
            continue
        rotation = getattr(part, "rotation", None)
        for owner, key in ((part, "yaw"), (rotation, "rotation.yaw"), (rotation, "rotation.angle")):
            value = getattr(owner, key.rpartition(".")[2], None)
            other = owner is part and rotation is not None  # then yaw is not to be given
            if isinstance(value, float) and not other:
                yield f"motion.{name}.{key}", f"{name}, turned", _tidy(math.degrees(value))


def _tidy(value: float) -> float:
    """Return ``value`` without what conversion of units adds to it."""
    return float(f"{value:.12g}")
