"""Sec. 3.4: the control modes, and commanded forces, that make manipulation most stable."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.reference.bases import Bases
from gm_ompl.reference.cases import cases, stabilities, stability_in
from gm_ompl.reference.equilibrium import BALANCED, central_command
from gm_ompl.reference.internal_force import InternalForce, judged, unit_wrenches
from gm_ompl.reference.stability import Stability, stability_at
from gm_ompl.reference.statics import Statics, force_unit, statics
from gm_ompl.uncertainty.worlds import squeezing

Modes = tuple[ControlMode, ...]

TIE = 1e-7
"""Margins that differ by no more than this, relatively, are equal."""


@dataclass(frozen=True, eq=False)
class ModeSet:
    """What Sec. 3.4 finds for one combination of modes.

    Attributes:
        modes: per finger.
        internal_force: the verdict of Problem (5).
        stability: the optimum of Problem (6), in units of the force scale; None where
            Problem (5) rules the combination out.
    """

    modes: Modes
    internal_force: InternalForce
    stability: Stability | None


def decide_modes(instant: Instant, prefer: Modes | None = None) -> ModeDecision:
    """Return the best modes at an instant and their commanded forces (Sec. 3.4).

    Args:
        instant: the contacts, the fingers, the object.
        prefer: modes to prefer among equally many position-controlled fingers, in a tie.

    Raises:
        SolverError: the solver returned no answer.
    """
    return decision(best_mode_set(instant, prefer), instant)


def best_mode_set(instant: Instant, prefer: Modes | None = None) -> ModeSet | None:
    """Return the best combination of modes with its proofs; None where none passes (5).

    Combinations with more position-controlled fingers come first, and two kinds are skipped
    unjudged: where a subset of the position-controlled fingers fails Problem (5) so does the
    whole; where a superset passed, z cannot be larger, as a force-controlled finger's forces
    are among those of the same finger under position control.

    Where something is uncertain (5) must hold, and z is the least, in all cases.

    Args:
        instant: the contacts, the fingers, the object.
        prefer: modes to prefer among equally many position-controlled fingers, in a tie.

    Raises:
        SolverError: the solver returned no answer.
    """
    among = cases(instant)
    sets = [
        ModeSet(modes, verdict, stability_in(among, modes))
        for modes, verdict in maximal_sets(squeezed(instant)).passed
    ]
    return choose(sets, prefer)


def all_mode_sets(instant: Instant) -> tuple[ModeSet, ...]:
    """Judge every combination of modes, none skipped, as Sec. 3.4 is written.

    Raises:
        SolverError: the solver returned no answer.
    """
    among, models = cases(instant), squeezed(instant)
    judgements = ((modes, _excessive(models, modes)) for modes in combinations(models[0].fingers))
    return tuple(
        ModeSet(modes, verdict, None if verdict.excessive else stability_in(among, modes))
        for modes, verdict in judgements
    )


def squeezed(instant: Instant) -> tuple[Statics, ...]:
    """Return the mechanics with whose columns together Problem (5) is asked."""
    return tuple(statics(there) for there in squeezing(instant))


def passes(instant: Instant, modes: Modes) -> bool:
    """Whether a combination of modes passes Problem (5)."""
    return not _excessive(squeezed(instant), modes).excessive


def margin(
    instant: Instant, modes: Sequence[ControlMode], f_com: Sequence[float | None],
    allowed: float = BALANCED,
) -> float:  # fmt: skip
    """Return z for fixed modes and fixed f_com, in the worst case; Problem (5) is not asked.

    Args:
        instant: the contacts, the fingers, the object.
        modes: per finger.
        f_com: per finger, its commanded normal force; None under position control.
        allowed: what may be missing of equilibrium, over M g.

    Raises:
        SolverError: the solver returned no answer.
    """
    among, scale = cases(instant), force_unit(instant)
    commanded = np.array([0.0 if f is None else f for f in f_com], dtype=np.float64)
    if len(among) == 1:
        return stability_at(among[0].model, modes, commanded / scale, allowed).z * scale
    found = stabilities(among, modes, commanded / scale, Bases(), allowed)
    return min(each.z for each in found) * scale


def choose(sets: Sequence[ModeSet], prefer: Modes | None = None) -> ModeSet | None:
    """Return the judged set with the largest z, ties broken; None where none passes (5).

    Of sets tied the one with more position-controlled fingers wins, then ``prefer``, then the
    lexicographically first, position before force.
    """
    passed = [s for s in sets if s.stability is not None]
    if not passed:
        return None
    most = max(_z(s) for s in passed)
    tied = [s for s in passed if _z(s) >= most - TIE * abs(most)] if np.isfinite(most) else [
        s for s in passed if _z(s) == most
    ]  # fmt: skip
    return min(tied, key=lambda s: (_rank(s.modes), s.modes != prefer, _letters(s.modes)))


def decision(best: ModeSet | None, instant: Instant) -> ModeDecision:
    """Turn the chosen set into a decision, forces in the scenario's units."""
    if best is None or best.stability is None:
        return ModeDecision(Outcome.INTERNAL_FORCE, -np.inf)
    if best.stability.z == -np.inf:
        return ModeDecision(Outcome.NO_EQUILIBRIUM, -np.inf)
    scale, commands = force_unit(instant), best.stability.f_com
    if best.stability.z == 0.0 and ControlMode.FORCE in best.modes and not instant.uncertainty:
        force = np.array([mode is ControlMode.FORCE for mode in best.modes])
        central = central_command(statics(instant), force)
        commands = commands if central is None else central
    f_com = tuple(
        min(float(f) * scale, float(most)) if mode is ControlMode.FORCE else None
        for mode, f, most in zip(best.modes, commands, instant.max_normal_force, strict=True)
    )
    z = best.stability.z * scale
    return ModeDecision(Outcome.STABLE, z, best.modes, f_com, best.stability.direction)


def combinations(fingers: int) -> list[Modes]:
    """Return all combinations of modes, more position-controlled fingers first."""
    both = (ControlMode.POSITION, ControlMode.FORCE)
    return sorted(
        itertools.product(both, repeat=fingers), key=lambda m: (_rank(m), _letters(m))
    )  # fmt: skip


@dataclass(frozen=True)
class MaximalSets:
    """The largest sets of position-controlled fingers that pass Problem (5).

    Attributes:
        passed: per set its modes, preferred first, and its verdict.
        marginal: whether some larger set was given up though neither verdict is proven.
    """

    passed: tuple[tuple[Modes, InternalForce], ...]
    marginal: bool


def maximal_sets(models: Sequence[Statics]) -> MaximalSets:
    """Ask Problem (5) of as few sets as tell, with the columns of all ``models`` together.

    Raises:
        SolverError: the solver returned no answer.
    """
    passed: dict[frozenset[int], tuple[Modes, InternalForce]] = {}
    failed: list[frozenset[int]] = []
    marginal = False
    for modes in combinations(models[0].fingers):
        position = _position(modes)
        # The largest sets first: most often all fingers, or all but one, pass at once.
        if any(position <= other for other in passed) or any(position >= f for f in failed):
            continue
        verdict = _excessive(models, modes)
        marginal = marginal or verdict.marginal
        if verdict.excessive:
            failed.append(position)
        else:
            passed[position] = modes, verdict
    return MaximalSets(tuple(passed.values()), marginal)


def _excessive(models: Sequence[Statics], modes: Modes) -> InternalForce:
    return judged(np.hstack([unit_wrenches(model, _position(modes)) for model in models]))


def _position(modes: Modes) -> frozenset[int]:
    return frozenset(i for i, mode in enumerate(modes) if mode is ControlMode.POSITION)


def _rank(modes: Modes) -> int:
    return sum(mode is ControlMode.FORCE for mode in modes)


def _letters(modes: Modes) -> tuple[bool, ...]:
    return tuple(mode is ControlMode.FORCE for mode in modes)


def _z(judged: ModeSet) -> float:
    return -np.inf if judged.stability is None else judged.stability.z
