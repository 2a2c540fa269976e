"""A world whose fingertips belong to a robot hand: hinges, motors, links that can hit things."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.hand.parsing import parsed
from gm_ompl.hand.scene import HAND
from gm_ompl.hand.spec import HandSpec
from gm_ompl.simulation.physics import CONTACT, IMPEDANCE, Physics, contact_of, load, mjcf
from gm_ompl.simulation.world import Bodies

HOLD: Final = 1.0
"""Stiffness that keeps a hinge near its planned angle, in its motor's torque per rad: so weak that
a millimetre's error changes no fingertip's force by more than some percent, and enough to keep an
arm's shape, which fingertips leave open."""

CALM: Final = 0.05
"""Damping beside it, in its motor's torque per rad/s."""


ROTOR: Final = 5e-3
"""A motor's inertia behind its gear, in kg m^2 per N m, where the file states less."""


@final
class Robot(Physics):
    """A robot hand among object, floor and obstacles.

    A fingertip's force becomes torques by its Jacobian's transpose, weight and Coriolis forces are
    compensated, and a weak impedance holds each hinge at its planned angle; motors give what they
    can and no more. Fingertips are spheres fixed to their links; other links collide with all.

    Args:
        world: with a hand.
        position: (3,), where the object begins.
        quaternion: (4,), how it is turned (w, x, y, z).
        joints: (k,), where the hinges begin.

    Attributes:
        used: (k,), the greatest torque so far, over the motor's.
        touched: bodies that links other than fingertips touched so far, as pairs of names.
    """

    def __init__(self, world: Bodies, position: Array, quaternion: Array, joints: Array) -> None:
        assert world.hand is not None
        model = _model(load(), world, world.hand)
        super().__init__(world, model, int(model.jnt_qposadr[model.body("object").jntadr[0]]))
        spec, self._spec = world.hand, world.hand
        self._rows = np.array([model.joint(HAND + name).qposadr[0] for name in spec.joints])
        self._columns = np.array([model.joint(HAND + name).dofadr[0] for name in spec.joints])
        self._tips = [model.geom(f"tip{i}").id for i in range(len(world.radius))]
        self._jacobian = np.zeros((len(self._tips), 3, model.nv))
        self._aim, self._rate = joints, np.zeros(len(joints))
        self._lever, self._arms = np.zeros_like(self._jacobian), np.zeros((len(self._tips), 3))
        self._links = self._geoms < 0
        self._links &= [model.body(b).name.startswith(HAND) for b in model.geom_bodyid]
        self.used, self.touched = np.zeros(len(joints)), set[tuple[str, str]]()
        self.data.qpos[self._rows] = joints
        self.put(position, quaternion)
        self._mujoco.mj_forward(model, self.data)
        self._look()

    def _look(self) -> None:
        """Compute how fingertips' centres and points of contact move with the hinges."""
        model, data = self.model, self.data
        for i, geom in enumerate(self._tips):
            body, centre = int(model.geom_bodyid[geom]), data.geom_xpos[geom]
            self._mujoco.mj_jac(model, data, self._jacobian[i], None, centre, body)
            self._mujoco.mj_jac(model, data, self._lever[i], None, centre + self._arms[i], body)

    @property
    def centres(self) -> Array:
        """(n, 3), the fingertips' centres."""
        return np.array(self.data.geom_xpos[self._tips])

    @property
    def velocities(self) -> Array:
        """(n, 3), of the fingertips' centres."""
        return np.asarray(self._jacobian @ self.data.qvel)

    def aim(self, joints: Array, rate: Array, arms: Array) -> None:
        """Say where the hinges should be, (k,), and how fast they should turn [rad/s].

        Forces act at ``arms`` (n, 3) from the fingertips' centres [m], world frame: where they
        touch. A finger of three hinges cannot choose the moment of a force on its fingertip.
        """
        self._aim, self._rate, self._arms = joints, rate, arms

    def step(
        self, forces: Array, quaternion: Array, spin: Array, wrench: Array | None = None
    ) -> None:
        """Do as ``Physics`` says; fingertips turn with their links."""
        del quaternion, spin
        data, most = self.data, self._spec.torque
        off = self._aim - data.qpos[self._rows]
        slower = self._rate - data.qvel[self._columns]
        torque = data.qfrc_bias[self._columns] + most * (HOLD * off + CALM * slower)
        torque += np.einsum("ijk,ij->k", self._lever[:, :, self._columns], forces)
        data.qfrc_applied[self._columns] = np.clip(torque, -most, most)
        self.used = np.maximum(self.used, np.abs(torque) / most)
        self.disturb(wrench)
        self._mujoco.mj_step(self.model, data)
        self._look()
        if data.ncon:
            self._note()

    def _note(self) -> None:
        """Note which links other than fingertips touch what."""
        pairs = self.data.contact.geom
        for pair in pairs[self._links[pairs].any(axis=1)].tolist():
            names = sorted(self._name(geom) for geom in pair)
            self.touched.add((names[0], names[1]))

    def _name(self, geom: int) -> str:
        body = self.model.body(int(self.model.geom_bodyid[geom])).name
        return str(self.model.geom(geom).name if body == "world" else body.removeprefix(HAND))


def _model(library: Any, world: Bodies, hand: HandSpec) -> Any:
    """Return the compiled world with the hand in it."""
    empty, places = np.zeros(0), np.zeros((0, 3))
    none = replace(world, radius=empty, friction=empty, soft=empty, offset=places)
    scene = library.MjSpec.from_string(mjcf(none))
    for geom in scene.geoms:
        geom.contype, geom.conaffinity = 2, 0
    base = scene.worldbody.add_frame(pos=hand.base.position, quat=hand.base.quaternion())
    robot = parsed(hand.path, hand.text)
    tips = {tip.link for tip in hand.tips}
    for geom in robot.geoms:
        solid = (geom.contype or geom.conaffinity) and geom.parent.name not in tips
        geom.contype, geom.conaffinity = (1, 3) if solid else (0, 0)
    scene.attach(robot, prefix=HAND, frame=base)
    for i, (tip, radius) in enumerate(zip(hand.tips, world.radius.tolist(), strict=True)):
        scene.body(HAND + tip.link).add_geom(
            name=f"tip{i}", type=library.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0],
            pos=tip.offset, contype=0, conaffinity=0, mass=0.0,
        )  # fmt: skip
        for k in range(len(world.pieces)):
            contact = contact_of(float(world.friction[i]), float(world.soft[i]))
            _pair(scene, f"piece{k}", f"tip{i}", contact)
    for body in scene.bodies:  # a hinge's two links overlap; MuJoCo forgets it where one is fixed
        if body.name.startswith(HAND) and body.parent.name.startswith(HAND):
            scene.add_exclude(bodyname1=body.parent.name, bodyname2=body.name)
    model = scene.compile()
    for name, torque in zip(hand.joints, hand.torque.tolist(), strict=True):
        dof = model.joint(HAND + name).dofadr
        model.dof_armature[dof] = np.maximum(model.dof_armature[dof], ROTOR * torque)
    return model


def _pair(scene: Any, piece: str, tip: str, contact: tuple[int, list[float]]) -> None:
    """Let a fingertip touch a piece of the object as free fingertips do (``physics``)."""
    scene.add_pair(
        geomname1=piece, geomname2=tip, condim=contact[0], friction=contact[1],
        solref=[float(x) for x in CONTACT.split()], solimp=[float(x) for x in IMPEDANCE.split()],
    )  # fmt: skip
