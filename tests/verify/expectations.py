"""Holds a plan against its scenario's ``expect``."""

from __future__ import annotations

from collections.abc import Iterator

from gm_ompl.planfile.model import DisplacementStep, Plan, RegraspStep
from gm_ompl.scenario.model import ExpectAtModel, ExpectModel

COST = 1e-6
"""Relative difference allowed in an expected cost."""


def disagreements(plan: Plan, expect: ExpectModel) -> Iterator[str]:
    """Yield a sentence for everything in which ``plan`` is not as expected."""
    if expect.status is not None and plan.status != expect.status:
        yield f"status is {plan.status}, expected {expect.status}"
        return
    if expect.regrasps is not None and plan.regrasps != expect.regrasps:
        yield f"{plan.regrasps} regrasps, expected {expect.regrasps}"
    if expect.cost is not None and (
        plan.cost is None or abs(plan.cost - expect.cost) > COST * expect.cost
    ):
        yield f"cost is {plan.cost}, expected {expect.cost}"
    if expect.regrasp_between is not None:
        low, high = expect.regrasp_between
        for step in plan.steps:
            if isinstance(step, RegraspStep) and not low <= step.at[0] <= high:
                yield f"regrasp at {step.at[0]:.4g}, expected from {low:.4g} to {high:.4g}"
    for point in expect.at:
        yield from _at(plan, point)


def _at(plan: Plan, point: ExpectAtModel) -> Iterator[str]:
    """Compare the fingers at one s, in any order: equal fingers may be exchanged."""
    found = state_at(plan, point.s)
    if found is None:
        yield f"no motion at s = {point.s:g}"
        return
    for what, want in (("faces", point.faces), ("modes", point.modes)):
        have = [face if what == "faces" else mode for face, mode in found]
        if want is not None and sorted(have) != sorted(want):
            yield f"{what} at s = {point.s:g} are {have}, expected {list(want)}"
    if point.faces is not None and point.modes is not None:
        pairs = sorted(zip(point.faces, point.modes, strict=True))
        if sorted(found) != pairs:
            yield f"at s = {point.s:g} the fingers are {found}, expected {pairs}"


def state_at(plan: Plan, s: float) -> list[tuple[str, str]] | None:
    """Return (face, mode) per finger in the segment at ``s`` of a path."""
    for step in plan.steps:
        if isinstance(step, DisplacementStep) and step.from_[0] <= s <= step.to[0]:
            part = (s - step.from_[0]) / (step.to[0] - step.from_[0])
            k = min(int(part * len(step.segments)), len(step.segments) - 1)
            faces = (place.face for place in step.placements)
            return list(zip(faces, step.segments[k].modes, strict=True))
    return None
