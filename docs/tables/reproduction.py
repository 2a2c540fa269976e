"""``python -m docs.tables.reproduction [PAGE]``: the paper's results beside this planner's.

Plans the paper's scenarios and the cork box's variants and checks every plan, for
docs/results/reproduction.md. Takes about a minute.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import groupby, product

from docs.tables.pages import growing, write_page
from gm_ompl import api
from gm_ompl.planfile.model import DisplacementStep, Plan, RegraspStep
from gm_ompl.study.report import number

PAPER = (
    ("paper/slide", 533, 1007),
    ("paper/push", 203, 378),
    ("paper/tumble", 84, 1294),
    ("paper/regrasp", 990, 1296),
    ("paper/cork", None, None),
)
"""Scenario, and the paper's CPU minutes with A* and without heuristic."""

READINGS = (
    ("as printed: fingers 0.15, environment 1.2", ()),
    ("swapped: fingers 1.2, environment 0.15",
     ("friction.finger=1.2", "friction.environment=0.15")),
)  # fmt: skip
F_MAX = 3.0  # the cork scenario's limit [N]


def results() -> Iterator[tuple[object, ...]]:
    """Yield the rows of the paper's scenarios."""
    for name, with_heuristic, without in PAPER:
        api.plan(name)  # the second time counts: compiled code is loaded
        started = time.process_time()
        plan = api.plan(name)
        seconds = time.process_time() - started
        spent = plan.statistics
        yield (
            name, "; ".join(stages(plan)), _yes(plan.optimal), number(plan.cost, 6),
            number(plan.regrasps), number(spent.expanded), number(spent.mode_decisions),
            f"{seconds:.2f}", number(with_heuristic), number(without),
            _yes(api.check(plan).holds),
        )  # fmt: skip


def cork() -> Iterator[tuple[object, ...]]:
    """Yield the rows of the cork box: two readings of the friction, f_max within 20 %."""
    for (reading, changes), factor in product(READINGS, (0.8, 1.0, 1.2)):
        limit = f"fingers.max_normal_force={factor * F_MAX:g}"
        plan = api.plan(api.load("paper/cork", [*changes, limit]))
        yield (
            reading, f"{factor * F_MAX:g}", plan.status, _yes(plan.optimal),
            number(plan.cost, 6), number(plan.regrasps), "; ".join(stages(plan)) or "-",
            _yes(one_finger_in_force_control(plan)), number(plan.least_z),
            _yes(api.check(plan).holds),
        )  # fmt: skip


def stages(plan: Plan) -> Iterator[str]:
    """Yield the plan in words, one stage per placement set and combination of modes."""
    for _, group in groupby(_segments(plan), key=lambda row: row[2:]):
        part = list(group)
        start, end, what = part[0][0], part[-1][1], part[0][2]
        yield what if part[0][3] == "regrasp" else f"{start:.2f} to {end:.2f}: {what}"


def _segments(plan: Plan) -> Iterator[tuple[float, float, str, str]]:
    """Yield (from, to, words, kind) per segment or regrasp."""
    for step in plan.steps:
        if isinstance(step, RegraspStep):
            old, new = step.from_.face, step.to.face
            words = f"at {step.at[0]:.2f} finger {step.finger} goes from {old} to {new}"
            yield step.at[0], step.at[0], words, "regrasp"
            continue
        assert isinstance(step, DisplacementStep)
        P, low, length = len(step.segments), step.from_[0], step.to[0] - step.from_[0]
        for j, segment in enumerate(step.segments):
            pairs = zip(step.placements, segment.modes, strict=True)
            words = ", ".join(f"{place.face} {mode}" for place, mode in pairs)
            yield low + j / P * length, low + (j + 1) / P * length, words, "displacement"


def one_finger_in_force_control(plan: Plan) -> bool:
    """Whether one finger is under force control and one under position control throughout."""
    modes = {segment.modes for segment in plan.segments}
    return modes in ({("position", "force")}, {("force", "position")})


def _yes(value: bool) -> str:
    return "yes" if value else "no"


if __name__ == "__main__":
    write_page("reproduction", {
        "results": growing((
            "scenario", "plan", "proven optimal", "cost", "regrasps", "nodes expanded",
            "mode decisions", "CPU s", "paper: A*, min", "paper: no heuristic, min", "check",
        ), results()),
        "cork": growing((
            "friction", "f_max, N", "ends", "proven optimal", "cost", "regrasps", "plan",
            "one finger in force control throughout", "least z, N", "check",
        ), cork()),
    })  # fmt: skip
