"""A hand as Pinocchio and coal see it: the door to both.

Planners use MuJoCo. Here the same file is read by another library: fingertips are where its forward
kinematics puts them, and its collision library says how deep links are in what they must not touch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import MissingExtraError
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.hand.spec import HandSpec


class SecondHand:
    """A hand among an object and obstacles.

    Args:
        spec: the hand.
        body: the object.
        obstacles: fixed bodies, world frame.
        floor: whether z < 0 is solid.

    Raises:
        MissingExtraError: Pinocchio is not installed.
    """

    def __init__(self, spec: HandSpec, body: Body, obstacles: Sequence[Body], floor: bool) -> None:
        try:
            import coal
            import pinocchio
        except ModuleNotFoundError as error:
            raise MissingExtraError("Pinocchio", "hand") from error
        self._coal, self._pin, self.spec = coal, pinocchio, spec
        model = self._model = self._read()
        self._data = model.createData()
        self._places = pinocchio.GeometryData(self._shapes)
        self._columns = [model.joints[model.getJointId(name)].idx_q for name in spec.joints]
        self._speeds = [model.joints[model.getJointId(name)].idx_v for name in spec.joints]
        self._tips = [model.getFrameId(tip.link, pinocchio.FrameType.BODY) for tip in spec.tips]
        self._base = pinocchio.SE3(spec.base.rotation, spec.base.position)
        self._object = [self._convex(piece.vertices) for piece in body.pieces]
        parts = [piece for obstacle in obstacles for piece in obstacle.pieces]
        self._fixed = [("an obstacle", self._convex(piece.vertices)) for piece in parts]
        if floor:
            self._fixed.append(("the floor", coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)))
        self._links = [self._link(shape) for shape in self._shapes.geometryObjects]
        self._pairs = list(self._apart())

    def _read(self) -> Any:
        """Return Pinocchio's model of the hand's file, and keep its shapes."""
        pin, spec, path = self._pin, self.spec, str(self.spec.path)
        if spec.text is None:
            model = pin.buildModelFromMJCF(path)
            self._shapes = pin.buildGeomFromMJCF(model, path, pin.COLLISION)
        else:
            model = pin.buildModelFromXML(spec.text)
            self._shapes = pin.buildGeomFromUrdfString(model, spec.text, pin.COLLISION)
        return model

    def _link(self, shape: Any) -> tuple[str, Any, int]:
        """Return a link's name, its shape, and which finger's tip it is (-1: none's)."""
        frame = self._model.frames[shape.parentFrame].name
        names = [tip.link for tip in self.spec.tips]
        geometry = shape.geometry
        if isinstance(geometry, self._coal.BVHModelBase):  # a shell: solid by its hull
            geometry.buildConvexHull(True, "Qt")
            geometry = geometry.convex
        return frame, geometry, names.index(frame) if frame in names else -1

    def _convex(self, points: Array) -> Any:
        shell = self._coal.BVHModelOBBRSS()
        shell.beginModel(0, len(points))
        shell.addVertices(np.ascontiguousarray(points))
        shell.endModel()
        shell.buildConvexHull(True, "Qt")
        return shell.convex

    def _apart(self) -> Iterator[tuple[int, int]]:
        """Yield the pairs of links that no joint joins."""
        parents, shapes = self._model.parents, self._shapes.geometryObjects
        for b in range(len(shapes)):
            for a in range(b):
                i, j = shapes[a].parentJoint, shapes[b].parentJoint
                if i != j and parents[i] != j and parents[j] != i:
                    yield a, b

    def limits(self) -> tuple[Array, Array]:
        """Return the file's least and greatest angles, (k,) each."""
        model, columns = self._model, self._columns
        return model.lowerPositionLimit[columns], model.upperPositionLimit[columns]

    def place(self, q: Array) -> None:
        """Put the hinges (k,) where they are asked for."""
        whole = self._whole = self._pin.neutral(self._model)
        whole[self._columns] = q
        self._pin.framesForwardKinematics(self._model, self._data, whole)
        self._pin.updateGeometryPlacements(self._model, self._data, self._shapes, self._places)

    def tips(self) -> Array:
        """Return the fingertips' centres (n, 3), world frame, as placed."""
        return np.array([
            (self._base * self._data.oMf[frame]).act(tip.offset)
            for frame, tip in zip(self._tips, self.spec.tips, strict=True)
        ])  # fmt: skip

    def weight(self, gravity: float) -> Array:
        """Return (k,), the torques that hold the links up against ``gravity`` [m/s^2]."""
        self._model.gravity.linear = self._base.rotation.T @ np.array([0.0, 0.0, -gravity])
        whole = self._pin.computeGeneralizedGravity(self._model, self._data, self._whole)
        return np.array(whole[self._speeds])

    def levers(self, points: Array) -> Array:
        """Return (n, 6, k), torques per unit of force and moment of fingertips at their points.

        Points (n, 3), forces and moments are in the world frame.
        """
        pin, turn = self._pin, self._base.rotation
        pin.computeJointJacobians(self._model, self._data, self._whole)
        pin.updateFramePlacements(self._model, self._data)
        found = []
        for frame, point in zip(self._tips, points, strict=True):
            rows = pin.getFrameJacobian(
                self._model, self._data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )[:, self._speeds]
            linear, angular = turn @ rows[:3], turn @ rows[3:]
            origin = self._base.act(self._data.oMf[frame].translation)
            moved = np.cross(angular, point - origin, axisa=0, axisc=0)
            found.append(np.vstack([linear + moved, angular]))
        return np.array(found)

    def deepest(self, pose: Pose, touch: Array) -> tuple[float, str]:
        """Return how deep bodies are in each other, as placed, beyond what is allowed, and which.

        Args:
            pose: where the object is.
            touch: (n,), how deep a fingertip's link may be in the object.
        """
        at = [self._base * place for place in self._places.oMg]
        here, there = self._pin.SE3(pose.rotation, pose.position), self._pin.SE3.Identity()
        worst = (-np.inf, "")
        for (name, shape, tip), where in zip(self._links, at, strict=True):
            allowed = touch[tip] if tip >= 0 else 0.0
            for piece in self._object:
                depth = self._depth(shape, where, piece, here) - allowed
                worst = max(worst, (depth, f"{name} in the object"))
            for other, fixed in self._fixed:
                worst = max(worst, (self._depth(shape, where, fixed, there), f"{name} in {other}"))
        for a, b in self._pairs:
            depth = self._depth(self._links[a][1], at[a], self._links[b][1], at[b])
            worst = max(worst, (depth, f"{self._links[a][0]} in {self._links[b][0]}"))
        return worst

    def _depth(self, a: Any, at_a: Any, b: Any, at_b: Any) -> float:
        request, result = self._coal.DistanceRequest(), self._coal.DistanceResult()
        request.enable_signed_distance = True
        places = [self._coal.Transform3s(at.rotation, at.translation) for at in (at_a, at_b)]
        return -float(self._coal.distance(a, places[0], b, places[1], request, result))
