"""From a plan to its timeline: approach, runs, switches, regrasps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Moment
from gm_ompl.planfile.model import Plan, RegraspStep
from gm_ompl.problem import Problem
from gm_ompl.simulation.balance import Balance, balance
from gm_ompl.simulation.segments import Run, commanded, runs
from gm_ompl.simulation.timeline import (
    PHASES,
    Pace,
    Timeline,
    between,
    joined,
    progress,
    ramp,
)
from gm_ompl.simulation.transit import TOUCHING, Transit

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


@dataclass
class _Hand:
    """What the fingers are doing; arrays (n, ...), object frame."""

    points: Array
    normals: Array
    share: Array
    f_com: Array
    limit: Array
    lean: Array
    down: BoolArray


class _Scheduler:
    def __init__(self, plan: Plan, problem: Problem, pace: Pace, dt: float, lean: bool) -> None:
        self.problem, self.pace, self.dt, self.lean = problem, pace, dt, lean
        self.parts = runs(plan, problem.body.vertices)
        self.size = problem.body.diagonal
        weight = problem.mass * problem.mechanics.gravity
        self.touch = TOUCH * (weight or float(problem.fingers.max_normal_force.max()))
        self.timelines: list[Timeline] = []
        self.notes: list[str] = []
        first = plan.steps[0]
        n = problem.fingers.count
        self.pose = problem.motion.pose(first.at if first.kind == "regrasp" else first.from_)
        self.z = first.z if first.kind == "regrasp" else first.segments[0].z
        self.step = -1
        self.hand = _Hand(
            np.array([place.point for place in first.placements]),
            np.array([place.normal for place in first.placements]),
            np.zeros(n),
            np.zeros(n),
            np.full(n, self.touch),
            np.zeros((n, 3)),
            np.zeros(n, dtype=bool),
        )

    def run(self) -> Timeline:
        everyone = np.ones(self.problem.fingers.count, dtype=bool)
        self._rest("settle", self.pace.settle, off=self._offs(everyone))
        self._land("approach", everyone)
        for part in self.parts:
            if isinstance(part, list):
                self._run(part)
            else:
                self._regrasp(*part)
        self._rest("settle", self.pace.settle)
        return joined(self.timelines)

    def _samples(self, seconds: float) -> int:
        return max(2, round(seconds / self.dt))

    def _run(self, run: Run) -> None:
        rows: dict[str, Any] = {
            "step": np.array([segment.step for segment in run]),
            "segment": np.array([segment.number for segment in run]),
            "z": np.array([segment.record.z for segment in run]),
        }
        self.z, self.step = rows["z"][0], rows["step"][0]
        force, forces = commanded(run[0].record)[0], np.array([commanded(s.record)[1] for s in run])
        balances = self._balances(run, force, forces)
        leans = np.array([found.forces for found in balances]) * self.lean
        self._switch(force, forces[0], leans[0])
        corners, pace = self.problem.body.vertices, self.pace
        ways = [s.part.end.apply(corners) - s.part.start.apply(corners) for s in run]
        lengths = np.linalg.norm(ways, axis=2).max(axis=1)
        ends = np.cumsum(lengths)
        along = progress(float(ends[-1]), pace.speed * self.size, pace.ramp, self.dt)
        middles = ends - lengths / 2.0
        f_com = between(along, middles, forces)
        which = np.minimum(np.searchsorted(ends, along), len(ends) - 1)
        left = (ends[which] - along) / np.maximum(lengths[which], np.finfo(float).tiny)
        shares = zip(which, np.clip(1.0 - left, 0.0, 1.0).tolist(), strict=True)
        way = [run[k].part.pose(share) for k, share in shares]
        self._add(
            "move",
            way,
            f_com=f_com,
            lean=between(along, middles, leans),
            least=np.array([found.least for found in balances])[which],
            most=np.array([found.most for found in balances])[which],
            **{name: values[which] for name, values in rows.items()},
        )
        self.pose, self.hand.f_com, self.hand.lean = way[-1], f_com[-1], leans[-1]
        self.z, self.step = rows["z"][-1], rows["step"][-1]

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
        """Change modes and commanded forces while the object rests."""
        hand, count = self.hand, self._samples(self.pace.switch)
        share = force.astype(float)
        # A finger that comes under force control does so at the force of its last touch.
        before = np.where(hand.share > 0, hand.f_com, np.minimum(self.touch, f_com))
        after = np.where(force, f_com, before)
        limit = np.where(hand.down, self.problem.fingers.max_normal_force, hand.limit)
        rising = ramp(count)[:, None]
        self._rest(
            "switch",
            self.pace.switch,
            force_share=hand.share + rising * (share - hand.share),
            f_com=before + rising * (after - before),
            lean=hand.lean + rising[:, :, None] * (lean - hand.lean),
            limit=hand.limit + rising * (limit - hand.limit),
        )
        hand.share, hand.f_com, hand.lean, hand.limit = share, after, lean, limit

    def _regrasp(self, number: int, step: RegraspStep) -> None:
        i, hand, pace = step.finger, self.hand, self.pace
        self.step, self.z = number, step.z
        force, f_com = commanded(step)
        rest = balance(self.problem, Moment(self.pose), step.placements, force, f_com, lifted=i)
        if not rest.holds:
            self.notes.append(f"no forces balance in step {number}, finger {i} lifted")
        force[i] = hand.share[i] > 0  # the leaving finger unloads in the mode that it has
        f_com[i] = min(self.touch, hand.f_com[i])
        self._switch(force, f_com, rest.forces * self.lean)
        hand.share[i] = 0.0
        chosen = np.arange(len(force)) == i
        lifted = np.zeros((self._samples(pace.lift), len(force), 3))
        lifted[:, i] = np.outer(ramp(len(lifted)), self._offs(chosen)[i])
        hand.down[i] = False
        self._rest("lift", pace.lift, off=lifted)
        hand.limit[i], hand.f_com[i] = self.touch, 0.0
        self._bring(i, np.array(step.to.point), np.array(step.to.normal))
        self._land("land", chosen)

    def _bring(self, i: int, point: Array, normal: Array) -> None:
        """Bring the lifted finger ``i`` to above its new placement."""
        hand = self.hand
        whole, clear = self._transit().way(i, point, normal)
        corners = whole[1:-1]
        if not clear:
            self.notes.append(f"step {self.step}: finger {i} finds no clear way to its new place")
        hand.points[i], hand.normals[i] = point, normal
        lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        speed = self.pace.transit * self.size
        legs = [
            a + np.outer(progress(length, speed, self.pace.ramp / 2.0, self.dt) / length, b - a)
            for a, b, length in zip(corners, corners[1:], lengths, strict=False)
            if length > 0
        ]
        path = np.concatenate(legs) if legs else corners[:1]
        self._add("transit", [self.pose] * len(path), path=(i, path))

    def _transit(self) -> Transit:
        hand, height = self.hand, self.pace.clearance * self.size
        return Transit(self.problem, self.pose, hand.points, hand.normals, height)

    def _offs(self, which: BoolArray) -> Array:
        """Return (n, 3), how the fingers ``which`` stand off, object frame; 0 for the others."""
        transit, hand = self._transit(), self.hand
        return np.array([
            transit.off(i, hand.points[i], hand.normals[i]) if chosen else np.zeros(3)
            for i, chosen in enumerate(which)
        ])  # fmt: skip

    def _land(self, phase: str, which: BoolArray) -> None:
        """Bring fingers down to their placements, and a little beyond until they feel it."""
        hand, offs = self.hand, self._offs(which)
        falling = ramp(self._samples(self.pace.lift))[:, None]
        beside = np.abs((offs * hand.normals).sum(axis=1)) <= TOUCHING * self.size
        if (offs[beside] != 0.0).any():
            # A finger that felt for the surface before it is there would land on an edge.
            share = np.where(beside[:, None], 1.0 - falling[:, :, None], 1.0)
            self._rest(phase, self.pace.lift, share * offs)
            offs = np.where(beside[:, None], 0.0, offs)
        reach = self.pace.reach * self.size * which
        looking = np.tile(which.astype(float), (len(falling), 1))
        lower, press = (1.0 - falling[:, :, None]) * offs, falling * reach
        self._rest(phase, self.pace.lift, lower, press=press, landing=looking)
        hand.down = hand.down | which

    def _rest(self, phase: str, seconds: float, off: Array | float = 0.0, **arrays: Array) -> None:
        self._add(phase, [self.pose] * self._samples(seconds), None, off, **arrays)

    def _add(
        self,
        phase: str,
        way: Sequence[Pose],
        path: tuple[int, Array] | None = None,
        off: Array | float = 0.0,
        **arrays: Array,
    ) -> None:
        """Append instants at the K poses ``way``; what is not given stays as it is.

        Fingertips are ``off`` (K, n, 3) where they touch, object frame.
        """
        K, hand = len(way), self.hand
        n = len(hand.points)
        position = np.array([pose.position for pose in way])
        rotation = np.array([pose.rotation for pose in way])
        touching = hand.points - self.problem.fingers.radius[:, None] * hand.normals
        local = touching + np.broadcast_to(off, (K, n, 3))
        centre = np.einsum("tij,tnj->tni", rotation, local) + position[:, None]
        if path is not None:
            centre[:, path[0]] = path[1]
        unchanged = self._unchanged(phase)
        assert arrays.keys() <= unchanged.keys()
        fields = {
            name: np.broadcast_to(arrays.get(name, still), (K, *still.shape)).astype(still.dtype)
            for name, still in unchanged.items()
        }
        fields["lean"] = np.einsum("tij,tnj->tni", rotation, fields["lean"])
        self.timelines.append(
            Timeline(
                dt=self.dt,
                position=position,
                rotation=rotation,
                centre=centre,
                normal=np.einsum("tij,nj->tni", rotation, hand.normals),
                notes=tuple(self.notes),
                **fields,
            )
        )
        self.notes.clear()

    def _unchanged(self, phase: str) -> dict[str, Any]:
        """Return per field of a Timeline what is so at one instant where nothing else is said."""
        hand, n = self.hand, len(self.hand.points)
        return {
            "force_share": hand.share,
            "f_com": hand.f_com,
            "lean": hand.lean,
            "least": np.full(n, np.nan),
            "most": np.full(n, np.nan),
            "limit": hand.limit,
            "press": np.zeros(n),
            "down": hand.down,
            "landing": np.zeros(n, dtype=bool),
            "step": np.array(self.step),
            "segment": np.array(-1),
            "z": np.array(self.z),
            "phase": np.array(PHASES.index(phase)),
        }
