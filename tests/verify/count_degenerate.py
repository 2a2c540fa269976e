"""Degenerate instants: what the kernel decides, proven again by other code."""

from __future__ import annotations

import numpy as np

from gm_ompl.contact.decision import ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError
from gm_ompl.mechanics.instant import prove_instant
from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.proof import proven_decision
from gm_ompl.reference.statics import force_unit
from tests.certified import mistake
from tests.degenerate import degenerate_instance
from tests.mechanics.agreement import AGREE, z_error
from tests.verify.counting import Result, count

BATCH = 50
"""Instants per instance of a count."""


@count(instances=1000)
def degenerate_instants(instance: int) -> Result:
    """Of 50 degenerate instants none is lost, and other code proves each z (worst: fallbacks).

    To 1e-6 of max(z, 1e-3 M g), from the reference's matrices.
    """
    notes, fallbacks = [], 0
    for seed in range(BATCH * instance, BATCH * (instance + 1)):
        instant = degenerate_instance(np.random.default_rng(seed))
        try:
            found = mistake(instant, *prove_instant(instant))
        except SolverError:
            fallbacks += 1
            found = "" if proven_decision(instant) else "lost"
        if found:
            notes.append(f"seed {seed}: {found}")
    return Result(holds=not notes, worst=float(fallbacks), note="; ".join(notes))


@count(instances=500)
def degenerate_agreement(instance: int) -> Result:
    """HiGHS decides degenerate instants alike (every hundredth of them), where it proves itself."""
    instant = degenerate_instance(np.random.default_rng(100 * instance))
    theirs = decide_modes(instant)
    mine = _decided(instant)
    error = 0.0 if mine.outcome is theirs.outcome else np.inf
    if mine.outcome is theirs.outcome is Outcome.STABLE:
        error = z_error(mine.z, theirs.z, force_unit(instant))
    unproven = error > AGREE and _same(proven_decision(instant), mine, force_unit(instant))
    return Result(
        holds=error <= AGREE or unproven,
        worst=error if np.isfinite(error) else None,
        note=f"seed {100 * instance}: {mine}, HiGHS {theirs}",
        outcome="HiGHS does not prove its answer" if unproven else theirs.outcome.name.lower(),
    )


def _decided(instant: Instant) -> ModeDecision:
    try:
        return prove_instant(instant)[0]
    except SolverError:
        decision = proven_decision(instant)
        assert decision is not None, "nobody decides"
        return decision


def _same(one: ModeDecision | None, other: ModeDecision, unit: float) -> bool:
    """Whether a proven decision is the other one."""
    if one is None or one.outcome is not other.outcome:
        return False
    return one.z == other.z or z_error(one.z, other.z, unit) <= AGREE
