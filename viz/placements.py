"""Where a finger may go: faces coloured by z, as an image and as a page with the object in 3D."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.feasibility.placement_map import FINDINGS, PlacementMap
from gm_ompl.feasibility.verdict import Finding

from . import palette
from .canvas import new_figure, title
from .inspection import PAGE
from .page import embedded, escaped
from .scene import (
    VIEW_SIZE,
    Recorder,
    draw_coloured,
    draw_piece,
    similarity,
    viewer_script,
    visualizer,
)

LOOKS: Final = {
    Finding.UNSTABLE: (0xF0E442, "...", "z below z_min"),
    Finding.NO_EQUILIBRIUM: (0xD55E00, "///", "no equilibrium"),
    Finding.INTERNAL_FORCE: (0xCC79A7, "\\\\\\", "internal force"),
    Finding.POCKET: (0x56B4E9, "ooo", "in a pocket"),
    Finding.GEOMETRY: (0xBBBBBB, "xxx", "something is in the way"),
    Finding.UNDECIDED: (0xFFFFFF, "+++", "undecided"),
}
"""What blocks a placement: its colour, its hatching, its words."""

SIZE: Final = 1.5  # width and height of a face's grid [inch]
ACROSS: Final = 3  # faces side by side
WIDTH: Final = 0.9  # of a placement's patch in 3D, of the distance to the next
LIFT: Final = 2e-3  # how far patches are off the face, in D


def placements_figure(found: PlacementMap) -> Any:
    """Return the figure: per kind of finger and face a grid of cells, coloured by z / z_min."""
    table, kinds = found.problem.fingers.placements, found.kinds()
    panels = [(group, face) for group in kinds for face in np.unique(table.face)]
    down = -(-len(panels) // ACROSS)
    figure = new_figure(ACROSS * SIZE + 1.3, down * (SIZE + 0.3) + 0.5)
    axes = figure.subplots(down, ACROSS, squeeze=False)
    figure.suptitle(title(found.problem.name, 48), fontsize=8, parse_math=False)
    top, image = _top(found), None
    for ax, panel in zip(axes.flat, panels, strict=False):
        image = _face(ax, found, *panel, top) or image
    for ax in axes.flat[len(panels) :]:
        ax.set_axis_off()
    if image is not None:
        figure.colorbar(image, ax=axes, shrink=0.6, label="best z over all partners")
    _legend(figure, found)
    return figure


def _top(found: PlacementMap) -> float:
    holding = found.z[np.isfinite(found.z)]
    return float(holding.max(initial=0.0)) or 1.0


def _face(ax: Any, found: PlacementMap, group: tuple[int, ...], face: int, top: float) -> Any:
    """Draw one face's grid; return its image where a placement holds."""
    table, finger = found.problem.fingers.placements, group[0]
    rows = np.flatnonzero(table.face == face)
    cells = table.cell[rows]
    shape = tuple(cells.max(axis=0) + 1)
    z, blocks = np.full(shape, np.nan), np.full(shape, -1)
    for row, (i, j) in zip(rows, cells, strict=True):
        if found.finding(finger, int(row)) is Finding.HOLDS:
            z[i, j] = found.z[finger, row]
        else:
            blocks[i, j] = found.findings[finger, row]
    fingers = ", ".join(map(str, group))
    ax.set_title(f"face {table.labels[face]}, finger {fingers}", parse_math=False)
    ax.set_xticks([])
    ax.set_yticks([])
    ax.set_box_aspect(1)
    for k, finding in enumerate(FINDINGS):
        if (blocks == k).any():
            _patches(ax, blocks == k, finding)
    ax.set_xlim(-0.5, shape[0] - 0.5)
    ax.set_ylim(-0.5, shape[1] - 0.5)
    if np.isnan(z).all():
        return None
    low = found.problem.mechanics.z_min
    return ax.imshow(
        z.T, origin="lower", cmap="viridis", vmin=low, vmax=max(top, low + 1e-12), aspect="auto"
    )


def _patches(ax: Any, cells: BoolArray, finding: Finding) -> None:
    """Colour and hatch the cells of one finding."""
    colour, hatch, _ = LOOKS[finding]
    where = np.ma.masked_where(~cells.T, np.ones(cells.T.shape))
    edges = [np.arange(n + 1) - 0.5 for n in cells.shape]
    mesh = ax.pcolor(*edges, where, hatch=hatch, edgecolor="0.45", linewidth=0.0)
    mesh.set_facecolor(palette.css(colour))


def _legend(figure: Any, found: PlacementMap) -> None:
    from matplotlib.patches import Patch

    handles = [
        Patch(facecolor=palette.css(colour), hatch=hatch, edgecolor="0.45", label=words)
        for finding, (colour, hatch, words) in LOOKS.items()
        if (found.findings == FINDINGS.index(finding)).any()
    ]
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)


def placements_page(found: PlacementMap, text: str, finger: int = 0) -> str:
    """Return the page: the object with a coloured patch at every placement, and the numbers."""
    packed = [base64.b64encode(message).decode("ascii") for message in _messages(found, finger)]
    return PAGE.format(
        title=escaped(found.problem.name),
        text=escaped(text),
        messages=embedded(packed),
        viewer=viewer_script(),
    )


def _messages(found: PlacementMap, finger: int) -> list[bytes]:
    recorder = Recorder()
    view = visualizer(recorder)
    body, pose = found.problem.body, found.moment.pose
    scale = VIEW_SIZE / body.diagonal
    world = view["world"]
    world.set_transform(similarity(scale, -scale * pose.position))
    camera = view["/Cameras/default/rotated/<object>"]
    camera.set_property("position", [1.4 * VIEW_SIZE, 0.7 * VIEW_SIZE, 0.0])  # its y is up
    placed = np.eye(4)
    placed[:3, :3], placed[:3, 3] = pose.rotation, pose.position
    world["object"].set_transform(placed)
    for k, piece in enumerate(body.pieces):
        node = world["object"][f"piece{k}"]
        draw_piece(node, piece.faces, piece.vertices, palette.OBJECT, 1.0)
    draw_coloured(world["object"]["placements"], *patches(found, finger))
    return recorder.messages


def patches(found: PlacementMap, finger: int = 0) -> tuple[Array, IntArray, Array]:
    """Return a square at every placement: corners (4 P, 3), triangles (2 P, 3), RGB (4 P, 3).

    Corners are in the object frame; colours are from 0 to 1.
    """
    table, D = found.problem.fingers.placements, found.problem.body.diagonal
    P, half = len(table), _spacing(found) * WIDTH / 2.0
    corners, faces = np.empty((4 * P, 3)), np.empty((2 * P, 3), dtype=np.int64)
    for row, (a, b) in enumerate(_tangents(table.normals)):
        centre = table.points[row] - LIFT * D * table.normals[row]
        ways = ((-half, -half), (half, -half), (half, half), (-half, half))
        corners[4 * row : 4 * row + 4] = [centre + u * a + v * b for u, v in ways]
        faces[2 * row : 2 * row + 2] = [[4 * row, 4 * row + 1, 4 * row + 2],
                                        [4 * row, 4 * row + 2, 4 * row + 3]]  # fmt: skip
    return corners, faces, np.repeat(_colours(found, finger), 4, axis=0)


def _spacing(found: PlacementMap) -> float:
    """Return the least distance of two placements on one face."""
    from scipy.spatial import cKDTree

    table, least = found.problem.fingers.placements, found.problem.body.diagonal / 10.0
    for face in np.unique(table.face):
        points = table.points[table.face == face]
        if len(points) > 1:
            least = min(least, float(cKDTree(points).query(points, k=2)[0][:, 1].min()))
    return least


def _tangents(normals: Array) -> Iterator[tuple[Array, Array]]:
    """Yield two tangents of each face, along axes where its normal is."""
    for normal in normals:
        axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
        a = axis - (axis @ normal) * normal
        a /= np.linalg.norm(a)
        yield a, np.cross(normal, a)


def _colours(found: PlacementMap, finger: int) -> Array:
    """Return a colour per placement (P, 3): viridis by z where it holds, else what blocks."""
    from matplotlib import colormaps

    z_min, top = found.problem.mechanics.z_min, _top(found)
    share = (np.nan_to_num(found.z[finger], neginf=0.0) - z_min) / max(top - z_min, 1e-12)
    colours: Array = colormaps["viridis"](np.clip(share, 0.0, 1.0))[:, :3]
    for finding, (colour, _, _) in LOOKS.items():
        rgb = [(colour >> shift & 255) / 255.0 for shift in (16, 8, 0)]
        colours[found.findings[finger] == FINDINGS.index(finding)] = rgb
    return colours
