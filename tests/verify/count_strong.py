"""z_strong by branch and bound against every combination of modes, on random instants."""

from __future__ import annotations

from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.strong import strong_margin
from tests.reference.brute_strong import brute_strong
from tests.reference.test_strong import small_instant
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
