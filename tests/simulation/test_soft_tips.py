"""Soft fingertips in both simulators: the moment that they hold, about the normal."""

from __future__ import annotations

import importlib.util
import os
from dataclasses import replace

import numpy as np
import pytest

from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.engine import STEP, EngineName
from gm_ompl.simulation.engines import start
from gm_ompl.simulation.execute import prepare

pytestmark = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("mujoco", "dartpy"))
    and not os.environ.get("CI"),
    reason="MuJoCo or DART is not installed",
)

UPRIGHT, FORCE, SOFT, MU = np.array([1.0, 0.0, 0.0, 0.0]), 2.0, 0.01, 0.5


def turned(
    engine: EngineName, plan: Plan, soft: float, moment: float, again: bool = False
) -> float:
    """Return by how much a pinched box turns in 0.3 s under a moment about the pinch [rad]."""
    side = np.array([-0.05, 0.05])
    box = np.array([[x, y, z] for x in side for y in side for z in side])
    nominal = prepare(plan).world
    reach = 0.05 + float(nominal.radius[0])
    world = replace(
        nominal, pieces=(box,), obstacles=(), floor=False, gravity=0.0,
        friction=np.full(2, MU), soft=np.full(2, soft),
    )  # fmt: skip
    centres = np.array([[0.0, -reach, 0.0], [0.0, reach, 0.0]])
    physics = start(engine, world, np.zeros(3), UPRIGHT, centres)
    push = np.array([[0.0, FORCE, 0.0], [0.0, -FORCE, 0.0]])
    for k in range(round(0.4 / STEP)):
        wrench = np.array([0.0, 0.0, 0.0, 0.0, moment if k * STEP >= 0.1 else 0.0, 0.0])
        if again and k == round(0.2 / STEP):  # a state that was put back goes on alike
            physics.restore(physics.state())
        physics.step(push, UPRIGHT, np.zeros(3), wrench)
    return 2.0 * abs(float(np.arcsin(physics.quaternion[2])))


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
def test_soft_fingertips_hold_mu_L_f(cork_plan: Plan, engine: EngineName) -> None:
    """Two hold 0.9 of 2 mu L f_n, not 1.3 of it; points hold next to nothing."""
    limit = 2.0 * MU * SOFT * FORCE
    held = turned(engine, cork_plan, SOFT, 0.9 * limit)
    assert held <= 0.01
    assert turned(engine, cork_plan, SOFT, 0.9 * limit, again=True) == pytest.approx(held, abs=1e-6)
    assert turned(engine, cork_plan, SOFT, 1.3 * limit) > 0.1
    assert turned(engine, cork_plan, 0.0, 0.3 * limit) > 0.1
