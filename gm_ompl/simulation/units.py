"""From a scenario's units to the simulator's: every object becomes as large as the cork box.

A quasi-static problem has two scales of its own, the object's size and its weight; lengths and
forces only count against them. A simulator has absolute ones: contact stiffness, time steps,
solver tolerances. So every scenario is simulated at the size, mass and gravity of the paper's
experiment (Sec. 5.3), which itself is left as it is, whatever its units.
"""

from __future__ import annotations

from dataclasses import dataclass

from gm_ompl.errors import InputError
from gm_ompl.problem import Problem

SIZE = 0.0172**0.5
"""D of the cork box, 60 x 60 x 100 mm [m]."""

MASS = 0.092
"""M of the cork box [kg]."""

GRAVITY = 9.8
"""The paper's [m/s^2]."""


@dataclass(frozen=True)
class Units:
    """Factors that take a scenario's numbers to SI numbers in the simulator.

    Attributes:
        length: metres per unit of length.
        mass: kilograms per unit of mass.
        force: newtons per unit of force.
        gravity: g in the simulator [m/s^2]; 0 where the scenario has none.
    """

    length: float
    mass: float
    force: float
    gravity: float

    @classmethod
    def of(cls, problem: Problem) -> Units:
        """Return the units in which ``problem`` is simulated.

        Without gravity the unit of force is such that the largest f_max is the cork box's weight.

        Raises:
            InputError: no gravity, and no finger may press: nothing can be simulated.
        """
        length, mass = SIZE / problem.body.diagonal, MASS / problem.mass
        weight = problem.mass * problem.mechanics.gravity
        if weight > 0:
            return cls(length, mass, MASS * GRAVITY / weight, GRAVITY)
        strongest = float(problem.fingers.max_normal_force.max(initial=0.0))
        if strongest <= 0:
            raise InputError("without gravity some finger must have a max_normal_force above 0")
        return cls(length, mass, MASS * GRAVITY / strongest, 0.0)
