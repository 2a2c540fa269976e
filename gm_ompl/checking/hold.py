"""Judges the mechanics of one instant: modes, commanded forces and the stability margin."""

from __future__ import annotations

from gm_ompl.checking.recheck import Hold, Recheck
from gm_ompl.checking.report import Findings


def check_hold(recheck: Recheck, hold: Hold, found: Findings) -> None:
    """Judge modes, f_com and z of one instant; note what does not hold."""
    passes = _check_modes(recheck, hold, found)
    legal = _check_forces(recheck, hold, found)
    if passes and legal:
        _check_margin(recheck, hold, found)


def _check_modes(recheck: Recheck, hold: Hold, found: Findings) -> bool:
    claimed = ", ".join(mode.value for mode in hold.modes)
    return found.check(
        "modes",
        not recheck.internal_force(hold),
        f"modes [{claimed}] are claimed; Problem (5) fails for them: excessive internal force "
        "could be generated",
        hold.segment,
    )


def _check_forces(recheck: Recheck, hold: Hold, found: Findings) -> bool:
    legal = True
    limits = recheck.problem.fingers.max_normal_force
    for finger, mode, force in zip(hold.fingers, hold.modes, hold.f_com, strict=True):
        limit = float(limits[finger])
        wrong = ""
        if (force is None) != (mode.value == "position"):
            wrong = (
                f"f_com of finger {finger} is {_number(force)}; under {mode.value} control it is "
                + ("null" if mode.value == "position" else f"a number from 0 to {limit:.9g}")
            )
        elif force is not None:
            slack = recheck.tolerances.force * limit
            excess = max(-force, force - limit)
            if excess > slack:
                wrong = (
                    f"f_com of finger {finger} is {force:.9g}; it is {excess:.3g} outside "
                    f"0 to {limit:.9g}"
                )
        legal = found.check("f_com", not wrong, wrong, hold.segment) and legal
    return legal


def _check_margin(recheck: Recheck, hold: Hold, found: Findings) -> None:
    tolerances, z_min = recheck.tolerances, recheck.problem.mechanics.z_min

    def slack(z: float) -> float:
        return tolerances.z * max(abs(z), tolerances.z_floor * recheck.force_scale)

    z = recheck.margin(hold)
    found.margin(z)
    found.check(
        "z",
        abs(hold.z - z) <= slack(z),
        f"z = {hold.z:.9g} is claimed; with these modes and this f_com it is {z:.9g} "
        f"(off by {abs(hold.z - z):.3g}, allowed {slack(z):.3g})",
        hold.segment,
    )
    best = z if recheck.unbeaten(hold, z + slack(z)) else recheck.best(hold).z
    found.check(
        "best modes",
        z >= best - slack(best),
        f"with these modes and this f_com z is {z:.9g}; Sec. 3.4's best is {best:.9g} "
        f"({best - z:.3g} more, allowed {slack(best):.3g})",
        hold.segment,
    )
    least = min(z, hold.z)
    found.check(
        "z_min",
        least >= z_min * (1.0 - tolerances.z_min),
        f"z is {least:.9g}, below z_min = {z_min:.9g} by {z_min - least:.3g}",
        hold.segment,
    )


def _number(force: float | None) -> str:
    return "null" if force is None else f"{force:.9g}"
