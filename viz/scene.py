"""The scene as meshcat's messages: the only import of meshcat.

Nothing is sent anywhere: a ``Recorder`` stands in for meshcat's window and keeps the packed
messages, which a page then hands to meshcat's viewer in order. Nodes carry fixed names; nothing a
user wrote is in them.

Below ``/meshcat/world`` lengths and coordinates are the plan's own, world frame; the node itself
holds the map to meshcat's units, in which every scene is about ``VIEW_SIZE`` across.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import MissingExtraError
from gm_ompl.geometry.solids import Body

from . import palette
from .animation import Animation
from .region import View, clipped, edges_of, neighbourhood, triangles_of, viewpoint

with warnings.catch_warnings():
    # meshcat's server, unused here, imports a deprecated part of pyzmq.
    warnings.simplefilter("ignore", DeprecationWarning)
    try:
        import meshcat
        import meshcat.geometry as g
    except ImportError as missing:
        raise MissingExtraError("meshcat", "view") from missing
    import umsgpack  # meshcat's own

VIEW_SIZE: Final = 3.0
"""Diagonal of the region in meshcat's units; its camera and lights are made for a few units."""

ARROW: Final = 0.5  # length of an arrow's shaft at f_max, in D
FIELD_OF_VIEW: Final = 40.0  # vertical field of view of the camera [deg]


class Recorder:
    """Keeps the messages that a ``meshcat.Visualizer`` sends.

    Attributes:
        messages: packed, in order.
        web_url: meshcat asks for it; there is no server.
    """

    web_url = ""

    def __init__(self) -> None:
        self.messages: list[bytes] = []

    def send(self, command: Any) -> None:
        """Keep ``command``."""
        self.messages.append(umsgpack.packb(command.lower()))


@dataclass(frozen=True, eq=False)
class SceneMessages:
    """Everything that the viewer needs to draw the scene."""

    messages: tuple[bytes, ...]  # packed for meshcat's ``handle_command_bytearray``, in order
    camera: tuple[bytes, ...]  # likewise: from where to look at it
    scale: float  # meshcat units per unit of length
    centre: Array  # (3,), the world point at meshcat's origin
    arrow: float  # length of an arrow's shaft at f_max
    slots: int  # number of contact markers
    # of each node ``obstacle0``, ``obstacle1``, ...: whose part it is, its middle (3,)
    parts: tuple[tuple[int, Array], ...]


def visualizer(recorder: Recorder) -> Any:
    """Return a ``meshcat.Visualizer`` before a pale sky, whose messages ``recorder`` keeps."""
    view = meshcat.Visualizer(window=recorder)
    view["/Background"].set_property("top_color", [1.0, 1.0, 1.0])
    view["/Background"].set_property("bottom_color", [0.86, 0.89, 0.93])
    return view


def viewer_script() -> str:
    """Return the source of meshcat's viewer, three.js included."""
    path = files("meshcat") / "viewer" / "dist" / "main.min.js"
    return path.read_text(encoding="utf-8")


def scene_messages(animation: Animation, around: View | None = None) -> SceneMessages:
    """Return the scene of ``animation``, nothing yet posed but what never moves.

    Args:
        animation: the plan.
        around: what must be drawn besides the neighbourhood of the plan.
    """
    region = neighbourhood(animation)
    if around is not None:
        region = region.with_(around)
    recorder, looking = Recorder(), Recorder()
    view = visualizer(recorder)
    scale = VIEW_SIZE / region.diagonal
    world = view["world"]
    world.set_transform(similarity(scale, -scale * region.centre))
    for helper in ("/Grid", "/Axes"):
        view[helper].set_property("visible", False)
    parts = _surroundings(world, animation, region)
    _body(world["object"], animation.problem.body)
    diagonal = animation.problem.body.diagonal
    slots = max((len(segment.contacts.points) for segment in animation.segments), default=0)
    for k in range(slots):
        _contact_marker(world[f"object/contact{k}"], diagonal)
    arrow = ARROW * diagonal
    for i, radius in enumerate(animation.problem.fingers.radius.tolist()):
        _fingertip(world[f"object/finger{i}"], radius, diagonal)
    _links(world, animation)
    _camera(meshcat.Visualizer(window=looking), animation)
    return SceneMessages(
        messages=tuple(recorder.messages),
        camera=tuple(looking.messages),
        scale=scale,
        centre=region.centre,
        arrow=arrow,
        slots=slots,
        parts=parts,
    )


def similarity(scale: float, offset: Array) -> Array:
    """Return the transform (4, 4) that scales and then moves."""
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = offset
    return matrix


def _translation(offset: Any) -> Array:
    return similarity(1.0, np.asarray(offset))


def _surroundings(world: Any, animation: Animation, region: View) -> tuple[tuple[int, Array], ...]:
    """Draw floor and obstacles; return of each obstacle's node whose part it is, and its middle."""
    if animation.problem.environment.floor:
        size = region.high - region.low
        thickness = 0.01 * region.diagonal
        slab = [float(size[0]), float(size[1]), thickness]
        node = world["floor"]
        node.set_object(g.Box(slab), g.MeshLambertMaterial(color=palette.FLOOR))
        node.set_transform(_translation([*region.centre[:2], -0.6 * thickness]))
    drawn: list[tuple[int, Array]] = []
    for k, obstacle in enumerate(animation.problem.environment.obstacles):
        for piece in obstacle.body.pieces:
            part = clipped(piece, region)
            if part is not None:
                node, middle = world[f"obstacle{len(drawn)}"], part.vertices.mean(axis=0)
                node.set_transform(_translation(middle))  # numbers are small wherever it lies
                draw_piece(node, part.faces, part.vertices - middle, palette.OBSTACLE, 0.22)
                drawn.append((k, middle))
    return tuple(drawn)


def draw_piece(node: Any, faces: Any, corners: Array, colour: int, opacity: float) -> None:
    """Draw a convex piece, its faces given as rows of ``corners`` (v, 3), and its edges."""
    draw_solid(node, triangles_of(faces, corners), edges_of(faces, corners), colour, opacity)


def _body(node: Any, body: Body) -> None:
    if body.surface:
        triangles = np.concatenate([face.triangles for face in body.surface])
        rims = np.concatenate([face.rim for face in body.surface])
        draw_solid(node, triangles, rims, palette.OBJECT, 0.84)
        return
    for k, piece in enumerate(body.pieces):
        draw_piece(node[f"piece{k}"], piece.faces, piece.vertices, palette.OBJECT, 0.84)


def draw_solid(node: Any, triangles: Array, edges: Array, colour: int, opacity: float) -> None:
    """Draw triangles (t, 3, 3), each flat, and edges (e, 2, 3)."""
    corners = triangles.reshape(-1, 3)
    mesh = g.TriangularMeshGeometry(corners, np.arange(len(corners)).reshape(-1, 3))
    see_through = opacity < 0.5
    material = g.MeshLambertMaterial(
        color=colour,
        opacity=opacity,
        transparent=opacity < 1.0,
        depthWrite=not see_through,
        polygonOffset=True,  # faces yield to the edges drawn on them
        polygonOffsetFactor=1,
        polygonOffsetUnits=1,
    )
    node["solid"].set_object(mesh, material)
    node["edges"].set_object(_lines(edges, palette.OBSTACLE if see_through else palette.EDGE))


def draw_coloured(node: Any, corners: Array, triangles: IntArray, colours: Array) -> None:
    """Draw triangles (t, 3), rows of ``corners`` (v, 3), each corner with its colour (v, 3)."""
    mesh = g.TriangularMeshGeometry(corners, triangles, color=colours)
    node.set_object(g.Mesh(mesh, g.MeshBasicMaterial(vertexColors=True, side=2)))


def _lines(edges: Array, colour: int) -> Any:
    points = g.PointsGeometry(edges.reshape(-1, 3).T.astype(np.float32))
    return g.LineSegments(points, g.LineBasicMaterial(color=colour))


def _links(world: Any, animation: Animation) -> None:
    """Draw the solids of a hand's links, each a node of its own."""
    for k, look in enumerate(animation.links):
        node = world[f"link{k}"]
        draw_solid(node, look.triangles, np.zeros((0, 2, 3)), palette.LIFTED, 0.95)


def _contact_marker(node: Any, diagonal: float) -> None:
    """Draw both looks of a contact: static (a cube) and sliding (a ball)."""
    side = 0.03 * diagonal
    node["static"].set_object(g.Box([side] * 3), g.MeshBasicMaterial(color=palette.STATIC))
    node["sliding"].set_object(g.Sphere(0.75 * side), g.MeshBasicMaterial(color=palette.SLIDING))
    node.set_property("visible", False)


def _fingertip(node: Any, radius: float, diagonal: float) -> None:
    """Draw the three looks of a fingertip; its z axis points into the object."""
    paint = {
        "position": g.MeshLambertMaterial(color=palette.POSITION),
        "force": g.MeshLambertMaterial(color=palette.FORCE),
        "lifted": g.MeshLambertMaterial(color=palette.LIFTED, opacity=0.55),
    }
    for look, material in paint.items():
        node[look]["ball"].set_object(g.Sphere(radius), material)
    cube = edges_of(_CUBE, 1.08 * radius * _CORNERS)
    node["position"]["frame"].set_object(_lines(cube, palette.POSITION))
    ring = node["force"]["ring"]
    ring.set_object(g.Cylinder(0.3 * radius, 1.22 * radius), paint["force"])
    ring.set_transform(_upright(np.zeros(3)))
    _arrow(node["force"]["arrow"], radius, diagonal)
    for look in ("force", "lifted"):
        node[look].set_property("visible", False)


def _arrow(node: Any, radius: float, diagonal: float) -> None:
    """Draw an arrow that ends at the fingertip's back; the page scales its shaft along z."""
    thick = min(0.25 * radius, 0.03 * diagonal)
    head = 3.0 * thick
    ink = g.MeshLambertMaterial(color=palette.FORCE)
    # three.js cylinders stand along y, their top towards +y.
    node["head"].set_object(g.Cylinder(head, radiusTop=0.0, radiusBottom=2.0 * thick), ink)
    node["head"].set_transform(_upright([0.0, 0.0, -1.1 * radius - 0.5 * head]))
    foot = node["shaft"]
    foot.set_transform(_translation([0.0, 0.0, -1.1 * radius - head]))
    foot["rod"].set_object(g.Cylinder(1.0, thick), ink)
    foot["rod"].set_transform(_upright([0.0, 0.0, -0.5]))


def _upright(offset: Any) -> Array:
    """Return the transform that turns the y axis to z and moves by ``offset``."""
    matrix = _translation(offset)
    matrix[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    return matrix


_CORNERS: Final = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_CUBE: Final = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6))


def _camera(view: Any, animation: Animation) -> None:
    direction = viewpoint(animation)
    distance = 0.5 * VIEW_SIZE / np.tan(np.deg2rad(0.5 * FIELD_OF_VIEW))
    x, y, z = distance * direction
    camera = view["/Cameras/default/rotated/<object>"]
    camera.set_property("fov", FIELD_OF_VIEW)
    camera.set_property("position", [float(x), float(z), float(-y)])  # its frame has y up
