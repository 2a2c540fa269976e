"""From a plan to its timeline: approach, runs, switches, regrasps."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Moment
from gm_ompl.planfile.arcs import pose_before
from gm_ompl.planfile.model import Plan, RegraspStep
from gm_ompl.problem import Problem
from gm_ompl.simulation.balance import Balance, balance
from gm_ompl.simulation.hand_ways import AirWay, HandWays
from gm_ompl.simulation.segments import Run, commanded, runs
from gm_ompl.simulation.timeline import PHASES, Pace, Timeline, between, joined, progress, ramp
from gm_ompl.simulation.transit import TOUCHING, Transit
from gm_ompl.simulation.world import force_unit

TOUCH = 0.02
"""Force with which a finger feels for the surface, of the unit of force (the object's weight)."""


def schedule(plan: Plan, problem: Problem, pace: Pace, dt: float, *, lean: bool = True) -> Timeline:
    """Lay time over ``plan``.

    The object moves at an even pace and stops only to switch modes, to regrasp and to change
    direction; commanded forces run straight from one segment's midpoint to the next. Before and
    after, and in every switch, it rests.

    Args:
        plan: what to do; trusted in everything.
        problem: the plan's scenario.
        pace: how fast.
        dt: time step [s].
        lean: whether fingers lean on the object with the forces of a balance (``balance``);
            otherwise they go by positions and commanded normal forces alone.

    Raises:
        InputError: the plan moves nothing, or does not fit the scenario.
    """
    return _Scheduler(plan, problem, pace, dt, lean).run()


class _Scheduler:
    """Lays down one phase after the other; ``now`` holds what a timeline says at rest."""

    def __init__(self, plan: Plan, problem: Problem, pace: Pace, dt: float, lean: bool) -> None:
        self.problem, self.pace, self.dt, self.lean = problem, pace, dt, lean
        self.parts = runs(plan, problem)
        self.size, self.touch = problem.body.diagonal, TOUCH * force_unit(problem)
        self.timelines: list[Timeline] = []
        self.notes: list[str] = []
        first, n = plan.steps[0], problem.fingers.count
        hand = None if plan.hand is None else HandWays(plan.hand, problem, dt)
        z = first.z if isinstance(first, RegraspStep) else first.segments[0].z
        self.pose = pose_before(plan, 0, problem)
        self.points = np.array([place.point for place in first.placements])
        self.normals = np.array([place.normal for place in first.placements])
        self.now = SimpleNamespace(
            force_share=np.zeros(n),
            f_com=np.zeros(n),
            lean=np.zeros((n, 3)),
            least=np.full(n, np.nan),
            most=np.full(n, np.nan),
            limit=np.full(n, self.touch),
            press=np.zeros(n),
            down=np.zeros(n, dtype=bool),
            landing=np.zeros(n, dtype=bool),
            step=-1,
            segment=-1,
            z=z,
            joints=np.full(0 if hand is None else len(hand.spec.joints), np.nan),
        )
        self.hand = hand

    def run(self) -> Timeline:
        everyone = np.ones(self.problem.fingers.count, dtype=bool)
        if self.hand is None:
            offs = self._offs(everyone)
            self._rest("settle", self.pace.settle, off=offs)
        else:
            offs = self._from_home(self.hand)
        self._land("approach", everyone, offs)
        for part in self.parts:
            if isinstance(part, list):
                self._run(part)
            else:
                self._regrasp(*part)
        self._rest("settle", self.pace.settle)
        if self.hand is None:
            return joined(self.timelines)
        self._go_home(self.hand)
        return self.hand.followed(joined(self.timelines))

    def _from_home(self, hand: HandWays) -> Array:
        """Bring the hand from home; return how the fingers stand off then, as ``_offs`` does."""
        way = hand.approach()
        at_home = np.tile(way.joints[0], (self._samples(self.pace.settle), 1))
        self._fly("settle", AirWay(at_home, np.tile(way.tips[0], (len(at_home), 1, 1))))
        self._fly("transit", way)
        return self._lowered("approach", self._standing(way.tips[-1]))

    def _lowered(self, phase: str, offs: Array) -> Array:
        """Bring fingers from ``offs`` (n, 3) nearer, from where they come down slowly."""
        far = np.linalg.norm(offs, axis=1, keepdims=True)
        near = np.minimum(1.0, self.pace.clearance * self.size / np.maximum(far, 1e-12)) * offs
        falling = 1.0 - ramp(self._samples(self.pace.lift))
        self._rest(phase, self.pace.lift, near + falling[:, None, None] * (offs - near))
        return near

    def _go_home(self, hand: HandWays) -> None:
        """Lift all fingers and bring the hand home."""
        way, now = hand.retreat(), self.now
        self._switch(now.force_share > 0, np.minimum(self.touch, now.f_com), np.zeros_like(now.lean))
        now.down, now.force_share = np.zeros_like(now.down), np.zeros_like(now.force_share)
        rising = ramp(self._samples(self.pace.lift))
        self._rest("lift", self.pace.lift, np.multiply.outer(rising, self._standing(way.tips[0])))
        self._fly("transit", way)

    def _standing(self, tips: Array) -> Array:
        """Return (n, 3), how fingertips' centres (n, 3), world frame, stand off, object frame."""
        touching = self.points - self.problem.fingers.radius[:, None] * self.normals
        off: Array = self.pose.to_object(tips) - touching
        return off

    def _fly(self, phase: str, way: AirWay) -> None:
        self._add(phase, [self.pose] * len(way.joints), way.tips, joints=way.joints)

    def _samples(self, seconds: float) -> int:
        return max(2, round(seconds / self.dt))

    def _run(self, run: Run) -> None:
        """Move the object along the segments of ``run``."""
        now, pace, corners = self.now, self.pace, self.problem.body.vertices
        force, forces = commanded(run[0].record)[0], np.array([commanded(s.record)[1] for s in run])
        balances = self._balances(run, force, forces)
        leans = np.array([found.forces for found in balances]) * self.lean
        now.step, now.z = run[0].step, run[0].record.z
        self._switch(force, forces[0], leans[0])
        ways = [s.part.end.apply(corners) - s.part.start.apply(corners) for s in run]
        lengths = np.linalg.norm(ways, axis=2).max(axis=1)
        ends = np.cumsum(lengths)
        along = progress(float(ends[-1]), pace.speed * self.size, pace.ramp, self.dt)
        middles = ends - lengths / 2.0
        which = np.minimum(np.searchsorted(ends, along), len(ends) - 1)
        left = (ends[which] - along) / np.maximum(lengths[which], np.finfo(float).tiny)
        shares = zip(which, np.clip(1.0 - left, 0.0, 1.0).tolist(), strict=True)
        way = [run[k].part.pose(share) for k, share in shares]
        per_segment: dict[str, Any] = {
            "step": [segment.step for segment in run],
            "segment": [segment.number for segment in run],
            "z": [segment.record.z for segment in run],
            "least": [found.least for found in balances],
            "most": [found.most for found in balances],
        }
        f_com, lean = between(along, middles, forces), between(along, middles, leans)
        spread: dict[str, Any] = {
            name: np.array(values)[which] for name, values in per_segment.items()
        }
        self._add("move", way, f_com=f_com, lean=lean, **spread)
        self.pose, now.f_com, now.lean = way[-1], f_com[-1], leans[-1]
        now.step, now.z = run[-1].step, run[-1].record.z

    def _balances(self, run: Run, force: BoolArray, forces: Array) -> list[Balance]:
        """Return forces that hold the object, per segment."""
        found = [
            balance(self.problem, segment.part.middle, segment.placements, force, f_com)
            for segment, f_com in zip(run, forces, strict=True)
        ]
        failed = [s for s, b in zip(run, found, strict=True) if not b.holds]
        if failed:
            self.notes.append(
                f"no forces balance in {len(failed)} segments, the first in step "
                f"{failed[0].step}, segment {failed[0].number}"
            )
        return found

    def _switch(self, force: BoolArray, f_com: Array, lean: Array) -> None:
        """Change modes and commanded forces while the object rests, as a junction is judged.

        A finger under force control only before or only after keeps that command throughout; one
        that has just come down ramps from the force of its touch.
        """
        now, rising = self.now, ramp(self._samples(self.pace.switch))
        first = np.where(now.limit > self.touch, f_com, np.minimum(self.touch, f_com))
        now.f_com = np.where(now.force_share > 0, now.f_com, first)
        after = {
            "force_share": force.astype(float),
            "f_com": np.where(force, f_com, now.f_com),
            "lean": lean,
            "limit": np.where(now.down, self.problem.fingers.max_normal_force, now.limit),
        }
        changes = {}
        for name, value in after.items():
            before = getattr(now, name)
            changes[name] = before + np.multiply.outer(rising, value - before)
        self._rest("switch", self.pace.switch, **changes)
        vars(now).update(after)

    def _regrasp(self, number: int, step: RegraspStep) -> None:
        i, now, pace = step.finger, self.now, self.pace
        now.step, now.z = number, step.z
        force, f_com = commanded(step)
        rest = balance(self.problem, Moment(self.pose), step.placements, force, f_com, lifted=i)
        if not rest.holds:
            self.notes.append(f"no forces balance in step {number}, finger {i} lifted")
        force[i] = now.force_share[i] > 0  # the leaving finger unloads in the mode that it has
        f_com[i] = min(self.touch, now.f_com[i])
        self._switch(force, f_com, rest.forces * self.lean)
        now.force_share[i] = 0.0
        chosen = np.arange(len(force)) == i
        now.down = now.down & ~chosen
        rising = ramp(self._samples(pace.lift))
        air = None if self.hand is None else self.hand.regrasp(number)
        way = self._way(step) if air is None else self._ends(step, air)
        stands = self.pose.to_object(way)
        off, on = np.where(chosen[:, None], stands[[[1], [-2]]] - stands[[[0], [-1]]], 0.0)
        self._rest("lift", pace.lift, off=np.multiply.outer(rising, off))
        now.limit[i], now.f_com[i] = self.touch, 0.0
        self.points[i], self.normals[i] = np.array(step.to.point), np.array(step.to.normal)
        if air is None:
            self._bring(i, way[1:-1])
        else:
            self._add("transit", [self.pose] * len(air.joints), self._only(i, air.tips[:, i]))
            on = self._lowered("land", on)
        self._land("land", chosen, on)

    def _ends(self, step: RegraspStep, air: AirWay) -> Array:
        """Return where a finger touches, stands off, does so elsewhere and touches, (4, 3)."""
        i, radius = step.finger, self.problem.fingers.radius[step.finger]
        touching = [np.array(p.point) - radius * np.array(p.normal) for p in (step.from_, step.to)]
        first, last = self.pose.apply(np.array(touching))
        return np.array([first, air.tips[0, i], air.tips[-1, i], last])

    def _only(self, i: int, way: Array) -> Array:
        """Return centres (K, n, 3) of which one finger's goes its ``way`` (K, 3), others stay."""
        touching = self.points - self.problem.fingers.radius[:, None] * self.normals
        centres = np.tile(self.pose.apply(touching), (len(way), 1, 1))
        centres[:, i] = way
        return centres

    def _way(self, step: RegraspStep) -> Array:
        """Return a regrasp's way, world frame: as it is planned, or one that is found here."""
        if step.way is not None:
            return np.array(step.way)
        i, to = step.finger, step.to
        whole, clear = self._transit().way(i, np.array(to.point), np.array(to.normal))
        if not clear:
            number = self.now.step
            self.notes.append(f"step {number}: finger {i} finds no clear way to its new place")
        return whole

    def _bring(self, i: int, corners: Array) -> None:
        """Bring the lifted finger ``i`` along a way to where it stands off its new placement."""
        speed = self.pace.transit * self.size
        lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        legs = [
            a + np.outer(progress(length, speed, self.pace.ramp / 2.0, self.dt) / length, b - a)
            for a, b, length in zip(corners, corners[1:], lengths, strict=False)
            if length > 0
        ]
        path = np.concatenate(legs) if legs else corners[:1]
        self._add("transit", [self.pose] * len(path), self._only(i, path))

    def _transit(self) -> Transit:
        height = self.pace.clearance * self.size
        return Transit(self.problem, self.pose, self.points, self.normals, height)

    def _offs(self, which: BoolArray) -> Array:
        """Return (n, 3), how the fingers ``which`` stand off, object frame; 0 for the others."""
        transit, offs = self._transit(), np.zeros_like(self.points)
        for i in np.flatnonzero(which).tolist():
            offs[i] = transit.off(i, self.points[i], self.normals[i])
        return offs

    def _land(self, phase: str, which: BoolArray, offs: Array) -> None:
        """Bring fingers down to their placements, and a little beyond until they feel it.

        They come from ``offs`` (n, 3) off them, object frame.
        """
        lift = self.pace.lift
        falling = ramp(self._samples(lift))[:, None]
        beside = np.abs((offs * self.normals).sum(axis=1)) <= TOUCHING * self.size
        if (offs[beside] != 0.0).any():
            # A finger that felt for the surface before it is there would land on an edge.
            share = np.where(beside[:, None], 1.0 - falling[:, :, None], 1.0)
            self._rest(phase, lift, share * offs)
            offs = np.where(beside[:, None], 0.0, offs)
        press = falling * (self.pace.reach * self.size * which)
        looking = np.tile(which, (len(falling), 1))
        self._rest(phase, lift, (1.0 - falling[:, :, None]) * offs, press=press, landing=looking)
        self.now.down = self.now.down | which

    def _rest(
        self, phase: str, seconds: float, off: Array | float = 0.0, **arrays: Array | BoolArray
    ) -> None:
        self._add(phase, [self.pose] * self._samples(seconds), None, off, **arrays)

    def _add(
        self,
        phase: str,
        way: Sequence[Pose],
        centres: Array | None = None,
        off: Array | float = 0.0,
        **arrays: Array | BoolArray,
    ) -> None:
        """Append instants at the K poses ``way``; what is not given stays as it is.

        Fingertips are ``off`` (K, n, 3) where they touch, object frame, or at ``centres``
        (K, n, 3), world frame.
        """
        K = len(way)
        position = np.array([pose.position for pose in way])
        rotation = np.array([pose.rotation for pose in way])
        local = self.points - self.problem.fingers.radius[:, None] * self.normals
        local = local + np.broadcast_to(off, (K, *local.shape))
        centre = np.einsum("tij,tnj->tni", rotation, local) + position[:, None]
        if centres is not None:
            centre = centres
        fields: dict[str, Any] = {}
        for name, value in {**vars(self.now), "phase": PHASES.index(phase)}.items():
            still = np.asarray(value)
            given = np.broadcast_to(arrays.pop(name, still), (K, *still.shape))
            fields[name] = given.astype(still.dtype)
        assert not arrays
        fields["lean"] = np.einsum("tij,tnj->tni", rotation, fields["lean"])
        normal = np.einsum("tij,nj->tni", rotation, self.normals)
        where = {"position": position, "rotation": rotation, "centre": centre, "normal": normal}
        self.timelines.append(Timeline(dt=self.dt, notes=tuple(self.notes), **where, **fields))
        self.notes.clear()
