"""The simulated bodies in a world that differs from the scenario within its uncertainty."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gm_ompl.errors import InputError
from gm_ompl.simulation import world as bodies
from gm_ompl.simulation.execute import Setup
from gm_ompl.uncertainty.worlds import World, shifts


def bodies_in(setup: Setup, world: World) -> bodies.Bodies:
    """Return the bodies of a plan made ready, as they are in a world.

    Raises:
        InputError: the world differs in what is not simulated: surfaces of several frictions, the
            commands' errors, a tilt.
    """
    if len(set(world.environment_friction)) > 1 or any(world.command) or any(world.tilt):
        raise InputError("worlds with frictions by surface, command errors or tilt: not simulated")
    problem, nominal, units = setup.problem, setup.world, setup.units
    first = setup.timeline
    inward = np.einsum("ji,nj->ni", first.rotation[0], first.normal[0])
    heavier = 1.0 + world.mass / problem.mass
    slippery = world.environment_friction[0] if world.environment_friction else 0.0
    tips, offset = nominal.friction, nominal.offset
    if world.finger_friction:
        tips = np.maximum(tips + np.array(world.finger_friction), 0.0)
    if world.position:
        offset = units.length * shifts(inward, np.array(world.position))
    return replace(
        nominal,
        mass=heavier * nominal.mass,
        inertia=heavier * nominal.inertia,
        environment_friction=max(nominal.environment_friction + slippery, 0.0),
        friction=tips,
        centre=units.length * np.array(world.centre_of_mass),
        offset=offset,
    )
