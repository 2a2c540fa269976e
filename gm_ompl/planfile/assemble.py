"""From a planner's moves to a plan: the same for every planner."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.paths import JointPaths
from gm_ompl.planfile.arcs import arc_record
from gm_ompl.planfile.model import (
    FORMAT,
    DisplacementStep,
    HandRecord,
    Mode,
    PlacementRecord,
    Plan,
    RegraspStep,
    Statistics,
    Status,
)
from gm_ompl.planfile.record import PlanPart, PoseRecord
from gm_ompl.problem import Displacement, Move, Problem

Part = TypeVar("Part", bound=PlanPart)

ROUNDING = 1e-9  # a solver may return f_com this far (relative to f_max) outside [0, f_max]


def assemble(
    problem: Problem,
    scenario: Mapping[str, Any],
    moves: Sequence[Move] = (),
    *,
    status: Status,
    planner: str,
    statistics: Mapping[str, Any],
    seed: int | None = None,
    parameters: Mapping[str, Any] | None = None,
    optimal: bool = False,
    lower_bound: float | None = None,
    paths: JointPaths | None = None,
) -> Plan:
    """Return the plan that ``moves`` make.

    Cost and number of regraspings follow from the moves; without a plan both are None.

    Args:
        problem: the problem that was solved.
        scenario: the scenario as resolved, the source of ``problem``.
        moves: from start to goal; none without a plan.
        status: how the search ended.
        planner: the planner's name.
        statistics: at least ``time_s``, ``expanded``, ``mode_decisions`` and ``history``;
            infinite numbers become None.
        seed: the random seed.
        parameters: the planner's parameters.
        optimal: whether the plan is proven optimal on the lattice.
        lower_bound: no plan is cheaper; None or infinite where no number can be given. Rounding
            above the cost is taken back.
        paths: a hand's joint paths along the moves.

    Raises:
        pydantic.ValidationError: ``statistics`` or ``parameters`` cannot be stored as JSON.
    """
    steps = tuple(_step(problem, move) for move in moves)
    plain: dict[str, Any] = {
        k: _finite(v) if isinstance(v, float) else v for k, v in statistics.items()
    }
    history = tuple(
        (float(t), _finite(cost), _finite(low)) for t, cost, low in plain.pop("history")
    )
    cost = math.fsum(step.cost for step in steps) if status == "solved" or steps else None
    if cost is not None and lower_bound is not None:
        lower_bound = min(lower_bound, cost)
    return Plan(
        format=FORMAT,
        status=status,
        planner=planner,
        seed=seed,
        parameters=dict(parameters or {}),
        optimal=optimal,
        cost=cost,
        lower_bound=_finite(lower_bound),
        regrasps=None if cost is None else sum(step.kind == "regrasp" for step in steps),
        scenario=dict(scenario),
        statistics=Statistics(**plain, history=history),
        steps=steps,
        hand=None if paths is None else hand_record(paths),
    )


def _finite(number: float | None) -> float | None:
    return float(number) if number is not None and math.isfinite(number) else None


def _step(problem: Problem, move: Move) -> DisplacementStep | RegraspStep:
    """Return the step that a move makes."""
    placements = [placement_record(problem, row) for row in move.placements]
    limits = problem.fingers.max_normal_force

    def control(decision: ModeDecision, lifted: int | None = None) -> dict[str, Any]:
        """Return modes, f_com and margins, with no mode and no force for a lifted finger."""
        modes: list[Mode | None] = [mode.value for mode in decision.modes]
        forces = list(decision.f_com)
        if lifted is not None:
            modes.insert(lifted, None)
            forces.insert(lifted, None)
        f_com = [_within(f, limit) for f, limit in zip(forces, limits, strict=True)]
        if decision.nominal is None:
            return {"modes": modes, "f_com": f_com, "z": decision.z}
        margins = {"z": decision.nominal, "z_strong": decision.z}
        return {"modes": modes, "f_com": f_com, **margins}

    if isinstance(move, Displacement):
        return _made(
            DisplacementStep, kind="displacement", from_=move.start, to=move.end,
            arc=arc_record(move.arc), pose_from=pose_record(move.arc.start),
            pose_to=pose_record(move.arc.end), placements=placements,
            segments=[control(decision) for decision in move.segments], cost=move.cost,
        )  # fmt: skip
    return _made(
        RegraspStep, kind="regrasp", at=move.at, finger=move.finger,
        from_=placements[move.finger], to=placement_record(problem, move.target),
        way=None if move.way is None else move.way.tolist(),
        placements=placements, **control(move.rest, move.finger), cost=move.cost,
    )  # fmt: skip


def hand_record(paths: JointPaths) -> HandRecord:
    """Return joint paths as the file states them."""
    return _made(
        HandRecord, joints=paths.joints, approach=paths.approach.tolist(),
        steps=[rows.tolist() for rows in paths.moves], retreat=paths.retreat.tolist(),
    )  # fmt: skip


def _made(part: type[Part], **values: Any) -> Part:
    """Return a part of a plan; lists and numpy's numbers become tuples and plain numbers."""
    return part.model_validate(values, strict=False)


def _within(force: float | None, limit: float) -> float | None:
    """Return ``force`` with the solver's rounding at its bounds taken away."""
    if force is None or not -ROUNDING * limit <= force <= (1.0 + ROUNDING) * limit:
        return force
    return min(max(float(force), 0.0), float(limit))


def pose_record(pose: Pose) -> PoseRecord:
    """Return a pose as the file states it."""
    position, quaternion = pose.position.tolist(), pose.quaternion().tolist()
    return _made(PoseRecord, position=position, quaternion=quaternion)


def placement_record(problem: Problem, row: int) -> PlacementRecord:
    """Return row ``row`` of the placement table, object frame."""
    table = problem.fingers.placements
    return _made(
        PlacementRecord,
        face=table.labels[int(table.face[row])],
        cell=table.cell[row].tolist() if (table.cell[row] >= 0).all() else None,
        point=table.points[row].tolist(),
        normal=table.normals[row].tolist(),
    )
