"""The columns of many contact states, compiled: what ``columns`` says of one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, compiled_as_written
from gm_ompl.geometry.flat import summed


class StateRows(NamedTuple):
    """Contact states, one behind the other, as ``ContactState`` has them.

    Attributes:
        points: (c, 3), of all states.
        normals: (c, 3).
        slip: (c, 3).
        surfaces: (c,).
        rotations: (K, 3, 3).
        first: (K + 1,), where each state's contacts begin.
    """

    points: Array
    normals: Array
    slip: Array
    surfaces: IntArray
    rotations: Array
    first: IntArray


class Columns(NamedTuple):
    """What acts at contact states, one behind the other, forces over the unit of force.

    Attributes:
        env: (e, 6), the environment's columns.
        first: (K + 1,), where each state's begin.
        loads: (K, 6).
    """

    env: Array
    first: IntArray
    loads: Array


class Cones(NamedTuple):
    """What columns are made by.

    Attributes:
        edges: (s, 3), of a friction cone in its own axes, as ``edge_weights`` has them.
        friction: Coulomb coefficient of every contact.
        U: (6, 6), of the norm (7).
        weight: the object's, over the unit of force.
    """

    edges: Array
    friction: float
    U: Array
    weight: float


@compiled_as_written
def count_columns(states: StateRows, past: int, cones: Cones, into: Columns, new: int) -> int:
    """Write where the columns of states ``new`` to ``past`` begin; return where they end."""
    for k in range(new, past):
        count = 0
        for i in range(states.first[k], states.first[k + 1]):
            count += 1 if _slides(states.slip[i]) else len(cones.edges)
        into.first[k + 1] = into.first[k] + count
    return int(into.first[past])


@compiled_as_written
def write_columns(states: StateRows, past: int, cones: Cones, into: Columns, new: int) -> None:
    """Write the columns and loads of states ``new`` to ``past``, counted before."""
    axes, wrenches, force = np.empty((3, 3)), np.empty((3, 6)), np.empty(3)
    wrench = np.zeros(6)
    for k in range(new, past):
        row, R = into.first[k], states.rotations[k]
        for i in range(states.first[k], states.first[k + 1]):
            point, normal, slip = states.points[i], states.normals[i], states.slip[i]
            if _slides(slip):
                for c in range(3):
                    force[c] = normal[c] - cones.friction * slip[c]
                length = np.sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2])
                for c in range(3):
                    force[c] /= length
                _wrench(point, force, cones.U, wrench, into.env[row])
                row += 1
                continue
            _axes(normal, R, axes)
            for a in range(3):
                _wrench(point, axes[a], cones.U, wrench, wrenches[a])
            for e in range(len(cones.edges)):
                for c in range(6):
                    into.env[row, c] = summed(cones.edges[e], wrenches[:, c])
                row += 1
        for c in range(3):
            wrench[c], wrench[3 + c] = -cones.weight * R[2, c], 0.0
        for c in range(6):
            into.loads[k, c] = _along(cones.U[c], wrench)


@compiled_as_written
def _slides(slip: Array) -> bool:
    return bool(slip[0] != 0.0 or slip[1] != 0.0 or slip[2] != 0.0)


@compiled_as_written
def _axes(normal: Array, R: Array, axes: Array) -> None:
    """Write a friction cone's axes (3, 3) as ``cone_axes`` has them."""
    reference = R[1] if abs(summed(normal, R[0])) >= 0.9 else R[0]
    along = normal[0] * reference[0] + normal[1] * reference[1] + normal[2] * reference[2]
    for c in range(3):
        axes[0, c], axes[1, c] = normal[c], reference[c] - along * normal[c]
    t = axes[1]
    length = np.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
    for c in range(3):
        t[c] /= length
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        axes[2, c] = normal[d] * t[e] - normal[e] * t[d]


@compiled
def _along(row: Array, wrench: Array) -> float:
    """Return a sum of six products, added up as in numpy's products of matrices."""
    total = 0.0
    for c in range(6):
        total += row[c] * wrench[c]
    return total


@compiled_as_written
def _wrench(point: Array, force: Array, U: Array, room: Array, into: Array) -> None:
    """Write U [f; p x f] (6,)."""
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        room[c], room[3 + c] = force[c], point[d] * force[e] - point[e] * force[d]
    for c in range(6):
        into[c] = _along(U[c], room)
