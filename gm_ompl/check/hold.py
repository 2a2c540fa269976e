"""Judges the mechanics of one instant: modes, commanded forces and the stability margin."""

from __future__ import annotations

from dataclasses import dataclass

from gm_ompl.check.findings import Findings
from gm_ompl.check.referee import Fingers, Forces, Modes, Referee
from gm_ompl.contact.state import ContactState
from gm_ompl.problem import Placements


@dataclass(frozen=True)
class Hold:
    """What the plan claims of an instant.

    Attributes:
        contacts: the environment contacts.
        fingers: the fingers that touch.
        rows: their placements.
        modes: their modes.
        f_com: their commanded forces.
        z: the claimed margin.
        segment: number of the segment, or None for a regrasp.
    """

    contacts: ContactState
    fingers: Fingers
    rows: Placements
    modes: Modes
    f_com: Forces
    z: float
    segment: int | None


def check_hold(referee: Referee, hold: Hold, found: Findings) -> None:
    """Judge modes, f_com and z of one instant; note what does not hold."""
    passes = _check_modes(referee, hold, found)
    legal = _check_forces(referee, hold, found)
    if passes and legal:
        _check_margin(referee, hold, found)


def _check_modes(referee: Referee, hold: Hold, found: Findings) -> bool:
    excessive = referee.internal_force(hold.contacts, hold.fingers, hold.rows, hold.modes)
    claimed = ", ".join(mode.value for mode in hold.modes)
    return found.check(
        "modes",
        not excessive,
        f"modes [{claimed}] are claimed; Problem (5) fails for them: excessive internal force "
        "could be generated",
        hold.segment,
    )


def _check_forces(referee: Referee, hold: Hold, found: Findings) -> bool:
    legal = True
    limits = referee.problem.fingers.max_normal_force
    for finger, mode, force in zip(hold.fingers, hold.modes, hold.f_com, strict=True):
        limit = float(limits[finger])
        wrong = ""
        if (force is None) != (mode.value == "position"):
            wrong = (
                f"f_com of finger {finger} is {_number(force)}; under {mode.value} control it is "
                + ("null" if mode.value == "position" else f"a number from 0 to {limit:.9g}")
            )
        elif force is not None:
            slack = referee.tolerances.force * limit
            excess = max(-force, force - limit)
            if excess > slack:
                wrong = (
                    f"f_com of finger {finger} is {force:.9g}; it is {excess:.3g} outside "
                    f"0 to {limit:.9g}"
                )
        legal = found.check("f_com", not wrong, wrong, hold.segment) and legal
    return legal


def _check_margin(referee: Referee, hold: Hold, found: Findings) -> None:
    tolerances, z_min = referee.tolerances, referee.problem.mechanics.z_min
    z = referee.margin(hold.contacts, hold.fingers, hold.rows, hold.modes, hold.f_com)
    found.margin(z)
    slack = tolerances.z * max(abs(z), tolerances.z_floor * referee.force_scale)
    found.check(
        "z",
        abs(hold.z - z) <= slack,
        f"z = {hold.z:.9g} is claimed; with these modes and this f_com it is {z:.9g} "
        f"(off by {abs(hold.z - z):.3g}, allowed {slack:.3g})",
        hold.segment,
    )
    least = z + tolerances.z * max(abs(z), tolerances.z_floor * referee.force_scale)
    hand = (hold.fingers, hold.rows)
    best, slack = z, 0.0
    if not referee.unbeaten(hold.contacts, hand, hold.modes, hold.f_com, least):
        best = referee.best(hold.contacts, hold.fingers, hold.rows).z
        slack = tolerances.z * max(abs(best), tolerances.z_floor * referee.force_scale)
    found.check(
        "best modes",
        z >= best - slack,
        f"with these modes and this f_com z is {z:.9g}; Sec. 3.4's best is {best:.9g} "
        f"({best - z:.3g} more, allowed {slack:.3g})",
        hold.segment,
    )
    found.check(
        "z_min",
        min(z, hold.z) >= z_min * (1.0 - tolerances.z_min),
        f"z is {min(z, hold.z):.9g}, below z_min = {z_min:.9g} by {z_min - min(z, hold.z):.3g}",
        hold.segment,
    )


def _number(force: float | None) -> str:
    return "null" if force is None else f"{force:.9g}"
