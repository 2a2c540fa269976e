"""The door to MuJoCo: bodies that touch with exact friction, stepped and rendered."""

from __future__ import annotations

import os
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, final
from xml.sax.saxutils import quoteattr

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import MissingExtraError
from gm_ompl.simulation.engine import STEP, TIP_INERTIA, TIP_MASS
from gm_ompl.simulation.world import Bodies, box_of

CONTACT = "0.001 1"
"""Time constant [s] and damping ratio of a contact: two time steps, critically damped."""

IMPEDANCE = "0.2 0.9 0.0002 0.5 2"
"""Contacts yield softly at first and are rigid from a fifth of a millimetre on: an edge that sinks
in deeper leaves its load to the fingers. A sliding contact that is rigid from the beginning hops:
the solver's friction pushes it up, off, and it falls back."""

SLIP_SWEEPS = 20  # sweeps of the solver that removes the creep of static contacts

FRICTION_RATIO = 1.0
"""Friction is held as stiffly as normal forces; what creeps is the sweeps' to remove."""


def load() -> Any:
    """Import MuJoCo, set up to render without a display.

    Raises:
        MissingExtraError: it is not installed.
    """
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        import mujoco
    except ModuleNotFoundError as error:
        raise MissingExtraError("MuJoCo", "sim") from error
    # Its own way: a line on stderr and a file in whatever folder the user is in. What a simulation
    # comes to is judged and reported here.
    mujoco.set_mju_user_warning(_unheard)
    return mujoco


def _unheard(_: str) -> None:
    """Take a warning of MuJoCo's."""


class Physics(ABC):
    """A world in motion, as ``Engine`` describes it.

    Args:
        world: its bodies.
        model: MuJoCo's model of them; geometries "tip0", "tip1", ... are the fingertips.
        place: where the object's pose begins in ``qpos``.
    """

    def __init__(self, world: Bodies, model: Any, place: int) -> None:
        self._mujoco, self.world, self.model = load(), world, model
        self.data = self._mujoco.MjData(model)
        self._place = place
        self._body = int(model.body("object").id)
        self._wrench = self.data.xfrc_applied[self._body]
        self._geoms = np.full(model.ngeom, -1)
        for i in range(len(world.radius)):
            self._geoms[model.geom(f"tip{i}").id] = i

    def put(self, position: Array, quaternion: Array) -> None:
        """Put the object at ``position`` (3,), turned by ``quaternion`` (w, x, y, z)."""
        self.data.qpos[self._place : self._place + 7] = [*position, *quaternion]

    @property
    def position(self) -> Array:
        """(3,), the object's centre of mass as modelled: the origin of its frame."""
        return np.array(self.data.qpos[self._place : self._place + 3])

    @property
    def quaternion(self) -> Array:
        """(4,), the object's orientation (w, x, y, z)."""
        return np.array(self.data.qpos[self._place + 3 : self._place + 7])

    @property
    @abstractmethod
    def centres(self) -> Array:
        """(n, 3), the fingertips' centres."""

    @property
    @abstractmethod
    def velocities(self) -> Array:
        """(n, 3), of the fingertips' centres."""

    @abstractmethod
    def step(
        self, forces: Array, quaternion: Array, spin: Array, wrench: Array | None = None
    ) -> None:
        """Advance by one time step; see ``Engine``."""

    def disturb(self, wrench: Array | None) -> None:
        """Apply a wrench (6,) to the object in the next step, world frame, about its position."""
        self._wrench[:] = 0.0
        if wrench is not None:
            # MuJoCo's acts at the true centre of mass.
            arm = self.data.xipos[self._body] - self.data.xpos[self._body]
            self._wrench[:3], self._wrench[3:] = wrench[:3], wrench[3:] - np.cross(arm, wrench[:3])

    def normal_forces(self) -> Array:
        """Return (n,), each fingertip's normal force on the object in the last step [N]."""
        normal, contact = np.zeros(len(self.world.radius)), self.data.contact
        if self.data.ncon:
            tip = self._geoms[contact.geom].max(axis=1)
            rows = np.flatnonzero((tip >= 0) & (contact.efc_address >= 0))
            np.add.at(normal, tip[rows], self.data.efc_force[contact.efc_address[rows]])
        return normal

    def state(self) -> Array:
        """Return everything that the future depends on."""
        spec = self._mujoco.mjtState.mjSTATE_INTEGRATION
        state = np.empty(self._mujoco.mj_stateSize(self.model, spec))
        self._mujoco.mj_getState(self.model, self.data, state, spec)
        return state

    def restore(self, state: Array) -> None:
        """Go back to a former ``state``."""
        spec = self._mujoco.mjtState.mjSTATE_INTEGRATION
        self._mujoco.mj_setState(self.model, self.data, state, spec)
        self._mujoco.mj_forward(self.model, self.data)

    @contextmanager
    def camera(self, look_at: Array, width: int, height: int) -> Iterator[Any]:
        """Give a function that returns the view of ``look_at``, (height, width, 3) bytes."""
        view = self._mujoco.MjvCamera()
        view.lookat[:] = look_at
        view.distance, view.azimuth, view.elevation = 3.2 * self.world.size, 125.0, -20.0
        with self._mujoco.Renderer(self.model, height, width) as renderer:

            def picture() -> Any:
                renderer.update_scene(self.data, view)
                return renderer.render()

            yield picture


@final
class FreeTips(Physics):
    """A world whose fingertips belong to no robot.

    The object is free and begins at ``position`` (3,), turned by ``quaternion`` (w, x, y, z);
    the fingertips, from ``centres`` (n, 3) on, are free spheres that are pushed by forces and
    turned by decree. They touch the object alone: that their way is clear of everything else
    is the planner's business.
    """

    def __init__(self, world: Bodies, position: Array, quaternion: Array, centres: Array) -> None:
        n = len(world.radius)
        super().__init__(world, load().MjModel.from_xml_string(mjcf(world)), 0)
        self._q = self.data.qpos.reshape(1 + n, 7)
        self._v = self.data.qvel.reshape(1 + n, 6)
        self._push = self.data.xfrc_applied[-n:, :3] if n else np.zeros((0, 3))
        self.put(position, quaternion)
        self._q[1:, :3], self._q[1:, 3:] = centres, quaternion
        self._mujoco.mj_forward(self.model, self.data)

    @property
    def centres(self) -> Array:
        """(n, 3), the fingertips' centres."""
        return np.array(self._q[1:, :3])

    @property
    def velocities(self) -> Array:
        """(n, 3), of the fingertips' centres."""
        return np.array(self._v[1:, :3])

    def step(
        self, forces: Array, quaternion: Array, spin: Array, wrench: Array | None = None
    ) -> None:
        """Do as ``Physics`` says; fingertips are turned as they are told."""
        self._q[1:, 3:], self._v[1:, 3:] = quaternion, spin
        self._push[:] = forces
        self.disturb(wrench)
        self._mujoco.mj_step(self.model, self.data)


def mjcf(world: Bodies) -> str:
    """Return the world in MuJoCo's language."""
    meshes: list[str] = []
    fixed = []
    if world.floor:
        side = 40 * world.size
        fixed.append(f'<geom name="floor" type="plane" size="{side} {side} 1" material="floor"/>')
    for k, vertices in enumerate(world.obstacles):
        fixed.append(_geom(f"wall{k}", vertices, "0.6 0.6 0.65 0.35", meshes))
    own = [_geom(f"piece{k}", v, "0.8 0.6 0.35 1", meshes) for k, v in enumerate(world.pieces)]
    tips = [
        f'<body name="tip{i}" gravcomp="1"><freejoint/><inertial pos="0 0 0" mass="{TIP_MASS}" '
        f'diaginertia="{TIP_INERTIA} {TIP_INERTIA} {TIP_INERTIA}"/><geom name="tip{i}" '
        f'type="sphere" size="{radius!r}" rgba="{_COLOURS[i % len(_COLOURS)]}"/></body>'
        for i, radius in enumerate(world.radius.tolist())
    ]
    J = world.inertia
    six = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
    return f"""<mujoco>
<compiler angle="radian" inertiafromgeom="false" boundmass="0" boundinertia="0"/>
<option timestep="{STEP}" gravity="0 0 {-world.gravity}" cone="elliptic" impratio="{FRICTION_RATIO}"
  integrator="implicitfast" noslip_iterations="{SLIP_SWEEPS}" iterations="50" tolerance="1e-10">
  <flag multiccd="enable"/></option>
<default><geom contype="0" conaffinity="0"/></default>
<visual><global offwidth="1280" offheight="960"/><map znear="0.01" zfar="50"/>
  <headlight ambient="0.4 0.4 0.4"/></visual>
<statistic extent="{world.size}"/>
<asset><texture type="skybox" builtin="gradient" width="64" height="64"
  rgb1="0.9 0.93 0.97" rgb2="0.6 0.68 0.78"/>
  <texture name="floor" type="2d" builtin="checker" width="64" height="64"
  rgb1="0.85 0.87 0.9" rgb2="0.75 0.78 0.82"/>
  <material name="floor" texture="floor" texuniform="true" texrepeat="8 8"/>
  {"".join(meshes)}</asset>
<worldbody><light pos="0 0 {8 * world.size}" dir="0.2 0.3 -1" directional="true"/>{"".join(fixed)}
<body name="object"><freejoint/>
  <inertial pos="{_numbers(world.centre)}" mass="{world.mass!r}"
  fullinertia="{_numbers(np.array(six))}"/>
  {"".join(own)}</body>{"".join(tips)}</worldbody>
<contact>{"".join(_pairs(world))}</contact></mujoco>"""


def _geom(name: str, vertices: Array, colour: str, meshes: list[str]) -> str:
    """Return a convex piece's geometry; one that is no box adds its mesh to ``meshes``."""
    common, box = f'name="{name}" rgba="{colour}"', box_of(vertices)
    if box is not None:
        low, high = box
        return (
            f'<geom {common} type="box" pos="{_numbers((low + high) / 2)}" '
            f'size="{_numbers((high - low) / 2)}"/>'
        )
    meshes.append(f'<mesh name="{name}" vertex={quoteattr(_numbers(vertices))}/>')
    return f'<geom {common} type="mesh" mesh="{name}"/>'


def _pairs(world: Bodies) -> Iterator[str]:
    """Yield what may touch: the object's pieces and the environment, or a fingertip."""
    around = ["floor"] * world.floor + [f"wall{k}" for k in range(len(world.obstacles))]
    touching = [(other, *contact_of(world.environment_friction)) for other in around]
    touching += [
        (f"tip{i}", *contact_of(float(mu), float(L)))
        for i, (mu, L) in enumerate(zip(world.friction, world.soft, strict=True))
    ]
    for k in range(len(world.pieces)):
        for other, size, friction in touching:
            yield (
                f'<pair geom1="piece{k}" geom2="{other}" condim="{size}" solref="{CONTACT}" '
                f'solimp="{IMPEDANCE}" friction="{_numbers(np.array(friction))}"/>'
            )


def contact_of(mu: float, soft: float = 0.0) -> tuple[int, list[float]]:
    """Return MuJoCo's dimension and coefficients of a contact, that of a soft fingertip with L."""
    return (4 if soft else 3), [mu, mu, mu * soft, 0.0, 0.0]


_COLOURS = ("0.85 0.2 0.2 1", "0.2 0.4 0.85 1", "0.2 0.7 0.3 1", "0.8 0.5 0.1 1")


def _numbers(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values.ravel())
