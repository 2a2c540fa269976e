"""Execute a plan in simulation, as modelled or in worlds a few per cent off, and judge it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.simulation.engine import STEP, EngineName
from gm_ompl.simulation.happened import happened
from gm_ompl.simulation.measure import Allowed, Measurement
from gm_ompl.simulation.outcome import ExecutionReport
from gm_ompl.simulation.play import Player
from gm_ompl.simulation.schedule import schedule
from gm_ompl.simulation.timeline import Pace, Timeline
from gm_ompl.simulation.world import KINDS, Bodies, Units, lifted, varied, world
from gm_ompl.writing import plain


@dataclass(frozen=True, eq=False)
class Setup:
    """A plan made ready for the simulator."""

    plan: Plan  # what to execute
    problem: Problem  # its scenario
    pace: Pace  # how fast
    units: Units  # from the scenario's to the simulator's
    timeline: Timeline  # the plan over time
    world: Bodies  # the bodies as the scenario has them
    allowed: Allowed = field(default_factory=Allowed)  # what still counts as holding
    engine: EngineName = "mujoco"  # the simulator, one of ``ENGINES``

    def player(self, other: Bodies | None = None) -> Player:
        """Return a player at the beginning, in this or in another world."""
        return Player(self.timeline, self.units, other or self.world, self.engine)


def prepare(
    plan: Plan, pace: Pace | None = None, *, lean: bool = True, engine: EngineName = "mujoco"
) -> Setup:
    """Make ``plan`` ready for the simulator, at the usual pace where none is given.

    Raises:
        InputError: the plan moves nothing, or its scenario cannot be simulated.
    """
    problem = problem_of(plan)
    pace, units = pace or Pace(), Units.of(problem)
    line = schedule(plan, problem, pace, STEP, lean=lean)
    allowed = Allowed() if problem.hand is None else with_a_hand(problem.body.diagonal)
    bodies = world(problem, units)
    return Setup(plan, problem, pace, units, line, bodies, allowed, engine)


def with_a_hand(size: float) -> Allowed:
    """Return what counts as holding on a robot hand, for an object of diagonal ``size`` [m].

    The object stays within 3 mm and 2 degrees, throughout. Motors give way by up to a millimetre,
    links are heavy, and a finger without a load slides.
    """
    near = 3e-3 / size
    return Allowed(near, 2.0, near, 2.0, static_slip=0.02, slip=0.02, force=0.3)


def execute(
    setup: Setup,
    other: Bodies | None = None,
    watch: Callable[[Player, int], None] | None = None,
    slack: float = 0.0,
) -> ExecutionReport:
    """Play a plan back, perhaps among other bodies than the scenario's, and judge what happened.

    ``watch`` is called with the player and every instant; ``slack`` is what errors of the
    model excuse, as a share: of D in position, in rad in angle.

    Raises:
        MissingExtraError: the engine is not installed.
    """
    return perform(setup, other, watch, slack)[0]


def perform(
    setup: Setup,
    other: Bodies | None = None,
    watch: Callable[[Player, int], None] | None = None,
    slack: float = 0.0,
) -> tuple[ExecutionReport, Measurement]:
    """Do as ``execute`` does; return what was recorded as well."""
    player = setup.player(other)
    recording = player.play(watch=None if watch is None else lambda k: watch(player, k))
    measured = Measurement(setup.plan, setup.problem, player, recording, setup.allowed.window)
    return _report(setup, measured, slack), measured


def _report(setup: Setup, measured: Measurement, slack: float) -> ExecutionReport:
    line, units = setup.timeline, setup.units
    slip = measured.slip()
    position, angle = measured.position_error(), measured.angle_error()
    # A lost object may fall for ever; its numbers then only say that it is lost.
    position, angle = np.nan_to_num(position, nan=1e9), np.nan_to_num(angle, nan=180.0)
    moving = measured.moving
    inertia, share = measured.inertia()
    segments = happened(measured, setup.allowed)
    shown = ExecutionReport(
        name=setup.problem.name,
        findings=(),
        notes=line.notes,
        duration=float(line.time[-1]),
        speed=setup.pace.speed,
        scale=(units.length, units.mass, units.force),
        size=setup.problem.body.diagonal,
        end_position=float(position[-1]),
        end_angle=float(angle[-1]),
        position=float(position[moving].max(initial=0.0)),
        angle=float(angle[moving].max(initial=0.0)),
        static_slip=max((segment.static_slip for segment in segments), default=0.0),
        fingers=tuple(measured.finger(i, slip) for i in range(line.fingers)),
        segments=segments,
        z=math.inf if setup.plan.least_z is None else setup.plan.least_z,
        inertia=inertia,
        inertia_share=share,
        torque=measured.torque,
        touching=measured.touching,
    )
    return replace(shown, findings=tuple(_findings(shown, setup, slack)))


def _findings(report: ExecutionReport, setup: Setup, slack: float) -> list[str]:
    """Return why the plan did not hold."""
    allowed, D, z_min = setup.allowed, report.size, setup.problem.mechanics.z_min
    degrees = math.degrees(slack)
    limits = [
        ("the object ends", report.end_position / D, allowed.end_position + slack, "D off"),
        ("the object ends", report.end_angle, allowed.end_angle + degrees, "deg off"),
        ("on the way the object is", report.position / D, allowed.position + slack, "D off"),
        ("on the way the object is", report.angle, allowed.angle + degrees, "deg off"),
        ("a static contact moves", report.static_slip / D, allowed.static_slip + slack, "D"),
    ]
    for finger in report.fingers:
        name = f"finger {finger.finger}"
        limits.append((f"{name} slips", finger.slip / D, allowed.slip, "D"))
        if finger.force_error is not None:
            what = f"{name}'s normal force is off by"
            limits.append((what, finger.force_error, allowed.force, "of the command"))
    found = [
        f"{what} {value:.3g} {unit}; allowed {limit:.3g}"
        for what, value, limit, unit in limits
        if not value <= limit
    ]
    found += [*_robot_findings(report), *_too_fast(setup)]
    if report.z < z_min * (1.0 - 1e-6):
        found.append(f"the plan states a z of {report.z:.6g}, below its z_min of {z_min:.6g}")
    return found


def _robot_findings(report: ExecutionReport) -> list[str]:
    """Return what motors and links did that they must not."""
    found = [f"{a} and {b} touch" for a, b in report.touching]
    if report.torque:
        most = max(report.torque, key=report.torque.__getitem__)
        if report.torque[most] > 1.0:
            asked = f"{report.torque[most]:.3g} of its motor's torque"
            found.append(f"joint {most} is asked for {asked}")
    return found


def _too_fast(setup: Setup) -> list[str]:
    """Return which hinge is to turn faster than it may."""
    hand = setup.problem.hand
    if hand is None:
        return []
    share = np.abs(setup.timeline.joint_speed).max(axis=0) / hand.speed
    worst = int(share.argmax())
    if share[worst] <= 1.0:
        return []
    return [f"joint {hand.joints[worst]} is to turn at {share[worst]:.3g} of its speed"]


@dataclass(frozen=True)
class VariationReport:
    """Executions of one plan in several worlds."""

    error_limit: float  # the greatest error, 0.03 for three per cent
    kinds: tuple[str, ...]  # what is off: ``KINDS`` or some of them
    z: float  # the smallest stability margin that the plan states
    runs: dict[int, ExecutionReport]  # by the seed of the errors

    @property
    def share(self) -> float:
        """Share of the executions that held."""
        return sum(run.holds for run in self.runs.values()) / max(len(self.runs), 1)

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON."""
        kept = ("holds", "findings", "end_position", "end_angle")
        runs = [
            {"seed": seed, **{name: plain(getattr(run, name)) for name in kept}}
            for seed, run in self.runs.items()
        ]
        told = {"success": self.share, "share": self.error_limit, "kinds": self.kinds, "z": self.z}
        return {**plain(told), "runs": runs}

    def table(self) -> str:
        """Return the report as lines of text."""
        failed = {seed: run for seed, run in self.runs.items() if not run.holds}
        lines = [
            f"{', '.join(self.kinds)} off by up to {100 * self.error_limit:g}%: "
            f"{len(self.runs) - len(failed)} of {len(self.runs)} executions hold "
            f"({100 * self.share:.1f}%); least z {self.z:.4g}"
        ]
        return "\n".join([*lines, *(f"  seed {k}: {r.findings[0]}" for k, r in failed.items())])


def errant_world(setup: Setup, share: float, seed: int, kinds: Collection[str] = KINDS) -> Bodies:
    """Return a world that is off by up to ``share`` in ``kinds``."""
    first = setup.timeline
    inward = np.einsum("ji,nj->ni", first.rotation[0], first.normal[0])
    other = varied(setup.world, share, inward, np.random.default_rng(seed), kinds)
    return lifted(other, setup.world, first.rotation[0])


def vary(
    setup: Setup, share: float, count: int, seed: int, kinds: Sequence[str] = KINDS
) -> VariationReport:
    """Execute a plan in ``count`` worlds whose ``kinds`` are off by up to ``share``.

    Their seeds are ``seed``, ``seed + 1``, ... Position and angle may be off by that much more
    than otherwise.
    """
    runs = {
        number: execute(setup, errant_world(setup, share, number, kinds), slack=share)
        for number in range(seed, seed + count)
    }
    least = setup.plan.least_z
    return VariationReport(share, tuple(kinds), math.inf if least is None else least, runs)
