"""Where a finger may go: the best margin of its every placement, or what blocks it there."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.contact.decision import Outcome
from gm_ompl.errors import ScenarioError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.partners import Partners, best_partners
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Problem


@dataclass(frozen=True, eq=False)
class PlacementMap:
    """For every finger and placement the best there is, over all placements of the others.

    Attributes:
        problem: what is mapped.
        moment: when: the object's pose, and its twist (None at rest).
        z: (n, P), the largest margin of a set of placements with this finger there, in the
            scenario's units of force; -inf where no set is in equilibrium, or none is possible.
        findings: (n, P), indices into ``FINDINGS``: that z reaches z_min, or what blocks.
        sets: (n, P, n), a set that has the margin; -1 for none.
    """

    problem: Problem
    moment: Moment
    z: Array
    findings: IntArray
    sets: IntArray

    def finding(self, finger: int, placement: int) -> Finding:
        """Return what was found for a finger at a placement."""
        return FINDINGS[self.findings[finger, placement]]

    def kinds(self) -> tuple[tuple[int, ...], ...]:
        """Return the fingers in groups that share one map."""
        groups: dict[bytes, list[int]] = {}
        for i in range(len(self.z)):
            key = self.z[i].tobytes() + self.findings[i].tobytes()
            groups.setdefault(key, []).append(i)
        return tuple(tuple(group) for group in groups.values())

    def counts(self, finger: int) -> dict[Finding, int]:
        """Return how many placements have each finding, in the order of ``FINDINGS``."""
        found = Counter(self.findings[finger].tolist())
        return {FINDINGS[k]: found[k] for k in sorted(found)}

    def to_dict(self) -> dict[str, Any]:
        """Return plain values: per kind of finger and placement one row."""
        table = self.problem.fingers.placements
        pose = self.moment.pose
        return {
            "scenario": self.problem.name,
            "z_min": self.problem.mechanics.z_min,
            "pose": {
                "position": pose.position.tolist(),
                "rotation": pose.quaternion().tolist(),
            },
            "at_rest": self.moment.twist is None,
            "fingers": [
                {
                    "fingers": list(group),
                    "placements": [
                        {
                            "face": table.labels[table.face[row]],
                            "cell": table.cell[row].tolist(),
                            "point": table.points[row].tolist(),
                            "normal": table.normals[row].tolist(),
                            "z": float(z) if np.isfinite(z) else None,
                            "finding": self.finding(group[0], row).name.lower(),
                            "partners": self._partners(group[0], row),
                        }
                        for row, z in enumerate(self.z[group[0]])
                    ],
                }
                for group in self.kinds()
            ],
        }

    def _partners(self, finger: int, row: int) -> list[dict[str, Any]] | None:
        """Return per finger where it is in the best set; None without one."""
        table, rows = self.problem.fingers.placements, self.sets[finger, row]
        if rows[finger] < 0:
            return None
        return [{"face": table.labels[table.face[r]], "cell": table.cell[r].tolist()} for r in rows]


FINDINGS = (
    Finding.HOLDS, Finding.UNSTABLE, Finding.NO_EQUILIBRIUM, Finding.INTERNAL_FORCE,
    Finding.POCKET, Finding.GEOMETRY, Finding.UNDECIDED,
)  # fmt: skip


def placement_map(judge: Judge, moment: Moment) -> PlacementMap:
    """Map all placements at an instant.

    Args:
        judge: of the problem.
        moment: the instant.

    Raises:
        ScenarioError: the hand has no finger.
        LimitError: a limit in force is reached.
    """
    problem, state = judge.problem, judge.environment(moment)
    if problem.fingers.count == 0:
        raise ScenarioError(f"{problem.name}: fingers.count is 0: a map needs a finger at least")
    free: BoolArray = np.array(judge.node(moment.pose).free).reshape(
        problem.fingers.count, len(problem.fingers.placements)
    )
    allowed = free & _reached(judge, moment, free)
    found = best_partners(judge, state, allowed)
    findings = np.full(free.shape, FINDINGS.index(Finding.GEOMETRY))
    findings[free & ~allowed] = FINDINGS.index(Finding.POCKET)
    findings[allowed] = FINDINGS.index(_refusal(judge, state, allowed, found))
    findings[allowed & ~_beside(judge, allowed)] = FINDINGS.index(Finding.GEOMETRY)
    findings[found.z >= 0.0] = FINDINGS.index(Finding.UNSTABLE)
    z_min = problem.mechanics.z_min
    findings[found.z >= z_min] = FINDINGS.index(Finding.HOLDS)
    return PlacementMap(problem, moment, found.z, findings, found.sets)


def _reached(judge: Judge, moment: Moment, free: BoolArray) -> BoolArray:
    """Return (n, P), where fingertips are in no pocket; other fingertips are left aside."""
    reached = free.copy()
    if judge.reach.active:
        for i, mask in enumerate(free):
            at_once = judge.reach.at_once(moment.pose, i, ())
            for row in np.flatnonzero(mask & ~at_once):
                reached[i, row] = judge.reach.outside(moment.pose, i, (), int(row))
    return reached


def _beside(judge: Judge, allowed: BoolArray) -> BoolArray:
    """Return (n, P), where every other fingertip has some placement beside this one."""
    fits, least = allowed.copy(), judge.least_distances()
    from scipy.spatial import cKDTree  # loads long, and only maps ask

    for j in range(len(allowed)):
        there = judge.centres(j)[allowed[j]]
        for i in range(len(allowed)):
            if i != j:
                tree, rows = cKDTree(there), np.flatnonzero(fits[i])
                close = tree.query_ball_point(
                    judge.centres(i)[rows], np.nextafter(least[i, j], 0.0), return_length=True
                )
                fits[i, rows] = close < len(there)
    return fits


def _refusal(judge: Judge, state: int, allowed: BoolArray, found: Partners) -> Finding:
    """Return what blocks a placement with which no set is in equilibrium.

    Whether no choice of modes passes Problem (5) does not depend on the placements: with all
    fingers force-controlled only the environment's columns are left.
    """
    if found.undecided:
        return Finding.UNDECIDED
    some = [np.flatnonzero(mask) for mask in allowed]
    if not all(len(rows) for rows in some):
        return Finding.GEOMETRY
    rows = tuple(int(each[0]) for each in some)
    decision = judge.backend.decide(state, tuple(range(len(rows))), rows)
    refused = decision.outcome is Outcome.INTERNAL_FORCE
    return Finding.INTERNAL_FORCE if refused else Finding.NO_EQUILIBRIUM
