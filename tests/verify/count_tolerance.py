"""What plans tolerate, judged world by world by the reference."""

from __future__ import annotations

import numpy as np

from gm_ompl.tolerance.sites import Site
from tests.tolerances import ends, holds_in, random_site
from tests.verify.counting import Result, count

AT_END = 0.5
"""Share of the worlds that are at the end of an interval; the others are drawn inside."""

TOGETHER = 10
"""Instants whose ends are counted together: a share of few ends says little."""

BEYOND = 1.02
"""Where an interval must have ended, over its end."""


def _site(rng: np.random.Generator) -> Site:
    """Return the next random instant that has a margin."""
    while True:
        site = random_site(rng)
        if site is not None:
            return site


@count(instances=500)
def tolerated_intervals(instance: int) -> Result:
    """Inside the intervals of a random instant the reference never fails: a world per end.

    Half of the worlds are at the end itself, and 10,000 in all. Worst: how many of one instant.
    """
    rng = np.random.default_rng(instance)
    site, judged = _site(rng), 0
    for quantity, last, _, _ in ends(site):
        share = 1.0 if rng.random() < AT_END else float(rng.uniform())
        verdict = holds_in(site, quantity.world(share * last.x))
        if verdict is False:
            return Result(False, note=f"seed {instance}: {quantity.label} {share * last.x}")
        judged += verdict is True
    return Result(True, worst=float(judged), outcome="judged")


@count(instances=20)
def tolerated_ends(instance: int) -> Result:
    """2% beyond the ends of ten instants' intervals, ends of looking aside, 90% of them fail."""
    rng, failing, known = np.random.default_rng(instance), 0, 0
    for site in [_site(rng) for _ in range(TOGETHER)]:
        for quantity, last, _, most in ends(site):
            if last.x != most and last.x != 0.0:
                beyond = holds_in(site, quantity.world(BEYOND * last.x))
                known += beyond is not None
                failing += beyond is False
    return Result(
        0 < 0.9 * known <= failing, worst=1.0 - failing / max(known, 1),
        note=f"seed {instance}: {failing} of {known}", outcome="judged",
    )  # fmt: skip
