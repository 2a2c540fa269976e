"""Small pictures of a plan's decisive moments: start, before and after each regrasp, goal.

With free motion also where the object begins to do something else.

An orthographic projection of its own, drawn back to front: no browser and no graphics card.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array, unit
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import FreeMotion

from . import palette
from .animation import Animation, ShownSegment
from .canvas import new_figure, title
from .region import View, clipped, neighbourhood, viewpoint

MOST: Final = 12  # at most this many moments are drawn; of more regrasps the first are shown

COLUMNS: Final = 4
CAPTION: Final = 26  # characters of a caption's line
CELL: Final = 1.75  # width and height of one picture [inch]
ARROW: Final = 0.45  # length of an arrow at f_max, in D

LIGHT: Final = unit([0.4, -0.5, 0.8])


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture."""

    caption: str  # what it shows
    # the segment whose fingers, modes and forces are drawn; None without a plan
    segment: ShownSegment | None
    pose: Array  # (7,), of the object
    # (3,), the centre of the fingertip that is on its way, object frame
    lifted: Array | None = None


def pictures(animation: Animation) -> list[Picture]:
    """Return start, before and after each regrasp, and goal; with free motion each link's end."""
    if not animation.segments:
        return [Picture("start", None, animation.rest_pose())]
    found = [Picture("start", animation.segments[0], animation.segments[0].poses[0])]
    regrasp, told = 0, _told(animation)
    for k, segment in enumerate(animation.segments):
        ends = k + 1 == len(animation.segments) or animation.segments[k + 1].step != segment.step
        if ends and segment.step in told:
            found.append(Picture(told[segment.step], segment, segment.poses[-1]))
        if not segment.regrasp:
            continue
        regrasp += 1
        before = next((b for b in animation.segments[k::-1] if not b.regrasp), segment)
        after = next((b for b in animation.segments[k:] if not b.regrasp), segment)
        found.append(Picture(f"before regrasp {regrasp}", before, segment.poses[0]))
        found.append(Picture(f"after regrasp {regrasp}", after, segment.poses[0]))
    last = animation.segments[-1]
    return [*found[: MOST - 1], Picture("goal", last, last.poses[-1])]


def _told(animation: Animation) -> dict[int, str]:
    """Return what the object did, by the last step of it; not what ends at a regrasp or the goal.

    Nothing where its way is prescribed: all of it is known beforehand.
    """
    if not isinstance(animation.problem.motion, FreeMotion):
        return {}
    steps, last = animation.plan.steps, len(animation.plan.steps) - 1
    ends = [link.steps[1] for link in animation.chain]
    return {
        k: textwrap.fill(link.words, CAPTION)
        for k, link in zip(ends, animation.chain, strict=True)
        if k < last and "regrasp" not in (steps[k].kind, steps[k + 1].kind)
    }


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
        Painter(ax, animation, view, region).draw(picture)
        ax.set_title(picture.caption, fontsize=7 if "\n" not in picture.caption else 5.5)
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


class Painter:
    """Draws one picture back to front; matplotlib is loaded when it is made."""

    def __init__(self, ax: Any, animation: Animation, view: Projection, region: View) -> None:
        from matplotlib import patches

        self._ax, self._patches, self._view, self._region = ax, patches, view, region
        self._animation, self._problem = animation, animation.problem

    def draw(self, picture: Picture) -> None:
        """Draw the floor, then what is behind the object, the object, and what is before it."""
        pose = Pose.from_quaternion(picture.pose[:3], picture.pose[3:])
        depth = self._view.depth(pose.position[None])
        self._environment(depth, behind=True)
        shown = picture.segment
        normals = [] if shown is None else [place.normal for place in shown.placements]
        hidden = [pose.rotation @ np.asarray(n) @ self._view.direction >= 0 for n in normals]
        for i in np.flatnonzero(hidden).tolist():
            self._tip(pose, picture, i)
        self._object(pose)
        for i, behind in enumerate(hidden):
            self._tip(pose, picture, i, outline=behind)
        self._environment(depth, behind=False)

    def _environment(self, depth: float, behind: bool) -> None:
        """Draw the floor and the obstacles behind the object, or the obstacles before it."""
        if behind and self._problem.environment.floor:
            (x, y, _), (X, Y, _) = self._region.low, self._region.high
            floor = np.array([[x, y, 0.0], [X, y, 0.0], [X, Y, 0.0], [x, Y, 0.0]])
            self._polygon(floor, palette.css(palette.FLOOR))
        for obstacle in self._problem.environment.obstacles:
            for piece in obstacle.body.pieces:
                part = clipped(piece, self._region)
                if part is None or (self._view.depth(part.vertices) <= depth) != behind:
                    continue
                faces = [part.vertices[list(face)] for face in part.faces]
                for face in sorted(faces, key=self._view.depth):
                    self._polygon(face, palette.css(palette.OBSTACLE), 0.16)

    def _object(self, pose: Pose) -> None:
        body = self._problem.body
        shapes = [(corners, face.normal) for face in body.surface for corners in face.triangles]
        for piece in () if body.surface else body.pieces:
            faces = zip(piece.faces, piece.face_normals, strict=True)
            shapes += [(piece.vertices[list(face)], normal) for face, normal in faces]
        world = [(pose.apply(polygon), pose.rotation @ normal) for polygon, normal in shapes]
        seen = [shape for shape in world if shape[1] @ self._view.direction > 1e-9]
        for polygon, normal in sorted(seen, key=lambda shape: self._view.depth(shape[0])):
            shade = 0.62 + 0.38 * max(0.0, float(normal @ LIGHT))
            colour = tuple(shade * c / 255 for c in palette.OBJECT.to_bytes(3, "big"))
            self._polygon(polygon, colour, edge=not body.surface)

    def _polygon(self, points: Array, colour: Any, opacity: float = 1.0, edge: bool = True) -> None:
        self._ax.add_patch(
            self._patches.Polygon(
                self._view.flat(points), closed=True, facecolor=colour, alpha=opacity,
                edgecolor="0.25" if edge else colour, linewidth=0.5 if edge else 0.1,
            )
        )  # fmt: skip

    def _tip(self, pose: Pose, picture: Picture, i: int, outline: bool = False) -> None:
        """Draw a fingertip: under position control in a square, under force control with an arrow.

        Of one that the object may hide the outline alone is drawn again.
        """
        shown = picture.segment
        assert shown is not None
        add, circle = self._ax.add_patch, self._patches.Circle
        radius = float(self._problem.fingers.radius[i])
        mode, place = shown.modes[i], self._animation.centre(i, shown.placements[i])
        centre = pose.apply(place if mode != "L" or picture.lifted is None else picture.lifted)
        x, y = self._view.flat(centre[None])[0]
        if outline:
            add(circle((x, y), radius, fill=False, edgecolor="0.2", linewidth=0.5, linestyle=":"))
            return
        colour = palette.css({"P": palette.POSITION, "F": palette.FORCE}.get(mode, palette.LIFTED))
        if mode == "P":
            corner, side = (x - 1.1 * radius, y - 1.1 * radius), 2.2 * radius
            square = self._patches.Rectangle(
                corner, side, side, fill=False, edgecolor=colour, linewidth=0.8
            )
            add(square)
        force, limit = shown.record.f_com[i], float(self._problem.fingers.max_normal_force[i])
        if force and limit > 0:
            normal = pose.rotation @ np.asarray(shown.placements[i].normal)
            length = ARROW * self._problem.body.diagonal * force / limit
            head = centre - 1.05 * radius * normal
            ends = self._view.flat(np.stack([head - length * normal, head]))
            self._ax.annotate(
                "", xy=ends[1], xytext=ends[0], annotation_clip=False,
                arrowprops={
                    "arrowstyle": "-|>", "color": colour, "linewidth": 1.0,
                    "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6,
                },
            )  # fmt: skip
        add(circle((x, y), radius, facecolor=colour, edgecolor="black", linewidth=0.4))
        if mode == "F":
            add(circle((x, y), 0.62 * radius, fill=False, edgecolor="white", linewidth=0.8))
