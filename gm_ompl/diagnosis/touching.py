"""Where the object touches its environment at an instant, and what each contact does."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from gm_ompl.contact.environment import EnvironmentContacts, contact_state, environment_contacts
from gm_ompl.diagnosis.values import ContactLine
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Environment, Problem

SAME = 1e-6
"""Contacts nearer to each other than this, relative to D, are one."""


def contacts_at(
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
    environment = problem.environment
    alone: list[tuple[str, Environment]] = []
    if environment.floor:
        alone.append(("floor", dataclasses.replace(environment, obstacles=())))
    for obstacle in environment.obstacles:
        part = dataclasses.replace(environment, floor=False, obstacles=(obstacle,))
        alone.append((obstacle.name, part))
    for name, part in alone:
        yield name, environment_contacts(problem.body, part, pose)


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
