"""z_strong, its best modes and commands, and plans by it, against plainer ways to find them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gm_ompl.contact.decision import ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.mechanics.instant import decide_instant
from gm_ompl.mechanics.strongest import strongest
from gm_ompl.plain.search import plain_search
from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.strong import strong_margin
from gm_ompl.reference.strongest import decide_strongly
from gm_ompl.scenario.load import load
from tests.reference.brute_strong import brute_strong
from tests.reference.test_strong import small_instant
from tests.verify.count_searches import gap, solve
from tests.verify.counting import Result, count


@count(instances=300)
def strong_agreement(instance: int) -> Result:
    """z_strong is what trying every mode of every contact gives, to 1e-6 of max(z, 0.1 M g)."""
    instant = small_instant(instance)
    decision = decide_modes(instant)
    strong = strong_margin(instant, decision.modes, decision.f_com, decision.z)
    brute = brute_strong(instant, decision.modes, decision.f_com, decision.z)
    error = abs(strong.z - brute) / max(decision.z, 0.1 * instant.force_scale)
    return Result(
        holds=error <= 1e-6,
        note=f"seed {instance}: {strong.z} by branch and bound, {brute} by trying all",
        worst=error,
        outcome="gives way below z" if strong.modes else "nothing gives way below z",
    )


@count(instances=200)
def strong_choice_agreement(instance: int) -> Result:
    """The kernel's modes and commands best for z_strong hold what the plain choice's do (1e-6)."""
    instant = replace(small_instant(instance), soft=np.zeros(0))
    plain, found = decide_strongly(instant), strongest(instant)
    held = [decision.outcome is Outcome.STABLE for decision in (plain, found)]
    error = 0.0
    if all(held):
        error = abs(plain.z - found.z) / max(plain.z, 0.1 * instant.force_scale)
    return Result(
        holds=held[0] == held[1] and error <= 1e-6,
        note=f"seed {instance}: {found.z} with {found.f_com}, {plain.z} with {plain.f_com}",
        worst=error,
        outcome="less than z" if plain.nominal != plain.z else "all of z",
    )


@count(instances=100)
def strong_search_agreement(instance: int) -> Result:
    """Planning by z_strong, plain search, astar and dijkstra have one optimum (1e-6; <= 2 fingers).

    A fifth of the scenario's z_min is asked for: of z_strong there is less.
    """
    number = instance
    while load(f"random/small/{number}").problem.fingers.count > 2:
        number += 1000
    scenario = load(f"random/small/{number}")
    z_min = 0.2 * scenario.problem.mechanics.z_min
    problem = scenario.with_({"mechanics.margin": "strong", "mechanics.z_min": z_min}).problem
    optimum = plain_search(problem, _strongly).cost
    gaps = [gap(solve(problem, planner), optimum) for planner in ("astar", "dijkstra")]
    return Result(
        holds=max(gaps) <= 1e-6,
        worst=max(gaps),
        note=f"random/small/{number}: {optimum}, gaps {gaps}",
        outcome="has a plan" if optimum < np.inf else "has none",
    )


def _strongly(instant: Instant, _: object = None) -> ModeDecision:
    nominal = decide_instant(instant)
    return strongest(instant) if nominal.outcome is Outcome.STABLE else nominal
