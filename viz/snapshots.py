"""Small pictures of a plan's decisive moments: start, before and after each regrasp, goal.

An orthographic projection of its own, drawn back to front: no browser and no graphics card.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array, unit
from gm_ompl.geometry.pose import Pose

from . import palette
from .animation import Animation, ShownSegment
from .canvas import new_figure, title
from .region import View, clipped, neighbourhood, viewpoint

MOST: Final = 12
"""At most this many moments are drawn; of more regrasps the first are shown."""

COLUMNS: Final = 4
CELL: Final = 1.75
"""Width and height of one picture [inch]."""

ARROW: Final = 0.45
"""Length of an arrow at f_max, in D."""

LIGHT: Final = unit([0.4, -0.5, 0.8])


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture.

    Attributes:
        caption: what it shows.
        segment: the segment whose fingers, modes and forces are drawn; None without a plan.
        pose: (7,), of the object.
    """

    caption: str
    segment: ShownSegment | None
    pose: Array


def pictures(animation: Animation) -> list[Picture]:
    """Return start, before and after each regrasp, and goal."""
    if not animation.segments:
        return [Picture("start", None, animation.rest_pose())]
    found = [Picture("start", animation.segments[0], animation.segments[0].poses[0])]
    regrasp = 0
    for k, segment in enumerate(animation.segments):
        if not segment.regrasp:
            continue
        regrasp += 1
        before = next((b for b in animation.segments[k::-1] if not b.regrasp), segment)
        after = next((b for b in animation.segments[k:] if not b.regrasp), segment)
        found.append(Picture(f"before regrasp {regrasp}", before, segment.poses[0]))
        found.append(Picture(f"after regrasp {regrasp}", after, segment.poses[0]))
    last = animation.segments[-1]
    return [*found[: MOST - 1], Picture("goal", last, last.poses[-1])]


class Projection:
    """An orthographic view along ``-direction``, world up upwards.

    Attributes:
        direction: (3,), unit, towards the viewer.
    """

    def __init__(self, direction: Array) -> None:
        self.direction = direction
        across = unit(np.cross([0.0, 0.0, 1.0], direction))
        self._plane = np.stack([across, np.cross(direction, across)], axis=1)

    def flat(self, points: Array) -> Array:
        """Return the picture's coordinates (k, 2) of world points (k, 3)."""
        drawn: Array = points @ self._plane
        return drawn

    def depth(self, points: Array) -> float:
        """Return how near the points' middle is to the viewer."""
        return float(points.mean(axis=0) @ self.direction)


def snapshots_figure(animation: Animation) -> Any:
    """Return the figure of a plan's decisive moments."""
    from matplotlib.lines import Line2D

    shown = pictures(animation)
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    view, region = Projection(viewpoint(animation)), neighbourhood(animation)
    corners = np.array(np.meshgrid(*zip(region.low, region.high, strict=True))).reshape(3, -1).T
    frame = view.flat(corners)
    width, height = np.ptp(frame, axis=0)
    figure = new_figure(CELL * columns, (CELL * height / width + 0.22) * rows + 0.5)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    figure.suptitle(title(animation.name, 24 * columns), fontsize=8, parse_math=False)
    for ax, picture in zip(axes, shown, strict=False):
        _draw(ax, animation, view, region, picture)
        ax.set_title(picture.caption, fontsize=7)
        ax.set_xlim(frame[:, 0].min(), frame[:, 0].max())
        ax.set_ylim(frame[:, 1].min(), frame[:, 1].max())
    for ax in axes:
        ax.set_aspect("equal")
        ax.set_axis_off()
    looks = (("position control", "s", palette.POSITION), ("force control", "o", palette.FORCE))
    figure.legend(
        handles=[
            Line2D([], [], linestyle="", marker=marker, color=palette.css(colour), label=label)
            for label, marker, colour in looks
        ],
        loc="outside lower center", ncols=2, frameon=False,
    )  # fmt: skip
    return figure


def _draw(ax: Any, animation: Animation, view: Projection, region: View, picture: Picture) -> None:
    pose = Pose.from_quaternion(picture.pose[:3], picture.pose[3:])
    depth = view.depth(pose.position[None])
    _environment(ax, animation, view, region, depth, behind=True)
    segment = picture.segment
    tips = [] if segment is None else list(range(len(segment.placements)))
    if segment is not None:
        outward = {i: -pose.rotation @ np.asarray(segment.placements[i].normal) for i in tips}
        for i in tips:
            if outward[i] @ view.direction <= 0:
                _tip(ax, animation, view, pose, segment, i)
    _object(ax, animation, view, pose)
    if segment is not None:
        for i in tips:
            hidden = outward[i] @ view.direction <= 0
            (_outline if hidden else _tip)(ax, animation, view, pose, segment, i)
    _environment(ax, animation, view, region, depth, behind=False)


def _environment(
    ax: Any, animation: Animation, view: Projection, region: View, depth: float, behind: bool
) -> None:
    """Draw the floor and the obstacles behind the object, or the obstacles before it."""
    if behind and animation.problem.environment.floor:
        (x, y, _), (X, Y, _) = region.low, region.high
        floor = np.array([[x, y, 0.0], [X, y, 0.0], [X, Y, 0.0], [x, Y, 0.0]])
        _polygon(ax, view, floor, palette.css(palette.FLOOR), 1.0)
    for obstacle in animation.problem.environment.obstacles:
        for piece in obstacle.body.pieces:
            part = clipped(piece, region)
            if part is None or (view.depth(part.vertices) <= depth) != behind:
                continue
            faces = [part.vertices[list(face)] for face in part.faces]
            for face in sorted(faces, key=view.depth):
                _polygon(ax, view, face, palette.css(palette.OBSTACLE), 0.16)


def _object(ax: Any, animation: Animation, view: Projection, pose: Pose) -> None:
    body = animation.problem.body
    shapes: list[tuple[Array, Array]] = []
    if body.surface:
        for face in body.surface:
            shapes += [(pose.apply(t), pose.rotation @ face.normal) for t in face.triangles]
    else:
        for piece in body.pieces:
            corners = pose.apply(piece.vertices)
            normals = piece.face_normals @ pose.rotation.T
            shapes += [(corners[list(f)], n) for f, n in zip(piece.faces, normals, strict=True)]
    seen = [shape for shape in shapes if shape[1] @ view.direction > 1e-9]
    for polygon, normal in sorted(seen, key=lambda shape: view.depth(shape[0])):
        shade = 0.62 + 0.38 * max(0.0, float(normal @ LIGHT))
        colour = tuple(shade * c / 255 for c in palette.OBJECT.to_bytes(3, "big"))
        _polygon(ax, view, polygon, colour, 1.0, edge=not body.surface)


def _polygon(
    ax: Any, view: Projection, points: Array, colour: Any, opacity: float, edge: bool = True
) -> None:
    from matplotlib.patches import Polygon

    ax.add_patch(
        Polygon(
            view.flat(points),
            closed=True,
            facecolor=colour,
            alpha=opacity,
            edgecolor="0.25" if edge else colour,
            linewidth=0.5 if edge else 0.1,
        )
    )


def _outline(
    ax: Any, animation: Animation, view: Projection, pose: Pose, segment: ShownSegment, i: int
) -> None:
    """Draw the outline of a fingertip that the object may hide."""
    from matplotlib.patches import Circle

    radius = float(animation.problem.fingers.radius[i])
    centre = view.flat(pose.apply(animation.centre(i, segment.placements[i]))[None])[0]
    ax.add_patch(Circle(centre, radius, fill=False, edgecolor="0.2", linewidth=0.5, linestyle=":"))


def _tip(
    ax: Any, animation: Animation, view: Projection, pose: Pose, segment: ShownSegment, i: int
) -> None:
    """Draw a fingertip: under position control in a square, under force control with an arrow."""
    from matplotlib.patches import Circle, Rectangle

    radius = float(animation.problem.fingers.radius[i])
    centre = pose.apply(animation.centre(i, segment.placements[i]))
    (x, y), mode = view.flat(centre[None])[0], segment.modes[i]
    colour = palette.css({"P": palette.POSITION, "F": palette.FORCE}.get(mode, palette.LIFTED))
    if mode == "P":
        corner = (x - 1.1 * radius, y - 1.1 * radius)
        side = 2.2 * radius
        ax.add_patch(Rectangle(corner, side, side, fill=False, edgecolor=colour, linewidth=0.8))
    force, limit = segment.record.f_com[i], float(animation.problem.fingers.max_normal_force[i])
    if force and limit > 0:
        normal = pose.rotation @ np.asarray(segment.placements[i].normal)
        length = ARROW * animation.problem.body.diagonal * force / limit
        head = centre - 1.05 * radius * normal
        ends = view.flat(np.stack([head - length * normal, head]))
        ax.annotate(
            "", xy=ends[1], xytext=ends[0], annotation_clip=False,
            arrowprops={
                "arrowstyle": "-|>", "color": colour, "linewidth": 1.0,
                "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6,
            },
        )  # fmt: skip
    ax.add_patch(Circle((x, y), radius, facecolor=colour, edgecolor="black", linewidth=0.4))
    if mode == "F":
        ax.add_patch(Circle((x, y), 0.62 * radius, fill=False, edgecolor="white", linewidth=0.8))
