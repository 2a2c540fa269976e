"""One HTML file that shows a shape: its pieces, its faces, and how it can lie."""

from __future__ import annotations

import base64
from typing import Any, Final

import numpy as np

from gm_ompl.geometry.pose import Pose
from gm_ompl.scenario.inspection import Inspection

from . import palette
from .page import embedded, escaped
from .scene import (
    VIEW_SIZE,
    Recorder,
    draw_piece,
    draw_solid,
    similarity,
    viewer_script,
    visualizer,
)

COLOURS: Final = (0x4C78A8, 0xF58518, 0x54A24B, 0xE45756, 0x72B7B2, 0xB279A2, 0xEECA3B, 0x9D755D)
"""Colours of the pieces, in turn."""

LYING: Final = 6  # resting poses that are drawn, beside the shape as its file has it
GAP: Final = 1.3  # distance between them, in D

PAGE: Final = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; \
script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:">
<title>{title}</title>
<style>body {{ margin: 0; font: 14px sans-serif; display: flex; height: 100vh }}
#pane {{ flex: 2; min-width: 0 }} pre {{ flex: 1; overflow: auto; margin: 1em }}</style>
</head><body><div id="pane"></div><pre dir="auto">{text}</pre>
<script type="application/json" id="messages">{messages}</script>
<script>{viewer}</script>
<script>"use strict";
const viewer = new MeshCat.Viewer(document.getElementById("pane"));
for (const text of JSON.parse(document.getElementById("messages").textContent)) {{
  viewer.handle_command_bytearray(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)));
}}
document.body.dataset.ready = "yes";
</script></body></html>
"""


def inspection_page(found: Inspection, text: str) -> str:
    """Return the page: the shape as its file has it, then lying; offered faces carry a normal."""
    packed = [base64.b64encode(message).decode("ascii") for message in _messages(found)]
    return PAGE.format(
        title=escaped(found.scenario.name),
        text=escaped(text),
        messages=embedded(packed),
        viewer=viewer_script(),
    )


def _messages(found: Inspection) -> list[bytes]:
    recorder = Recorder()
    view = visualizer(recorder)
    diagonal = found.body.diagonal
    poses = [Pose.from_quaternion(np.array([0.0, 0.0, diagonal / 2]), np.array([1.0, 0, 0, 0]))]
    for k, rest in enumerate(found.rests[:LYING]):
        place = np.array([0.0, GAP * diagonal * (k + 1), rest.height])
        poses.append(Pose.from_quaternion(place, rest.rotation))
    scale = 2.5 * VIEW_SIZE / (GAP * diagonal * len(poses))
    world = view["world"]
    world.set_transform(
        similarity(scale, np.array([0.0, -scale * GAP * diagonal * (len(poses) - 1) / 2, 0.0]))
    )
    camera = view["/Cameras/default/rotated/<object>"]
    camera.set_property("position", [1.4 * VIEW_SIZE, 0.7 * VIEW_SIZE, 0.0])  # its y is up
    for k, pose in enumerate(poses):
        node = world[f"pose{k}"]
        placed = np.eye(4)
        placed[:3, :3], placed[:3, 3] = pose.rotation, pose.position
        node.set_transform(placed)
        for i, piece in enumerate(found.body.pieces):
            colour = COLOURS[i % len(COLOURS)]
            draw_piece(node[f"piece{i}"], piece.faces, piece.vertices, colour, 0.84)
        if k == 0:
            _normals(node["normals"], found)
    return recorder.messages


def _normals(node: Any, found: Inspection) -> None:
    """Draw a line out of the middle of every offered face."""
    lines = []
    for name, face in found.faces:
        if name in found.offered:
            middle = face.region.triangles[0].mean(axis=0)
            lines.append([middle, middle + 0.1 * found.body.diagonal * face.normal])
    if lines:
        draw_solid(node, np.zeros((0, 3, 3)), np.array(lines), palette.EDGE, 1.0)
