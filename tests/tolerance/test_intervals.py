"""Certified intervals of random instants, and the two laws that they rest on."""

from __future__ import annotations

import functools
import itertools

import numpy as np
import pytest

from gm_ompl.reference.stability import DIRECTIONS, stability_at
from gm_ompl.reference.statics import statics
from gm_ompl.tolerance.directions import OPPOSITE, Programs
from gm_ompl.tolerance.forces import Held, held
from gm_ompl.tolerance.mixing import covered, least_coefficient
from gm_ompl.tolerance.sites import MISSING, Site
from gm_ompl.uncertainty.worlds import NOMINAL
from tests.tolerances import ends, holds_in, quantities_at, random_site


@functools.cache
def sites_of(seeds: range) -> list[Site]:
    """Return those of random sites that have a margin."""
    found = (random_site(np.random.default_rng(seed)) for seed in seeds)
    return [site for site in found if site is not None]


@pytest.mark.parametrize("place", range(2))
def test_intervals_neither_overstate_nor_understate(place: int) -> None:
    """Up to its ends the reference never fails; 2% beyond nearly every end it does."""
    rng, site = np.random.default_rng(place), sites_of(range(12))[place]
    all_of_them = quantities_at(site)
    some = [all_of_them[k] for k in rng.permutation(len(all_of_them))[:3]]
    beyond: list[bool | None] = []
    for quantity, last, _, most in ends(site, some):
        for share in (1.0, float(rng.uniform())):
            world = quantity.world(share * last.x)
            assert holds_in(site, world) is not False, (quantity.label, share, last.x)
        if last.x not in (0.0, most):
            beyond.append(holds_in(site, quantity.world(1.02 * last.x)))
    assert beyond.count(False) >= 0.9 * len(beyond)


def test_few_directions_say_what_all_do() -> None:
    """z from few directions is the reference's to 1e-8; forces resist what they should."""
    for site in sites_of(range(12)):
        model = statics(site.instant)
        limits = np.where(site.force, site.f_com / model.scale, model.f_max)
        wanted = stability_at(model, site.modes, limits).z
        found = Programs(model, limits, site.force).solve()
        assert 1.0 / found.most == pytest.approx(wanted, rel=1e-8)
        here = held(site, NOMINAL, exactly=True)
        z = here.slack + site.z_min * (1.0 - MISSING / 2.0) / model.scale
        assert z == pytest.approx(wanted, rel=1e-6)
        left = z * DIRECTIONS - model.load - here.forces @ here.columns.T
        assert np.abs(left).max() < 1e-7 * max(1.0, np.abs(here.forces).max())


def test_opposite_directions_are_listed_as_such() -> None:
    """Each direction and its opposite cancel."""
    assert np.abs(DIRECTIONS + DIRECTIONS[OPPOSITE]).max() == 0.0


def test_mixed_forces_leave_no_more_than_is_said() -> None:
    """No mixture of corners has less left than the least coefficient of Bernstein's form."""
    rng = np.random.default_rng(0)
    for sides in (1, 2, 3):
        slack = rng.uniform(0.0, 1.0, (2,) * sides)
        rests = []
        for side in range(sides):
            shape = [2] * sides
            shape[side] = 1
            rests.append(rng.normal(size=(*shape, 4, 6)) * 0.2)
        least = min(
            least_coefficient(slack, rests, index)
            for index in itertools.product((0, 0.5, 1), repeat=sides)
        )
        for t in rng.uniform(size=(200, sides)):
            assert _left(slack, rests, t) >= least - 1e-12


def _left(slack: np.ndarray, rests: list[np.ndarray], t: np.ndarray) -> float:
    """Return z less the rest's norm at one mixture, by its definition."""
    weights = [np.array([1.0 - share, share]) for share in t]
    z, rest = 0.0, np.zeros(rests[0].shape[-2:])
    for corner in itertools.product((0, 1), repeat=len(t)):
        weight = float(np.prod([w[k] for w, k in zip(weights, corner, strict=True)]))
        z += weight * float(slack[corner])
        for side, values in enumerate(rests):
            if corner[side] == 0:
                other = weight / weights[side][0]
                at = tuple(0 if k == side else c for k, c in enumerate(corner))
                rest += t[side] * (1.0 - t[side]) * other * values[at]
    return z - float(np.linalg.norm(rest, axis=1).max())


def test_corners_without_forces_prove_nothing() -> None:
    """Where z is not positive, nothing is said of worlds between."""
    site = sites_of(range(12))[0]
    here = held(site, NOMINAL)
    none = Held(0.0, here.model, here.columns, here.forces[:0], None)
    assert covered([here, here], 1)
    assert not covered([here, none], 1)
