"""The mechanical model of Sec. 2.2 in the paper's letters, object frame.

Forces are divided by ``Instant.force_scale`` (the object's weight), so that the solver's
tolerances mean the same for any object; whoever reports a force multiplies it back.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag

from gm_ompl.arrays import Array
from gm_ompl.contact.state import Instant


@dataclass(frozen=True, eq=False)
class Statics:
    """Matrices of Eqs. (1)-(4), (7), (8) at an instant; m contacts, n fingers, s edges.

    Attributes:
        W_env: (6, 3m), wrench matrix of the environment contacts.
        C_env: (3m, e), their cone edges: s columns where static, one where sliding.
        W_rob: (6, 3n), wrench matrix of the fingers.
        C_rob: (3n, r), their cone edges, s each; a soft finger's normal twice more.
        M_rob: (3, r), the moments that come with these forces: mu L and -mu L about the normal
            for a soft finger's two normals, else zero.
        N_rob: (3n, n), their normals.
        R_sqrt: (6, 6), the upper Cholesky factor of R.
        Q_known: (6,), gravity, and what is more of it in a world, divided by ``scale``.
        f_max: (n,), limits on the normal forces divided by ``scale``.
        scale: the unit of force.
        columns: per finger, which of the r columns are its own.
    """

    W_env: Array
    C_env: Array
    W_rob: Array
    C_rob: Array
    M_rob: Array
    N_rob: Array
    R_sqrt: Array
    Q_known: Array
    f_max: Array
    scale: float
    columns: tuple[slice, ...]

    @property
    def fingers(self) -> int:
        """Number of fingers n."""
        return len(self.f_max)

    @property
    def load(self) -> Array:
        """R^(1/2) Q_known, (6,)."""
        load: Array = self.R_sqrt @ self.Q_known
        return load

    @property
    def env_wrenches(self) -> Array:
        """R^(1/2) W_env C_env, (6, e): one column per edge; its length is the norm (7)."""
        wrenches: Array = self.R_sqrt @ self.W_env @ self.C_env
        return wrenches

    @property
    def rob_wrenches(self) -> Array:
        """R^(1/2) (W_rob C_rob + the moments M_rob), (6, r)."""
        whole = self.W_rob @ self.C_rob
        whole[3:] += self.M_rob
        wrenches: Array = self.R_sqrt @ whole
        return wrenches

    @property
    def normal_parts(self) -> Array:
        """N_rob^T C_rob, (n, r): the normal force of each finger per unit of each column."""
        parts: Array = self.N_rob.T @ self.C_rob
        return parts


def statics(instant: Instant) -> Statics:
    """Assemble Sec. 2.2 at an instant."""
    contacts = instant.contacts
    scale = force_unit(instant)
    world_x, world_y, _ = contacts.rotation  # rows: the world's axes, object frame
    C_env = [
        sliding_edge(n, mu, slip)[:, None]
        if slip.any()
        else friction_cone(n, mu, instant.cone_edges, world_x, world_y)
        for n, slip, mu in zip(
            contacts.normals, contacts.slip, instant.friction_at_contacts.tolist(), strict=True
        )
    ]
    tips = [
        fingertip(n, mu, instant.cone_edges, soft)
        for n, mu, soft in zip(instant.normals, instant.friction, instant.soft, strict=True)
    ]
    ends = np.cumsum([0, *(forces.shape[1] for forces, _ in tips)]).tolist()
    return Statics(
        W_env=wrench_matrix(contacts.points),
        C_env=_block_diagonal(C_env),
        W_rob=wrench_matrix(instant.points),
        C_rob=_block_diagonal([forces for forces, _ in tips]),
        M_rob=np.hstack([np.zeros((3, 0)), *(moments for _, moments in tips)]),
        N_rob=_block_diagonal([n[:, None] for n in instant.normals]),
        R_sqrt=scaling_root(instant.mass, instant.inertia),
        Q_known=known_wrench(instant),
        f_max=instant.max_normal_force / scale,
        scale=scale,
        columns=tuple(slice(a, b) for a, b in pairwise(ends)),
    )


def known_wrench(instant: Instant) -> Array:
    """Return Q_known, (6,), of gravity, over ``force_unit``."""
    weight = instant.mass * instant.gravity * instant.contacts.rotation[2]
    known: Array = (np.concatenate([-weight, np.zeros(3)]) + instant.excess) / force_unit(instant)
    return known


def force_unit(instant: Instant) -> float:
    """Return ``force_scale``, or 1 where it is 0: no gravity, and no finger that can press."""
    return instant.force_scale or 1.0


def friction_cone(normal: Array, mu: float, edges: int, x: Array, y: Array) -> Array:
    """Return the unit edges c_1..c_s of a static contact's cone, (3, edges), Eq. (1).

    Args:
        normal: (3,), unit, pointing into the object.
        mu: Coulomb coefficient; the edges lie on the Coulomb cone.
        edges: s.
        x: (3,), the axis the edges are counted from.
        y: (3,), the axis used instead where ``normal`` is nearly along ``x``.
    """
    reference = y if abs(normal @ x) >= 0.9 else x
    t1 = reference - (reference @ normal) * normal
    t1 = t1 / np.linalg.norm(t1)
    t2 = np.cross(normal, t1)
    theta = 2.0 * np.pi * np.arange(edges) / edges
    c = normal[:, None] + mu * (np.outer(t1, np.cos(theta)) + np.outer(t2, np.sin(theta)))
    cone: Array = c / np.linalg.norm(c, axis=0)
    return cone


def fingertip(normal: Array, mu: float, edges: int, soft: float) -> tuple[Array, Array]:
    """Return a fingertip's columns: forces (3, c) and the moments (3, c) that come with them.

    Args:
        normal: (3,), unit, pointing into the object; the cone is counted from the object's axes.
        mu: Coulomb coefficient.
        edges: s.
        soft: L. Where positive, unit normal force with a moment of +-mu L about the normal
            follows the s edges, whose moment is zero.
    """
    object_x, object_y, _ = np.eye(3)
    cone = friction_cone(normal, mu, edges, object_x, object_y)
    if soft == 0.0:
        return cone, np.zeros_like(cone)
    twist = mu * soft * normal[:, None]
    both = np.repeat(normal[:, None], 2, axis=1)
    return np.hstack([cone, both]), np.hstack([np.zeros_like(cone), twist, -twist])


def sliding_edge(normal: Array, mu: float, slip: Array) -> Array:
    """Return c', (3,): the one unit edge of a contact that slides along unit ``slip``."""
    c = normal - mu * slip
    edge: Array = c / np.linalg.norm(c)
    return edge


def wrench_matrix(points: Array) -> Array:
    """Return W, (6, 3m): forces at ``points`` (m, 3) to a wrench about the origin."""
    blocks = [np.vstack([np.eye(3), cross_matrix(p)]) for p in points]
    return np.hstack(blocks) if blocks else np.zeros((6, 0))


def cross_matrix(p: Array) -> Array:
    """Return p x I_3, so that ``cross_matrix(p) @ f`` is the cross product of p and f."""
    return np.array([[0.0, -p[2], p[1]], [p[2], 0.0, -p[0]], [-p[1], p[0], 0.0]])


def scaling_root(mass: float, inertia: Array) -> Array:
    """Return R^(1/2), (6, 6), upper triangular, with R of Eq. (8): |R^(1/2) Q| is norm (7)."""
    R = np.eye(6)
    R[3:, 3:] = mass * np.linalg.inv(inertia)
    root: Array = np.asarray(np.linalg.cholesky(R).T, dtype=np.float64)
    return root


def _block_diagonal(blocks: list[Array]) -> Array:
    if not blocks:
        return np.zeros((0, 0))
    diagonal: Array = block_diag(*blocks)
    return diagonal
