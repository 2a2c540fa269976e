"""z_strong once more: every mode of every contact, none skipped, from forces and velocities."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.optimize import linprog

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.reference.stability import DIRECTIONS
from gm_ompl.reference.statics import friction_cone, scaling_root

Branch = tuple[list[tuple[Array, Array]], list[tuple[Array, Array]], list[tuple[Array, Array]]]
"""Forces (with moments) that may press, and what of (velocity, turning) must not be negative, or
must vanish; each as a pair of vectors."""


def brute_strong(
    instant: Instant, modes: Sequence[ControlMode], f_com: Sequence[float | None], z: float
) -> float:
    """Return z_strong by a linear program for every combination of what contacts may do."""
    best, points = z, np.vstack([instant.contacts.points, instant.points])
    root = scaling_root(instant.mass, instant.inertia)
    per_contact = [list(branches) for branches in _all_branches(instant, modes)]
    for combination in itertools.product(*per_contact):
        t = _least(instant, modes, f_com, points, root, combination)
        if t < best and _moves(points, combination):
            best = t
    return best


def _all_branches(instant: Instant, modes: Sequence[ControlMode]) -> Iterator[Iterator[Branch]]:
    contacts = instant.contacts
    x, y, _ = contacts.rotation
    for n, slip, mu in zip(
        contacts.normals, contacts.slip, instant.friction_at_contacts, strict=True
    ):
        if slip.any():
            yield _sliding(n, n - mu * slip)
        else:
            yield _branches(n, friction_cone(n, mu, instant.cone_edges, x, y), 0.0, blocked=True)
    ones = np.eye(3)
    for n, mu, soft, mode in zip(
        instant.normals, instant.friction, instant.soft, modes, strict=True
    ):
        cone = friction_cone(n, mu, instant.cone_edges, ones[0], ones[1])
        yield _branches(n, cone, mu * soft, blocked=mode is ControlMode.POSITION)


def _sliding(n: Array, force: Array) -> Iterator[Branch]:
    none = np.zeros(3)
    yield [], [(n, none)], []
    yield [(force, none)], [], [(n, none)]


def _branches(n: Array, cone: Array, twist: float, *, blocked: bool) -> Iterator[Branch]:
    """Open; and per set of corners, those on which friction dissipates equally, and most."""
    none, shut = np.zeros(3), [(n, np.zeros(3))] if blocked else []
    corners = [(c / (n @ c), none) for c in cone.T]
    if twist > 0.0:
        corners += [(n, twist * n), (n, -twist * n)]
    if blocked:
        yield [], shut, []
    spread = max(np.abs(force - n).max() + np.abs(moment).max() for force, moment in corners)
    if spread < 1e-12:
        yield corners[:1], [], shut
        return
    for size in range(1, len(corners) + 1):
        for chosen in itertools.combinations(range(len(corners)), size):
            first = corners[chosen[0]]
            others = [corners[j] for j in range(len(corners)) if j not in chosen]
            least = [(a - first[0], b - first[1]) for a, b in others]
            equal = [(corners[j][0] - first[0], corners[j][1] - first[1]) for j in chosen[1:]]
            yield [corners[j] for j in chosen], least, [*shut, *equal]


def _moves(points: Array, combination: Sequence[Branch]) -> bool:
    """Whether a twist other than 0 goes with a combination: some component can be +-1."""
    size = np.abs(points).max(initial=0.0) or 1.0

    def rows(kind: int) -> Array:
        made = [
            np.concatenate([a, (np.cross(p, a) + b) / size])
            for p, branch in zip(points, combination, strict=True) for a, b in branch[kind]
        ]  # fmt: skip
        return np.array(made).reshape(-1, 6)

    least, zero = rows(1), rows(2)
    for k, sign in itertools.product(range(6), (1.0, -1.0)):
        bounds = [(-1.0, 1.0)] * 6
        found = linprog(
            -sign * np.eye(6)[k],
            A_ub=-least if len(least) else None, b_ub=np.zeros(len(least)) if len(least) else None,
            A_eq=zero if len(zero) else None, b_eq=np.zeros(len(zero)) if len(zero) else None,
            bounds=bounds,
        )  # fmt: skip
        if found.status == 0 and -found.fun > 1e-6:
            return True
    return False


def _least(
    instant: Instant, modes: Sequence[ControlMode], f_com: Sequence[float | None], points: Array,
    root: Array, combination: Sequence[Branch],
) -> float:  # fmt: skip
    """Return the least t at which forces of a combination balance the load, inf for never."""
    columns, owner = [], []
    for i, (p, branch) in enumerate(zip(points, combination, strict=True)):
        for force, moment in branch[0]:
            columns.append(root @ np.concatenate([force, np.cross(p, force) + moment]))
            owner.append(i)
    down = instant.mass * instant.gravity * instant.contacts.rotation[2]
    load = root @ (np.concatenate([-down, np.zeros(3)]) + instant.excess)
    count, m = len(DIRECTIONS), len(instant.contacts.points)
    matrix = np.column_stack([DIRECTIONS.T, *columns]) if columns else DIRECTIONS.T
    cost = np.concatenate([np.ones(count), np.zeros(len(columns))])
    equal, equal_to, most, most_to = [*matrix], [*-load], [], []
    for i, (mode, f) in enumerate(zip(modes, f_com, strict=True)):
        row = np.concatenate([np.zeros(count), [float(j == m + i) for j in owner]])
        if mode is ControlMode.FORCE:
            equal.append(row)
            equal_to.append(0.0 if f is None else f)
        else:
            most.append(row)
            most_to.append(instant.max_normal_force[i])
    found = linprog(
        cost, A_ub=np.array(most) if most else None, b_ub=most_to or None,
        A_eq=np.array(equal), b_eq=equal_to,
    )  # fmt: skip
    return float(found.fun) if found.status == 0 else np.inf
