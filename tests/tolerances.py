"""Random instants with their best control as sites, and the reference as the judge of worlds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gm_ompl.contact.decision import Outcome
from gm_ompl.errors import SolverError
from gm_ompl.reference.internal_force import excessive_internal_force
from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.robust import margin_in
from gm_ompl.reference.statics import statics
from gm_ompl.tolerance.forces import held
from gm_ompl.tolerance.quantities import Coordinate, frictions, loads_and_places
from gm_ompl.tolerance.reach import Deviations, Spot, reach
from gm_ompl.tolerance.sites import MISSING, Site
from gm_ompl.uncertainty.worlds import NOMINAL, World, in_world
from tests.instances import random_instance, softened

CLOSE = 0.01
"""As near as ``gm_ompl.tolerate`` brings what holds and what does not."""


def random_site(rng: np.random.Generator) -> Site | None:
    """Return a random instant under its best control, z_min somewhere below its z; None without."""
    instant = random_instance(rng)
    if rng.random() < 0.3:
        instant = softened(rng, instant)
    try:
        decision = decide_modes(instant)
    except SolverError:
        return None
    z = decision.z
    if decision.outcome is not Outcome.STABLE or not 1e-3 * instant.force_scale < z < np.inf:
        return None
    n = len(instant.points)
    return Site(
        step=0, segment=0, fingers=tuple(range(n)), instant=instant, modes=decision.modes,
        f_com=np.array([f or 0.0 for f in decision.f_com]), z_min=float(rng.uniform(0.3, 0.95)) * z,
        diagonal=size_of(instant), room=np.full((n, 2, 2), size_of(instant) / 4.0),
    )  # fmt: skip


def size_of(instant: object) -> float:
    """Return a length for an instant without an object: what its points span."""
    points = np.vstack([instant.contacts.points, instant.points])  # type: ignore[attr-defined]
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 1.0


def quantities_at(site: Site) -> list[Coordinate]:
    """Return the quantities that concern a site."""
    instant, n = site.instant, len(site.fingers)
    found = [
        *frictions(instant.environment_friction, instant.friction, ("",)),
        *loads_and_places(instant.mass, n, site.diagonal),
    ]
    return [quantity for quantity in found if quantity.concerns(site)]


def ends(
    site: Site, quantities: Sequence[Coordinate] | None = None
) -> Iterator[tuple[Coordinate, Spot, Spot | None, float]]:
    """Yield, per quantity and side, what holds last, what fails first, and how far one looked."""
    nominal = held(site, NOMINAL, exactly=True, even=True)
    for quantity in quantities_at(site) if quantities is None else quantities:
        line = Deviations(site, quantity, nominal, {})
        for side in (-1, 1):
            most = quantity.within(site, side)
            if most != 0.0:
                yield quantity, *reach(line, most, CLOSE), most


def holds_in(site: Site, world: World) -> bool | None:
    """Judge modes and commands in a world by the reference alone; None where it cannot tell."""
    f_com = [f if forced else None for f, forced in zip(site.f_com, site.force, strict=True)]
    try:
        z = margin_in(site.instant, site.modes, f_com, world)
        verdict = excessive_internal_force(statics(in_world(site.instant, world)), site.position)
    except SolverError:
        return None
    return z >= site.z_min * (1.0 - MISSING) and not verdict.excessive
