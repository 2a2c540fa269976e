"""A kernel decision's proof, verified by other code: the reference's matrices, and numpy."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.mechanics.certificate import Record
from gm_ompl.reference.exact import Effort, balanced
from gm_ompl.reference.internal_force import InternalForce, exactly, unit_wrenches
from gm_ompl.reference.modes import Modes, maximal_sets
from gm_ompl.reference.proof import upper_bound
from gm_ompl.reference.stability import DIRECTIONS
from gm_ompl.reference.statics import Statics, statics

ALLOWED = 1e-6
"""What z may be off by, relative to max(z, 1e-3 M g)."""

CODES = [d for j in range(6) for d in (2 * j, 2 * j + 1)]
CODES += [d for j in range(12, 44) for d in (j, 87 - j)]
"""The kernel's order of directions: each followed by its opposite."""


def mistake(instant: Instant, decision: ModeDecision, record: Record) -> str:
    """Return what is not proven of a decision, empty where all is."""
    model = statics(instant)
    sets = {int(mask): j for j, mask in enumerate(record.sets) if mask >= 0}
    passed = {_mask(modes): verdict for modes, verdict in maximal_sets([model]).passed}
    if decision.outcome is Outcome.STABLE and set(sets) != set(passed):
        passed = _exactly(model)
    if decision.outcome is Outcome.INTERNAL_FORCE:
        passed = _exactly(model) if passed else passed
        return f"(5) passes for {sorted(passed)}" if passed else ""
    nobody = np.zeros(model.fingers, dtype=bool)
    if decision.outcome is Outcome.NO_EQUILIBRIUM:
        return _no_equilibrium(model, next(iter(passed.values()), None), record)
    if set(sets) != set(passed):
        return f"(5) passes for {sorted(passed)}, the kernel says {sorted(sets)}"
    z = decision.z / model.scale
    allowed = ALLOWED * max(z, 1e-3)
    for mask, verdict in passed.items():
        force, Y = _force(mask, model.fingers), _used(record, sets[mask])
        U = upper_bound(model, force, verdict, Y)
        if not z + allowed >= U and verdict.wrenches.shape[1]:
            U = upper_bound(model, force, exactly(verdict.wrenches), Y)  # separates best
        if not z + allowed >= U:
            return f"z is {z}, set {mask} is only known to stay below {U}"
    if z == 0.0:
        return "" if balanced(model, model.f_max, nobody, Effort()) else "nothing balances the load"
    v = least(model, decision, record.solutions[sets[_mask(decision.modes)]])
    return "" if v >= z - allowed else f"z is {z}, only {v} is held"


def _no_equilibrium(model: Statics, verdict: InternalForce | None, record: Record) -> str:
    if verdict is None:
        return "(5) passes for no set: internal force is the outcome"
    y = record.wrenches[0, 0]
    nobody = np.zeros(model.fingers, dtype=bool)
    size = float(np.linalg.norm(y))
    missed = -upper_bound(model, nobody, verdict, y[None]) * float((DIRECTIONS @ y).max())
    return "" if missed > 0.9e-9 * size > 0.0 else f"equilibrium is missed by {missed / size} only"


def least(model: Statics, decision: ModeDecision, kept: Array) -> float:
    """Return the z that the solutions (N, 76) prove, at the decision's modes and f_com."""
    e, n = model.env_wrenches.shape[1], model.fingers
    tips = _tips(model)
    s = max((columns.shape[1] for columns in tips), default=0)
    tau = kept[0] / max(1.0, float(model.f_max.max(initial=0.0)))
    k = np.maximum(kept[1 : 1 + e + n * s], 0.0)
    whole = np.outer(model.load, tau) + np.hstack([model.env_wrenches, *tips]) @ k
    rest = np.linalg.norm(whole - DIRECTIONS[CODES].T, axis=0)
    pressing = k[e:].reshape(n, s, len(CODES)).sum(axis=1)
    for i, f in enumerate(decision.f_com):
        arm = float(np.linalg.norm(tips[i], axis=0).max())
        if f is None:
            rest += arm * np.maximum(pressing[i] - model.f_max[i] * tau, 0.0)
        else:
            rest += arm * np.abs(pressing[i] - f / model.scale * tau)
    with np.errstate(divide="ignore"):
        z = np.where(rest < 0.5, (1.0 - rest) / tau, 0.0)
    return float(z.min())


def _tips(model: Statics) -> list[Array]:
    """Return per finger its columns for unit normal force (6, s).

    Beside soft fingers the kernel gives a point its plain normal force twice more: the mean of its
    edges.
    """
    tips = [model.rob_wrenches[:, own] / model.normal_parts[i, own]
            for i, own in enumerate(model.columns)]  # fmt: skip
    s = max((columns.shape[1] for columns in tips), default=0)
    return [
        np.hstack([columns] + [columns.mean(axis=1, keepdims=True)] * (s - columns.shape[1]))
        for columns in tips
    ]


def _exactly(model: Statics) -> dict[int, InternalForce]:
    """Return the largest sets that pass (5) with their verdicts, in exact arithmetic."""
    passed: dict[int, InternalForce] = {}
    for mask in sorted(range(1 << model.fingers), key=lambda mask: -mask.bit_count()):
        A = unit_wrenches(model, [i for i in range(model.fingers) if mask >> i & 1])
        if A.shape[1] and not any(mask & other == mask for other in passed):
            verdict = exactly(A)
            if not verdict.excessive:
                passed[mask] = verdict
    return passed


def _used(record: Record, j: int) -> Array:
    used: Array = record.wrenches[j][np.abs(record.wrenches[j]).sum(axis=1) > 0.0]
    return used


def _mask(modes: Modes) -> int:
    return sum(1 << i for i, mode in enumerate(modes) if mode is ControlMode.POSITION)


def _force(mask: int, fingers: int) -> BoolArray:
    return np.array([not mask >> i & 1 for i in range(fingers)], dtype=bool)
