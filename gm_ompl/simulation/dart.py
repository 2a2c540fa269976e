"""The door to DART: a second opinion on an execution, with rigid contacts."""

from __future__ import annotations

import tempfile
from contextlib import AbstractContextManager
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from gm_ompl.arrays import Array
from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.simulation.engine import STEP, TIP_INERTIA, TIP_MASS
from gm_ompl.simulation.world import Bodies, box_of

TWISTED = 2e-3  # turned by this about its normal, a soft fingertip holds as fast as it can [rad]
QUICKEST = 0.1  # of a twisting fingertip, with the object on it: radians of its swing per time step

GRIP = 1e3  # friction of the object itself: of two surfaces in contact the smoother one counts


def load() -> Any:
    """Import dartpy.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import dartpy
    except ModuleNotFoundError as error:
        raise MissingExtraError("dartpy", "sim2") from error
    return dartpy


class Dart:
    """A world in motion, as ``Engine`` describes it.

    Args:
        world: the bodies.
        position: (3,), where the object begins.
        quaternion: (4,), how it is turned (w, x, y, z).
        centres: (n, 3), where the fingertips begin.
    """

    def __init__(self, world: Bodies, position: Array, quaternion: Array, centres: Array) -> None:
        self._dart, self.world = load(), world
        self._simulated = self._dart.simulation.World()
        self._begin()
        self._object, joint = self._free("object", world.mass, world.inertia, world.centre)
        placed = self._dart.math.Isometry3()
        placed.set_quaternion(self._dart.math.Quaternion(*quaternion.tolist()))
        placed.set_translation(position)
        joint.setTransform(placed)
        for vertices in world.pieces:
            self._touch(self._object, self._solid(vertices), GRIP)
        fixed = self._environment()
        self._tips, self._joints = [], []
        self._spheres: dict[Any, int] = {}
        for i, centre in enumerate(centres):
            tip, joint = self._free(f"tip{i}", TIP_MASS, TIP_INERTIA * np.eye(3), np.zeros(3))
            tip.setGravityMode(False)
            placed = self._dart.math.Isometry3()
            placed.set_translation(centre)
            joint.setTransform(placed)
            sphere = self._dart.dynamics.SphereShape(float(world.radius[i]))
            surface = self._touch(tip, (sphere, np.zeros(3)), float(world.friction[i]))
            self._spheres[surface] = i
            self._tips.append(tip)
            self._joints.append(joint)
        self._pass_through([*self._tips, *fixed])
        self._twist = np.zeros(len(self._tips))  # how far soft fingertips are twisted [rad]

    def _begin(self) -> None:
        dart, simulated = self._dart, self._simulated
        simulated.setTimeStep(STEP)
        simulated.setGravity([0.0, 0.0, -self.world.gravity])
        asleep = simulated.getDeactivationOptions()
        asleep.mEnabled = False  # what rests is watched as well
        simulated.setDeactivationOptions(asleep)
        # Of DART's detectors those that find all corners of faces that touch. ODE's loses boxes
        # that are turned by a hair, DART's own knows boxes and spheres alone.
        solids = [*self.world.pieces, *self.world.obstacles]
        boxes = all(box_of(vertices) is not None for vertices in solids)
        detector = (
            dart.collision.DARTCollisionDetector if boxes else dart.collision.OdeCollisionDetector
        )
        simulated.setCollisionDetector(detector())
        # Coulomb's cones themselves; the usual solver has pyramids along the axes.
        solver = dart.constraint.NsgsFrictionSolver()
        simulated.getConstraintSolver().setBoxedLcpSolver(solver)

    def _free(self, name: str, mass: float, inertia: Array, centre: Array) -> tuple[Any, Any]:
        """Return a new free body and its joint."""
        skeleton = self._dart.dynamics.Skeleton(name)
        joint, body = skeleton.createFreeJointAndBodyNodePair()
        body.setInertia(self._dart.dynamics.Inertia(float(mass), centre, inertia))
        self._simulated.addSkeleton(skeleton)
        return body, joint

    def _environment(self) -> list[Any]:
        """Add what does not move; return its bodies."""
        world, solids = self.world, [self._solid(vertices) for vertices in self.world.obstacles]
        if world.floor:
            side = 80.0 * world.size
            slab = self._dart.dynamics.BoxShape([side, side, world.size])
            solids.append((slab, np.array([0.0, 0.0, -world.size / 2.0])))
        bodies = []
        for k, solid in enumerate(solids):
            skeleton = self._dart.dynamics.Skeleton(f"fixed{k}")
            _, body = skeleton.createWeldJointAndBodyNodePair()
            self._touch(body, solid, world.environment_friction)
            skeleton.setMobile(False)
            self._simulated.addSkeleton(skeleton)
            bodies.append(body)
        return bodies

    def _touch(self, body: Any, solid: tuple[Any, Array], friction: float) -> Any:
        """Give ``body`` a surface; return it."""
        shape, offset = solid
        node = body.createShapeNode(shape)
        node.setRelativeTranslation(offset)
        node.createCollisionAspect()
        node.createDynamicsAspect().setFrictionCoeff(friction)
        return node

    def _pass_through(self, bodies: list[Any]) -> None:
        """Keep all but the object from touching each other."""
        # The option is a copy, its filter the solver's own: a filter put in its place is lost.
        apart = self._simulated.getConstraintSolver().getCollisionOption().collisionFilter
        for one, other in combinations(bodies, 2):
            apart.addBodyNodePairToBlackList(one, other)

    def _solid(self, vertices: Array) -> tuple[Any, Array]:
        """Return a convex piece's shape and where its middle is."""
        box = box_of(vertices)
        if box is not None:
            low, high = box
            return self._dart.dynamics.BoxShape(high - low), (low + high) / 2.0
        # Meshes come into DART by files alone.
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "piece.obj"
            path.write_text(_wavefront(vertices), encoding="ascii")
            robot = (
                '<robot name="piece"><link name="piece"><collision><geometry>'
                f'<mesh filename="{path.as_uri()}"/></geometry></collision></link></robot>'
            )
            loader = self._dart.utils.DartLoader()
            piece = loader.parseSkeletonString(robot, "file:///")
            return piece.getBodyNode(0).getShapeNode(0).getShape(), np.zeros(3)

    @property
    def position(self) -> Array:
        """(3,), the object's centre of mass as modelled: the origin of its frame."""
        return np.array(self._object.getTransform().translation())

    @property
    def quaternion(self) -> Array:
        """(4,), the object's orientation (w, x, y, z)."""
        return np.array(self._object.getTransform().quaternion().wxyz())

    @property
    def centres(self) -> Array:
        """(n, 3), the fingertips' centres."""
        places = [tip.getTransform().translation() for tip in self._tips]
        return np.array(places).reshape(-1, 3)

    @property
    def velocities(self) -> Array:
        """(n, 3), of the fingertips' centres."""
        return np.array([tip.getLinearVelocity() for tip in self._tips]).reshape(-1, 3)

    def step(
        self, forces: Array, quaternion: Array, spin: Array, wrench: Array | None = None
    ) -> None:
        """Advance by one time step; see ``Engine``."""
        turn = self._dart.math.Quaternion(*quaternion.tolist()).to_rotation_matrix() @ spin
        for tip, joint, force in zip(self._tips, self._joints, forces, strict=True):
            # A sphere's orientation shows nowhere; only that it turns does.
            joint.setAngularVelocity(turn)
            tip.addExtForce(force)
        self._hold(turn)
        if wrench is not None:
            self._object.addExtForce(wrench[:3], np.zeros(3), False, True)
            self._object.addExtTorque(wrench[3:], False)
        self._simulated.step()

    def _hold(self, turn: Array) -> None:
        """Let soft fingertips that turn by (3,) [rad/s] hold the object about their normals.

        DART's contacts know no such moment: here it is a damped spring that slips at its limit.
        """
        world = self.world
        if not world.soft.any():
            return
        inertia = float(np.trace(world.inertia)) / 3.0
        stiffest = inertia * (QUICKEST / STEP) ** 2
        for i, force in enumerate(self._pushes()):
            size = float(np.linalg.norm(force))
            limit = float(world.friction[i] * world.soft[i]) * size
            if limit == 0.0:
                self._twist[i] = 0.0
                continue
            normal, k = force / size, min(limit / TWISTED, stiffest)
            spin = float(normal @ (self._object.getAngularVelocity() - turn))
            damping = 2.0 * np.sqrt(k * inertia) * spin
            moment = np.clip(k * (self._twist[i] + spin * STEP) + damping, -limit, limit)
            self._twist[i] = (moment - damping) / k
            self._object.addExtTorque(-moment * normal, False)

    def _pushes(self) -> Array:
        """Return (n, 3), each fingertip's normal force on the object in the last step [N]."""
        pushes = np.zeros((len(self._tips), 3))
        for contact in self._simulated.getLastCollisionResult().getContacts():
            for side in (contact.collisionObject1, contact.collisionObject2):
                i = self._spheres.get(side.getShapeFrame())
                if i is not None:
                    pushes[i] += abs(float(contact.force @ contact.normal)) * contact.normal
        return pushes

    def normal_forces(self) -> Array:
        """Return (n,), each fingertip's normal force on the object in the last step [N]."""
        forces: Array = np.linalg.norm(self._pushes(), axis=1)
        return forces

    def state(self) -> Array:
        """Return everything that the future depends on."""
        bodies = [self._object, *self._tips]
        moving = [body.getSkeleton() for body in bodies]
        parts = [[*one.getPositions(), *one.getVelocities()] for one in moving]
        return np.concatenate([np.ravel(parts), self._twist])

    def restore(self, state: Array) -> None:
        """Go back to a former ``state``."""
        bodies = [self._object, *self._tips]
        parts = state[: 12 * len(bodies)].reshape(len(bodies), 2, 6)
        for body, (place, velocity) in zip(bodies, parts, strict=True):
            body.getSkeleton().setPositions(place)
            body.getSkeleton().setVelocities(velocity)
        self._twist = state[12 * len(bodies) :].copy()

    def camera(self, *_: Any) -> AbstractContextManager[Any]:
        """Refuse: films are MuJoCo's.

        Raises:
            InputError: always.
        """
        raise InputError("--video: DART's executions are not filmed; leave --engine away")


def _wavefront(vertices: Array) -> str:
    """Return the hull of ``vertices`` (v, 3) as an OBJ file, its faces seen from outside."""
    hull = ConvexHull(vertices)
    lines = ["v {!r} {!r} {!r}".format(*vertex) for vertex in vertices.tolist()]
    for face, outward in zip(hull.simplices, hull.equations[:, :3], strict=True):
        a, b, c = vertices[face]
        order = face if np.cross(b - a, c - a) @ outward > 0.0 else face[::-1]
        lines.append("f {} {} {}".format(*(order + 1).tolist()))
    return "\n".join(lines) + "\n"
