"""From a plan to its timeline: approach, runs, switches, regrasps."""

from __future__ import annotations

from typing import Any, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.motion.arc import Moment
from gm_ompl.planfile.model import Plan, RegraspStep
from gm_ompl.problem import Problem
from gm_ompl.simulation.balance import Balance, balance, balances
from gm_ompl.simulation.hand_ways import RETURN, AirWay, HandWays
from gm_ompl.simulation.phases import Phases
from gm_ompl.simulation.segments import Run, commanded
from gm_ompl.simulation.timeline import Pace, Timeline, between, joined, progress, ramp

INSIDE = 0.01
"""Where in a segment its ends are looked at: at the end itself a face may have come down."""


def schedule(plan: Plan, problem: Problem, pace: Pace, dt: float, *, lean: bool = True) -> Timeline:
    """Lay time over ``plan``.

    The object moves at an even pace and stops only to switch modes, to regrasp and to change
    direction; commanded forces run straight from where one segment is judged to where the next
    is. Before and after, and in every switch, it rests.

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
    return Scheduler(plan, problem, pace, dt, lean).run()


@final
class Scheduler(Phases):
    """Lays down one phase after the other."""

    def run(self) -> Timeline:
        """Return the whole timeline."""
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
        return self._lowered("approach", self._standing(way.tips[-1]), hand.first(0))

    def _go_home(self, hand: HandWays) -> None:
        """Lift all fingers and bring the hand home."""
        way, now = hand.retreat(), self.now
        faint, nothing = np.minimum(self.touch, now.f_com), np.zeros_like(now.lean)
        self._switch(now.force_share > 0, faint, nothing)
        now.down, now.force_share = np.zeros_like(now.down), np.zeros_like(now.force_share)
        rising, off = ramp(self._samples(self.pace.lift)), self._standing(way.tips[0])
        turned = self._turned(rising, way.joints[0])
        self._rest("lift", self.pace.lift, np.multiply.outer(rising, off), joints=turned)
        self._rest("transit", RETURN, off)
        self._fly("transit", way)

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
        middles = ends - lengths * [1.0 - s.part.share for s in run]
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
        if self.hand is not None:
            spread["joints"] = self._hinges(self.hand, run, which, left)
        self._add("move", way, f_com=f_com, lean=lean, **spread)
        self.pose, now.f_com, now.lean = way[-1], f_com[-1], leans[-1]
        now.step, now.z = run[-1].step, run[-1].record.z
        now.joints = spread["joints"][-1] if self.hand is not None else now.joints

    def _hinges(self, hand: HandWays, run: Run, which: IntArray, left: Array) -> Array:
        """Return (K, k), where the plan has the hinges, ``left`` (K,) before segments' ends."""
        rows = []
        for k, share in zip(which.tolist(), np.clip(1.0 - left, 0.0, 1.0).tolist(), strict=True):
            part = run[k].part
            rows.append(hand.along(run[k].step, part.first + share * (part.last - part.first)))
        return np.array(rows)

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
        self._look_between(run, force, forces)
        return found

    def _look_between(self, run: Run, force: BoolArray, forces: Array) -> None:
        """Note where nothing balances at a segment's ends: a plan is judged at their middles."""
        before = np.concatenate([forces[:1], (forces[:-1] + forces[1:]) / 2.0, forces[-1:]])
        for k, segment in enumerate(run):
            for word, share, f_com in (
                ("begins", INSIDE, before[k]),
                ("ends", 1.0 - INSIDE, before[k + 1]),
            ):
                part = segment.part
                moment = part.arc.moment(part.first + share * (part.last - part.first))
                if not balances(self.problem, moment, segment.placements, force, f_com):
                    where = f"step {segment.step}, segment {segment.number}"
                    self.notes.append(
                        f"forces balance just so, or not at all, where {where} {word}"
                    )

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
        turned = now.joints if air is None else self._turned(rising, air.joints[0])
        self._rest("lift", pace.lift, off=np.multiply.outer(rising, off), joints=turned)
        if air is not None:
            self._rest("transit", RETURN, off)
        now.limit[i], now.f_com[i] = self.touch, 0.0
        self.points[i], self.normals[i] = np.array(step.to.point), np.array(step.to.normal)
        if self.hand is None or air is None:
            self._bring(i, way[1:-1])
        else:
            self._fly("transit", AirWay(air.joints, self._only(i, air.tips[:, i])))
            on = self._lowered("land", on, self.hand.last(number))
        self._land("land", chosen, on)

    def _ends(self, step: RegraspStep, air: AirWay) -> Array:
        """Return where a finger touches, stands off, does so elsewhere and touches, (4, 3)."""
        i, radius = step.finger, self.problem.fingers.radius[step.finger]
        touching = [np.array(p.point) - radius * np.array(p.normal) for p in (step.from_, step.to)]
        first, last = self.pose.apply(np.array(touching))
        return np.array([first, air.tips[0, i], air.tips[-1, i], last])

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
