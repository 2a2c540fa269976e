"""Judges whether a hand's motors can hold the object: some balance within their torques."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.checking.report import Findings
from gm_ompl.checking.second_hand import SecondHand
from gm_ompl.contact.environment import contacts_at
from gm_ompl.errors import SolverError
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.planfile.model import DisplacementStep, PlacementRecord, RegraspStep, SegmentRecord
from gm_ompl.problem import Problem
from gm_ompl.reference.statics import statics
from gm_ompl.reference.torques import Motors, least_share, turned

MORE = 1e-6
"""By how much a motor's torque may be passed, relative: the solver's rounding."""


class MotorCheck:
    """Asks every segment and every rest of a plan.

    Args:
        problem: with a hand.
        second: the hand.
    """

    def __init__(self, problem: Problem, second: SecondHand) -> None:
        self._problem, self._second = problem, second

    def displacement(self, step: DisplacementStep, arc: Arc, rows: Array, found: Findings) -> None:
        """Judge the middles of a step's segments, along its joint rows (m, k)."""
        cuts, fingers = arc.bounds(len(step.segments)), range(len(step.placements))
        for k, segment in enumerate(step.segments):
            t = (cuts[k] + cuts[k + 1]) / 2.0
            at = t * (len(rows) - 1)
            first = min(int(at), len(rows) - 2)
            self._second.place(rows[first] + (at - first) * (rows[first + 1] - rows[first]))
            self._hold(arc.moment(t), step.placements, fingers, segment, found)

    def regrasp(self, step: RegraspStep, pose: Pose, rows: Array, found: Findings) -> None:
        """Judge the rest, before and after one finger goes along joint rows (m, k)."""
        staying = [i for i in range(len(step.placements)) if i != step.finger]
        for q in rows[[0, -1]]:
            self._second.place(q)
            self._hold(Moment(pose), step.placements, staying, step, found)

    def _hold(
        self,
        moment: Moment,
        placements: Sequence[PlacementRecord],
        fingers: Sequence[int],
        record: SegmentRecord | RegraspStep,
        found: Findings,
    ) -> None:
        problem, pose, down = self._problem, moment.pose, list(fingers)
        if len(record.modes) != problem.fingers.count or not down:
            return  # judged elsewhere
        contacts = contacts_at(moment, problem.body, problem.environment)
        points = np.array([place.point for place in placements])
        instant = replace(
            problem.instant(contacts, tuple(down), (0,) * len(down)),
            points=points[down],
            normals=np.array([placements[i].normal for i in down]),
        )
        levers = turned(self._second.levers(pose.apply(points))[down], pose.rotation)
        weight = self._second.weight(problem.mechanics.gravity)
        motors = Motors(levers, weight, self._second.spec.torque)
        force = np.array([record.modes[i] == "force" for i in down], dtype=bool)
        f_com = np.array([record.f_com[i] or 0.0 for i in down])
        try:
            share = least_share(statics(instant), force, f_com, motors)
        except SolverError as error:
            found.check("torques", False, f"whether motors can hold cannot be decided: {error}")
            return
        if share is not None:  # whether anything balances is judged elsewhere
            name = self._second.spec.joints[share[1]]
            text = f"{name} must give {share[0]:.3g} of its torque, whatever the balance"
            found.check("torques", share[0] <= 1.0 + MORE, text)
