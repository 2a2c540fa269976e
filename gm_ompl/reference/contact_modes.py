"""How a contact may give way: which forces go with which relative motion.

While the object deviates by a twist v from where it is carried, a contact is open, sticks, or
slides. Each such mode allows some of the contact's edges c_j to press, and some v: of the edges
those on which friction dissipates most (Coulomb's law on the linearised cone). A mode is closed:
its limits belong to it, and to its neighbours.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.reference.statics import Statics, wrench_matrix

FRICTIONLESS = 1e-12
"""Edges that differ from the normal by less than this, per unit of normal force, are the normal."""


@dataclass(frozen=True, eq=False)
class ContactMode:
    """One way in which a contact behaves; twists are R^(-T/2) times the object's, (6,).

    Attributes:
        name: in words.
        pressing: columns of all the instant's that may carry force.
        least: (a, 6), products with the twist that must not be negative.
        zero: (b, 6), products with the twist that must vanish.
    """

    name: str
    pressing: IntArray
    least: Array
    zero: Array


@dataclass(frozen=True, eq=False)
class Contact:
    """A contact of an instant, an environment contact or a fingertip.

    Attributes:
        label: in words.
        columns: its columns among all.
        normal: (6,), R^(1/2) times the wrench of a unit normal force.
        slips: (c, 6), R^(1/2) times the wrench of friction alone, per unit normal force: of each
            column.
        one_sided: whether the object cannot move into it: all but force-controlled fingertips,
            which follow along the normal.
        slides: whether it slides already, so that friction keeps its direction.
    """

    label: str
    columns: IntArray
    normal: Array
    slips: Array
    one_sided: bool
    slides: bool

    @property
    def least(self) -> Array:
        """(a, 6), products with the twist that no mode lets become negative."""
        return self.normal[None] if self.one_sided else np.zeros((0, 6))

    def modes(self, edges: int) -> Iterator[ContactMode]:
        """Yield all its modes; a soft fingertip has two moments beside its ``edges``."""
        nothing, none = np.zeros((0, 6)), np.zeros(0, dtype=np.int64)
        closed = self.normal[None] if self.one_sided else nothing
        if self.one_sided:
            yield ContactMode(f"{self.label} open", none, self.least, nothing)
        if self.slides or np.abs(self.slips).max() < FRICTIONLESS:
            yield ContactMode(f"{self.label} slides", self.columns, nothing, closed)
            return
        yield ContactMode(
            f"{self.label} sticks", self.columns, nothing, np.vstack([closed, self.slips])
        )
        for face in _faces(edges, len(self.columns)):
            first, others = face[0], np.delete(self.slips, face, axis=0)
            yield ContactMode(
                f"{self.label} slides", self.columns[list(face)], others - self.slips[first],
                np.vstack([closed, self.slips[list(face[1:])] - self.slips[first]]),
            )  # fmt: skip


def _faces(edges: int, columns: int) -> Iterator[tuple[int, ...]]:
    """Yield the proper faces of the polytope of friction per unit normal force, by its corners.

    Of a point it is a polygon; a soft fingertip's two moments make a bipyramid over it.
    """
    tips = range(edges, columns)
    sides = [(j, (j + 1) % edges) for j in range(edges)]
    yield from ((j,) for j in range(columns))
    yield from sides
    for tip in tips:
        yield from ((j, tip) for j in range(edges))
        yield from ((*side, tip) for side in sides)


def contacts_of(
    instant: Instant, model: Statics, modes: Sequence[ControlMode],
    fingers: Sequence[int] | None = None,
) -> tuple[Contact, ...]:  # fmt: skip
    """Return the contacts of an instant, fingertips last, for given control modes."""
    e = model.env_wrenches.shape[1]
    wrenches = np.hstack([model.env_wrenches, model.rob_wrenches])
    slides = [bool(slip.any()) for slip in instant.contacts.slip]
    sizes = [1 if already else instant.cone_edges for already in slides]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    told = range(len(modes)) if fingers is None else fingers
    every = [
        (f"contact {i} ({_surface(on)})", np.arange(starts[i], starts[i + 1]), True, slides[i])
        for i, on in enumerate(instant.contacts.surfaces.tolist())
    ] + [
        (
            f"finger {told[i]}",
            np.arange(own.start, own.stop) + e,
            mode is ControlMode.POSITION,
            False,
        )
        for i, (own, mode) in enumerate(zip(model.columns, modes, strict=True))
    ]
    points = np.vstack([instant.contacts.points, instant.points])
    normals = np.vstack([instant.contacts.normals, instant.normals])
    parts = normal_parts(instant, model)
    found = []
    for (label, columns, one_sided, already), p, n in zip(every, points, normals, strict=True):
        normal = model.R_sqrt @ wrench_matrix(p[None]) @ n
        friction = (wrenches[:, columns] / parts[columns]).T - normal
        found.append(Contact(label, columns, normal, friction, one_sided, already))
    return tuple(found)


def _surface(number: int) -> str:
    return "floor" if number == 0 else f"obstacle {number - 1}"


def normal_parts(instant: Instant, model: Statics) -> Array:
    """Return the normal force (e + r,) per unit of each column, environment first."""
    m = len(instant.contacts.normals)
    normals = np.zeros((3 * m, m))
    for i, n in enumerate(instant.contacts.normals):
        normals[3 * i : 3 * i + 3, i] = n
    environment = (normals.T @ model.C_env).sum(axis=0) if m else np.zeros(0)
    parts: Array = np.concatenate([environment, model.normal_parts.sum(axis=0)])
    return parts
