"""A hand in MuJoCo: where links are, how fingertips move, what touches what.

Links are as the file has them, meshes by their convex hulls, as MuJoCo collides them. The object
floats among them and is put where it is asked for; so are obstacles, the floor is z < 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.hand.parsing import mujoco, parsed
from gm_ompl.hand.scene import HAND, capsule, scene
from gm_ompl.hand.spec import HandSpec

SHARED: Final = -1
"""Owner of what belongs to no finger alone: a common arm, the base."""

WORLD: Final = -2
"""Owner of floor and obstacles."""

OBJECT: Final = -3
"""Owner of the object."""


class Hit(NamedTuple):
    """Two bodies that penetrate each other.

    Attributes:
        first: what belongs to whom: a finger's number, ``SHARED``, ``WORLD`` or ``OBJECT``.
        second: likewise.
        names: their names.
        depth: how deep [m].
    """

    first: int
    second: int
    names: tuple[str, str]
    depth: float


class HandModel:
    """A hand among an object and obstacles.

    Args:
        spec: the hand.
        body: the object.
        obstacles: fixed bodies, world frame.
        floor: whether z < 0 is solid.

    Attributes:
        spec: the hand.
        chains: per finger, which hinges (k,) move its fingertip.
        own: per finger, those of them that move no other's.
        columns: (k,), where the hinges are among MuJoCo's degrees of freedom.
    """

    def __init__(
        self, spec: HandSpec, body: Body, obstacles: Sequence[Body] = (), floor: bool = True
    ) -> None:
        self._mujoco = mujoco()
        self.spec, self.count = spec, len(spec.tips)
        self.model = scene(
            self._mujoco, parsed(spec.path, spec.text), spec, (body, obstacles, floor)
        )
        self.data = self._mujoco.MjData(self.model)
        model = self.model
        self._q = np.array([model.joint(HAND + name).qposadr[0] for name in spec.joints])
        self.columns = np.array([model.joint(HAND + name).dofadr[0] for name in spec.joints])
        self._free = int(model.joint("object").qposadr[0])
        self._sites = [model.site(f"tip{i}").id for i in range(self.count)]
        self.chains = tuple(self._chain(site) for site in self._sites)
        every = np.sum(self.chains, axis=0)
        self.own: tuple[BoolArray, ...] = tuple(chain & (every == 1) for chain in self.chains)
        self._owner = self._owners()
        self._tip_bodies = {self.tip_body(i): i for i in range(self.count)}
        self._jacobian, self._turn = np.zeros((3, model.nv)), np.zeros((3, model.nv))

    def _chain(self, site: int) -> BoolArray:
        """Return which hinges (k,) move a fingertip: those on the way to the base."""
        moved, body = np.zeros(len(self._q), dtype=bool), int(self.model.site_bodyid[site])
        while body:
            moved |= self.model.jnt_bodyid[[self._joint(n) for n in self.spec.joints]] == body
            body = int(self.model.body_parentid[body])
        return moved

    def _joint(self, name: str) -> int:
        return int(self.model.joint(HAND + name).id)

    def _owners(self) -> IntArray:
        """Return per geom whose it is: the only finger whose own hinges move it, or nobody's."""
        model, owner = self.model, np.full(self.model.ngeom, SHARED, dtype=np.int64)
        of_joint = {
            int(model.jnt_bodyid[self._joint(name)]): k for k, name in enumerate(self.spec.joints)
        }
        for geom in range(model.ngeom):
            body = int(model.geom_bodyid[geom])
            name = model.body(body).name
            if not name.startswith(HAND):
                owner[geom] = OBJECT if name == "object" else WORLD
                continue
            while body and owner[geom] == SHARED:
                for i, own in enumerate(self.own):
                    if own[of_joint[body]] if body in of_joint else False:
                        owner[geom] = i
                body = int(model.body_parentid[body])
        return owner

    def place(self, q: Array, pose: Pose | None = None) -> None:
        """Put hinges (k,) and the object where they are asked for; without a pose far away."""
        data, at = self.data, self._free
        data.qpos[self._q] = q
        if pose is None:
            data.qpos[at : at + 7] = [0.0, 0.0, 1e3, 1.0, 0.0, 0.0, 0.0]
        else:
            data.qpos[at : at + 3], data.qpos[at + 3 : at + 7] = pose.position, pose.quaternion()
        self._mujoco.mj_kinematics(self.model, data)

    def tips(self) -> Array:
        """Return the fingertips' centres (n, 3), world frame, as placed."""
        return np.array(self.data.site_xpos[self._sites])

    def tip_body(self, finger: int) -> int:
        """Return MuJoCo's number of a fingertip's link."""
        return int(self.model.site_bodyid[self._sites[finger]])

    def jacobian(self, finger: int) -> Array:
        """Return (3, k), how a fingertip's centre moves with the hinges, as placed."""
        self._mujoco.mj_comPos(self.model, self.data)
        self._mujoco.mj_jacSite(
            self.model, self.data, self._jacobian, self._turn, self._sites[finger]
        )
        return np.array(self._jacobian[:, self.columns])

    def turning(self, finger: int) -> Array:
        """Return (3, k), how a fingertip's link turns with the hinges; after ``jacobian``."""
        self.jacobian(finger)
        return np.array(self._turn[:, self.columns])

    def hit(
        self, touch: Array, fingers: Iterable[int] | None = None, clear: float = 0.0
    ) -> Hit | None:
        """Return two bodies that penetrate each other, as placed; None where all are clear.

        Args:
            touch: (n,), how deep a fingertip's own link may be in the object [m].
            fingers: only what belongs to these and to no finger alone; all by default.
            clear: how far links other than fingertips' must keep from the object [m].
        """
        self.model.geom_margin[:] = clear
        self._mujoco.mj_collision(self.model, self.data)
        if not self.data.ncon:
            return None
        asked = None if fingers is None else {*fingers, SHARED, WORLD, OBJECT}
        contact = self.data.contact
        for (a, b), gap in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            owners = int(self._owner[a]), int(self._owner[b])
            if gap >= (clear if OBJECT in owners else 0.0):
                continue
            if asked is not None and not asked.issuperset(owners):
                continue
            bodies = [int(self.model.geom_bodyid[g]) for g in (a, b)]
            if min(owners) > WORLD and self._joined(*bodies):
                continue
            tips = [self._tip_bodies[body] for body in bodies if body in self._tip_bodies]
            if gap < (-touch[tips[0]] if tips and OBJECT in owners else 0.0):
                names = (self._name(a), self._name(b))
                return Hit(*owners, names, -gap)
        return None

    def _joined(self, a: int, b: int) -> bool:
        """Whether a hinge joins two links; MuJoCo forgets those whose other side never moves."""
        weld, parent = self.model.body_weldid, self.model.body_parentid
        return any(
            weld[parent[weld[one]]] == weld[other] for one, other in ((a, b), (b, a)) if weld[one]
        )

    def fixed_hit(self) -> tuple[str, str] | None:
        """Return a link that never moves and an obstacle or the floor that it penetrates."""
        model, static = self.model, np.flatnonzero(self.model.body_weldid == 0)
        geoms = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in set(static)]
        links = [g for g in geoms if self._owner[g] == SHARED]
        for a in links:
            for b in (g for g in geoms if self._owner[g] == WORLD):
                gap = self._mujoco.mj_geomDistance(model, self.data, a, b, 1.0, None)
                if gap < 0.0:
                    return self._name(a), self._name(b)
        return None

    @cached_property
    def _solid(self) -> list[int]:
        """The geoms of the hand that collide."""
        hand = self._owner > WORLD
        return np.flatnonzero(hand & (self.model.geom_contype > 0)).tolist()

    def solids(self) -> list[Array]:
        """Return per solid of a link points (p, 3) whose hull it is, in its own frame."""
        model, found = self.model, []
        for geom in self._solid:
            mesh = int(model.geom_dataid[geom])
            if mesh >= 0:
                first = int(model.mesh_vertadr[mesh])
                count = int(model.mesh_vertnum[mesh])
                found.append(np.array(model.mesh_vert[first : first + count], dtype=np.float64))
                continue
            sizes = model.geom_size[geom]
            long = model.geom_type[geom] == self._mujoco.mjtGeom.mjGEOM_CAPSULE
            found.append(capsule(float(sizes[0]), float(sizes[1]) if long else 0.0))
        return found

    def solid_poses(self) -> Array:
        """Return (s, 7), positions and quaternions (w, x, y, z) of the solids, as placed."""
        rows = []
        for geom in self._solid:
            quaternion = np.empty(4)
            self._mujoco.mju_mat2Quat(quaternion, self.data.geom_xmat[geom])
            rows.append(np.concatenate([self.data.geom_xpos[geom], quaternion]))
        return np.array(rows).reshape(-1, 7)

    def _name(self, geom: int) -> str:
        body = self.model.body(int(self.model.geom_bodyid[geom])).name
        return str(self.model.geom(geom).name if body == "world" else body.removeprefix(HAND))
