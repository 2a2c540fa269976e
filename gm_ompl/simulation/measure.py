"""From a recording to a report: errors, slip, forces, and whether the plan held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.simulation.engine import STEP
from gm_ompl.simulation.play import EVERY, Player, Recording
from gm_ompl.simulation.timeline import PHASES
from gm_ompl.simulation.world import force_unit

MOVE = PHASES.index("move")

FAINT = 0.001  # a normal force below this, of the object's weight, is no contact

LOOSE = 0.05
"""Play around the statical range of a normal force, of the object's weight: the range is that of
pyramids inside the friction cones."""


@dataclass(frozen=True)
class Allowed:
    """What still counts as holding; lengths in diagonals D of the object."""

    # error of the centre of mass at the end; 2 mm for the cork box
    end_position: float = 2.0 / 131.15
    end_angle: float = 1.0  # error of the orientation at the end [deg]
    position: float = 0.03  # error of the centre of mass on the way
    angle: float = 3.0  # error of the orientation on the way [deg]
    slip: float = 0.005  # way of a fingertip over the object, between touch-down and lifting
    static_slip: float = 0.01  # way of a static contact over floor or obstacle
    force: float = 0.1  # relative error of a commanded normal force, averaged over ``window``
    window: float = 0.05  # over which forces are averaged [s]


@dataclass(frozen=True)
class FingerReport:
    """What one finger did; forces and lengths in the scenario's units."""

    finger: int  # its number
    slip: float  # largest way over the object between touch-down and lifting
    force_controlled: float  # share of the motion under force control
    # largest relative error of the commanded normal force, averaged over 50 ms; None if it was
    # never force-controlled
    force_error: float | None
    mean_force_error: float | None  # mean of that error
    # share of the motion under position control, averaged over 50 ms, in which the normal force
    # lies between the least and the greatest that statics allows, up to 5% of the object's
    # weight; None if it was never position-controlled
    in_range: float | None
    greatest_force: float  # greatest normal force, averaged over 50 ms
    max_normal_force: float  # f_max
    off_contact: float  # time during which it should have touched and did not [s]


class Measurement:
    """A recording beside its timeline, in the scenario's units; K rows.

    Forces are averaged over ``window`` [s].
    """

    def __init__(
        self, plan: Plan, problem: Problem, player: Player, recording: Recording, window: float
    ) -> None:
        self.plan, self.problem = plan, problem
        self.timeline, self.units = player.timeline, player.units
        self.rows = recording.rows
        self.position = recording.position / self.units.length
        self.rotation = rotations(recording.quaternion)
        self.centre = recording.centre / self.units.length
        self.normal_force = recording.normal_force / self.units.force
        robot = player.robot
        self.torque: dict[str, float] = {}
        self.touching: tuple[tuple[str, str], ...] = ()
        if robot is not None and problem.hand is not None:
            self.torque = dict(zip(problem.hand.joints, robot.used.tolist(), strict=True))
            self.touching = tuple(sorted(robot.touched))
        self.moving = self.timeline.phase[self.rows] == MOVE
        self.weight = force_unit(problem)
        self._window = max(1, round(window / (EVERY * STEP)))

    def position_error(self) -> Array:
        """Return (K,), distance of the centre of mass from the plan's."""
        off: Array = np.linalg.norm(self.position - self.timeline.position[self.rows], axis=1)
        return off

    def angle_error(self) -> Array:
        """Return (K,), angle between the orientation and the plan's [deg]."""
        gap = np.linalg.norm(self.rotation - self.timeline.rotation[self.rows], axis=(1, 2))
        # |A - B|_F = sqrt(8) sin(angle / 2); the cosine from the trace is blind near zero.
        angle: Array = np.degrees(2.0 * np.arcsin(np.minimum(gap / np.sqrt(8.0), 1.0)))
        return angle

    def slip(self) -> Array:
        """Return (K, n), how far the fingertips' points have gone over the object's surface.

        Followed is the point of the fingertip that touched first, in the object frame, along the
        surface, since the finger came down, beside what a robot's fingertip is to roll; 0 while it
        is up.
        """
        timeline, rows = self.timeline, self.rows
        arms = self.problem.fingers.radius[:, None] * timeline.normal[rows]
        touch = self.centre + arms - self.position[:, None]
        local = np.einsum("kji,knj->kni", self.rotation, touch)
        planned = timeline.centre[rows] + arms - timeline.position[rows][:, None]
        local -= np.einsum("kji,knj->kni", timeline.rotation[rows], planned)
        inward = np.einsum("tji,tnj->tni", timeline.rotation[rows], timeline.normal[rows])
        down, slip = timeline.down[rows], np.zeros(local.shape[:2])
        for i in range(local.shape[1]):
            for first, last in _stretches(down[:, i]):
                way = local[first:last, i] - local[first, i]
                n = inward[first, i]
                slip[first:last, i] = np.linalg.norm(way - np.outer(way @ n, n), axis=1)
        return slip

    def moved(self, rows: IntArray, points: Array, normals: Array) -> tuple[Array, Array]:
        """Return how far contacts are from where the plan has them.

        Args:
            rows: (K',), of the recording.
            points: (m, 3), object frame.
            normals: (m, 3), out of floor or obstacle, object frame.

        Returns:
            (K', m) along the faces, and (K', m) along the normals.
        """
        line, instants = self.timeline, self.rows[rows]
        there = np.einsum("kij,mj->kmi", self.rotation[rows], points)
        there = there + self.position[rows][:, None]
        wanted = np.einsum("kij,mj->kmi", line.rotation[instants], points)
        wanted = wanted + line.position[instants][:, None]
        n = np.einsum("kij,mj->kmi", line.rotation[instants], normals)
        way = there - wanted
        lifted = (way * n).sum(axis=2)
        return np.linalg.norm(way - lifted[:, :, None] * n, axis=2), lifted

    def finger(self, i: int, slip: Array) -> FingerReport:
        """Return what finger ``i`` did; ``slip`` as from ``slip()``."""
        line, rows, force = self.timeline, self.rows, self.normal_force[:, i]
        share, f_com = line.force_share[rows, i], line.f_com[rows, i]
        forced, held = self.moving & (share >= 1.0), self.moving & (share <= 0.0)
        got, asked = self._means(force, forced), self._means(f_com, forced)
        errors = np.abs(got - asked) / np.maximum(asked, LOOSE * self.weight)
        greatest = self._means(force, self.moving)
        moving = max(int(self.moving.sum()), 1)
        wanted = self.moving & line.down[rows, i]
        off = wanted & (force < FAINT * self.weight)
        return FingerReport(
            finger=i,
            slip=float(slip[:, i].max(initial=0.0)),
            force_controlled=float(forced.sum() / moving),
            force_error=float(errors.max()) if len(errors) else None,
            mean_force_error=float(errors.mean()) if len(errors) else None,
            in_range=self._in_range(i, held),
            greatest_force=float(greatest.max(initial=0.0)),
            max_normal_force=float(self.problem.fingers.max_normal_force[i]),
            off_contact=float(off.sum() * EVERY * STEP),
        )

    def averaged(self, i: int) -> Array:
        """Return (K,), the normal force of finger ``i``, averaged around each row."""
        even = np.ones(self._window)
        known = np.convolve(np.ones(len(self.rows)), even, "same")
        mean: Array = np.convolve(self.normal_force[:, i], even, "same") / known
        return mean

    def _in_range(self, i: int, held: BoolArray) -> float | None:
        held = held & np.isfinite(self.timeline.least[self.rows, i])
        got = self._means(self.normal_force[:, i], held)
        if not len(got):
            return None
        least = self._means(self.timeline.least[self.rows, i], held) - LOOSE * self.weight
        most = self._means(self.timeline.most[self.rows, i], held) + LOOSE * self.weight
        return float(((got >= least) & (got <= most)).mean())

    def _means(self, values: Array, where: BoolArray) -> Array:
        """Return the moving averages that lie within the stretches of ``where``."""
        w, parts = self._window, []
        for first, last in _stretches(where):
            if last - first >= w:
                sums = np.cumsum(np.concatenate([[0.0], values[first:last]]))
                parts.append((sums[w:] - sums[:-w]) / w)
        return np.concatenate(parts) if parts else np.zeros(0)

    def inertia(self) -> tuple[float, float]:
        """Return the largest inertia force in the norm (7), and its largest ratio to z."""
        L, line = self.units.length, self.timeline
        mass = self.problem.mass * self.units.mass
        J = self.problem.inertia * self.units.mass * L**2
        wrench = line.inertia_wrench(mass, J, L)
        scaled = mass * np.einsum("ti,ij,tj->t", wrench[:, 3:], np.linalg.inv(J), wrench[:, 3:])
        norm = np.sqrt((wrench[:, :3] ** 2).sum(axis=1) + scaled) / self.units.force
        moving = line.phase == MOVE
        ratio = norm[moving] / np.maximum(line.z[moving], 1e-9 * self.weight)
        return float(norm[moving].max(initial=0.0)), float(ratio.max(initial=0.0))


def rotations(quaternions: Array) -> Array:
    """Return the rotations (K, 3, 3) of unit quaternions (K, 4), w x y z."""
    return np.asarray(Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_matrix())


def _stretches(where: BoolArray) -> list[tuple[int, int]]:
    """Return (first, last + 1) of every run of True."""
    edges = np.diff(np.concatenate([[0], where.astype(int), [0]]))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return list(zip(starts.tolist(), ends.tolist(), strict=True))
