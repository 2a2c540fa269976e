"""Why one instant fails: what penetrates what, what contacts do, z per combination of modes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import final

import numpy as np

from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.environment import (
    Environment,
    EnvironmentContacts,
    contact_state,
    contacts_at,
    environment_contacts,
)
from gm_ompl.contact.state import Instant
from gm_ompl.diagnosis.values import ContactLine, InstantLine, ModeLine
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.mechanics.case_alternatives import choices_at
from gm_ompl.mechanics.strongest import strong_choices
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements, Problem

SAME = 1e-6
"""Contacts nearer to each other than this, relative to D, are one."""


def contact_lines(
    problem: Problem, q: Coordinates, directions: Sequence[Coordinates | None]
) -> tuple[ContactLine, ...]:
    """Return every contact that carries force, and what it does in each direction of motion.

    Points inside contact patches (``mechanics.patch_points``) are left out.

    Args:
        problem: the problem.
        q: object coordinates.
        directions: of motion; None is rest.
    """
    pose = problem.motion.pose(q)
    every = environment_contacts(problem.body, problem.environment, pose)
    corners = len(every.points) if every.corners is None else every.corners
    named = list(_named(problem, pose))
    return tuple(
        ContactLine(
            against=_against(named, every, k, SAME * problem.body.diagonal),
            point=tuple(every.points[k].tolist()),
            normal=tuple((every.normals[k] + 0.0).tolist()),
            motion={
                direction_name(problem, direction): _motion(problem, q, direction, every, k)
                for direction in directions
            },
        )
        for k in range(corners)
    )


def direction_name(problem: Problem, direction: Coordinates | None) -> str:
    """Return a direction of motion in words: "rest", "+s", "-yaw"."""
    if direction is None:
        return "rest"
    parts = zip(direction, problem.motion.names, strict=True)
    return " ".join(f"{'+' if value > 0 else '-'}{name}" for value, name in parts if value)


def _motion(
    problem: Problem,
    q: Coordinates,
    direction: Coordinates | None,
    every: EnvironmentContacts,
    k: int,
) -> str:
    pose = problem.motion.pose(q)
    twist = None if direction is None else problem.motion.velocity(q, direction)
    alone = EnvironmentContacts(every.points[k : k + 1], every.normals[k : k + 1])
    state = contact_state(alone, pose, twist, problem.body)
    if not len(state.points):
        return "separates"
    return "slides" if np.abs(state.slip).max() > 0.0 else "sticks"


def _named(problem: Problem, pose: Pose) -> Iterator[tuple[str, EnvironmentContacts]]:
    """Yield what touches the object, each part of the environment asked alone."""
    for name, part in parts_alone(problem.environment):
        yield name, environment_contacts(problem.body, part, pose)


def parts_alone(environment: Environment) -> Iterator[tuple[str, Environment]]:
    """Yield the floor and each obstacle as environments of their own, with their names."""
    if environment.floor:
        yield "floor", replace(environment, obstacles=())
    for obstacle in environment.obstacles:
        yield obstacle.name, replace(environment, floor=False, obstacles=(obstacle,))


def _against(
    named: list[tuple[str, EnvironmentContacts]], every: EnvironmentContacts, k: int, near: float
) -> str:
    touching = []
    for name, own in named:
        gaps = np.abs(own.points - every.points[k]).max(axis=1, initial=0.0)
        turns = np.abs(own.normals - every.normals[k]).max(axis=1, initial=0.0)
        if ((gaps <= near) & (turns <= SAME)).any():
            touching.append(name)
    return ", ".join(touching)


@final
class Blame:
    """Names what penetrates what; floor, object and every obstacle are asked alone.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        body, environment = problem.body, problem.environment
        self._object = Scene(body, [], False)
        touching, obstacles = environment.contact_tolerance, environment.obstacles
        self._scenes = {o.name: Scene(body, [o.body], False, touching) for o in obstacles}
        if environment.floor:
            self._scenes["floor"] = Scene(body, [], True, touching)

    def configuration(self, pose: Pose, placements: Placements) -> tuple[str, ...]:
        """Return a sentence for everything that penetrates something; none if valid."""
        found = [
            f"the object penetrates {name}"
            for name, scene in self._scenes.items()
            if not scene.object_free(pose)
        ]
        hand, table = self._problem.fingers, self._problem.fingers.placements
        for i, row in enumerate(placements):
            radius, at = float(hand.radius[i]), slice(row, row + 1)
            tip = (pose, table.centres(radius)[at], radius, table.piece[at])
            # Every scene holds the object's own pieces: what they block is not the obstacle's.
            if not self._object.free_placements(*tip)[0]:
                found.append(f"the fingertip of finger {i} penetrates the object")
                continue
            found += [
                f"the fingertip of finger {i} penetrates {name}"
                for name, scene in self._scenes.items()
                if not scene.free_placements(*tip)[0]
            ]
        return (*found, *self._pairs(placements))

    def _pairs(self, placements: Placements) -> list[str]:
        hand, table = self._problem.fingers, self._problem.fingers.placements
        found = []
        for i, row in enumerate(placements):
            for j in range(i):
                a, b = float(hand.radius[j]), float(hand.radius[i])
                other = placements[j]
                apart = self._object.tips_apart(
                    table.centres(a)[other : other + 1], a, table.centres(b)[row : row + 1], b
                )
                if not apart[0, 0]:
                    found.append(f"the fingertips of fingers {j} and {i} penetrate each other")
        return found


_AXES = ("x", "y", "z")


@final
class Explainer:
    """Explains instants of one problem.

    Args:
        problem: the problem.
        judge: its judge.
        stop: asked between instants where there are many; True ends the work early.
    """

    def __init__(
        self, problem: Problem, judge: Judge, stop: Callable[[], bool] = lambda: False
    ) -> None:
        self.problem, self.judge, self.stop = problem, judge, stop
        self._blame = Blame(problem)

    def verdict(
        self, q: Coordinates, direction: Coordinates | None, placements: Placements
    ) -> Verdict:
        """Return the judge's verdict, z exact."""
        return self.judge.segment(self.problem.motion.moment(q, direction), placements)

    def line(
        self,
        q: Coordinates,
        direction: Coordinates | None,
        placements: Placements,
        verdict: Verdict,
    ) -> InstantLine:
        """Return what blocks an instant, without the combinations of modes."""
        line = self.at(self.problem.motion.pose(q), placements, verdict)
        return replace(line, q=q, direction=direction)

    def at(self, pose: Pose, placements: Placements, verdict: Verdict) -> InstantLine:
        """Return what blocks the object at a pose, told without coordinates."""
        blocked: tuple[str, ...] = ()
        if verdict.finding is Finding.GEOMETRY:
            blocked = self._blame.configuration(pose, placements)
        decision = verdict.decision
        z = decision.z if decision is not None and math.isfinite(decision.z) else None
        return InstantLine(
            q=(),
            direction=None,
            finding=verdict.finding,
            blocked_by=blocked,
            z=z,
            ratio=self.ratio(verdict),
            limit=None if decision is None else disturbance(decision.direction),
        )

    def ratio(self, verdict: Verdict) -> float | None:
        """Return z / z_min; 0 without equilibrium, None where geometry or (5) fails first.

        None as well where z_min is 0.
        """
        z_min = self.problem.mechanics.z_min
        if z_min <= 0.0:
            return None
        if verdict.finding is Finding.NO_EQUILIBRIUM:
            return 0.0
        if verdict.decision is None or not math.isfinite(verdict.decision.z):
            return None
        return verdict.decision.z / z_min

    def detailed(
        self, q: Coordinates, direction: Coordinates | None, placements: Placements
    ) -> InstantLine:
        """Return what blocks an instant, with every combination of modes."""
        verdict = self.verdict(q, direction, placements)
        line = self.line(q, direction, placements, verdict)
        if verdict.finding is Finding.GEOMETRY:
            return line
        problem, moment = self.problem, self.problem.motion.moment(q, direction)
        contacts = contacts_at(moment, problem.body, problem.environment)
        instant = problem.instant(contacts, tuple(range(len(placements))), placements)
        gives_way: tuple[str, ...] = ()
        best = verdict.decision
        if best is not None and best.nominal is not None:
            # Imported late: it loads HiGHS.
            from gm_ompl.reference.strong import strong_margin

            gives_way = strong_margin(instant, best.modes, best.f_com, best.nominal).modes
        return replace(line, gives_way=gives_way, modes=self._modes(instant, placements))

    def _modes(self, instant: Instant, placements: Placements) -> tuple[ModeLine, ...]:
        strong = self.problem.mechanics.strong
        choices = strong_choices(instant) if strong else choices_at(instant).modes(0.0)
        found = {d.modes: d for d in choices}
        every = itertools.product(ControlMode, repeat=len(placements))
        return tuple(_mode_line(modes, found.get(modes)) for modes in every)


def _mode_line(modes: tuple[ControlMode, ...], found: ModeDecision | None) -> ModeLine:
    names = tuple(mode.value for mode in modes)
    if found is None:
        return ModeLine(names, True, None, ())
    return ModeLine(names, False, found.z, found.f_com)


def disturbance(direction: int) -> str | None:
    """Return in words the direction l_i that limits z; None where none does.

    The wrench that cannot be balanced is a disturbance along l_i with the sign turned.
    """
    if direction < 0:
        return None
    if direction >= 12:
        return "a force and a moment together"
    # In Problem (6) z l_i = R^(1/2)(Q_known + contacts): the disturbance resisted is -z l_i.
    sign = "-" if direction % 2 == 0 else "+"
    axis = _AXES[(direction // 2) % 3]
    kind = "a force along" if direction < 6 else "a moment about"
    return f"{kind} the object's {sign}{axis}"
