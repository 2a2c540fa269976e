from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import umsgpack
from gm_ompl.viz.animation import animate
from gm_ompl.viz.page import embedded, escaped, page
from gm_ompl.viz.region import View, clipped, neighbourhood
from gm_ompl.viz.scene import SceneMessages, scene_messages
from gm_ompl.viz.score import turn_to

from gm_ompl.geometry.solids import hull
from gm_ompl.planfile.model import Plan


def unpacked(scene: SceneMessages) -> list[dict[str, Any]]:
    return [umsgpack.unpackb(message) for message in scene.messages]


def test_each_fingertip_has_three_looks(regrasp: Plan) -> None:
    """Position, force and lifted have nodes of their own, and shapes of their own."""
    paths = {
        m["path"] for m in unpacked(scene_messages(animate(regrasp))) if m["type"] == "set_object"
    }
    for i in range(2):
        finger = f"/meshcat/world/object/finger{i}"
        for part in ("position/ball", "position/frame", "force/ring", "force/arrow/head"):
            assert f"{finger}/{part}" in paths
        assert f"{finger}/lifted/ball" in paths


def test_messages_hold_no_users_text(renamed: Callable[[str], Plan]) -> None:
    """A scenario's words go into the page as text, never into meshcat's messages."""
    for message in scene_messages(animate(renamed("NEEDLE"))).messages:
        assert b"NEEDLE" not in message


def test_the_world_is_mapped_to_a_few_units(
    regrasp: Plan, rescaled: Callable[[Plan, float], Plan]
) -> None:
    """At every scale the region's corners land at the same place in meshcat's units."""
    for factor in (1e-4, 1.0, 1e3):
        animation = animate(rescaled(regrasp, factor))
        scene = scene_messages(animation)
        region = neighbourhood(animation)
        matrix = next(
            m["matrix"] for m in unpacked(scene)
            if m["type"] == "set_transform" and m["path"] == "/meshcat/world"
        )  # fmt: skip
        transform = np.array(matrix).reshape(4, 4).T
        corner = transform @ [*region.high, 1.0]
        size = region.high - region.low
        np.testing.assert_allclose(corner[:3], 1.5 * size / np.linalg.norm(size), rtol=1e-9)


def test_walls_end_at_the_edge_of_the_picture(regrasp: Plan) -> None:
    """The walls, a hundred units wide, are drawn only where the object comes near."""
    animation = animate(regrasp)
    region = neighbourhood(animation)
    assert region.diagonal < 40.0
    for obstacle in animation.problem.environment.obstacles:
        for piece in obstacle.body.pieces:
            part = clipped(piece, region)
            assert part is not None
            assert (part.vertices >= region.low - 1e-9).all()
            assert (part.vertices <= region.high + 1e-9).all()


def test_clipping_is_intersection() -> None:
    """A point is inside the clipped piece exactly where it is inside the piece and the region."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        piece = hull(rng.uniform(-2, 2, (9, 3)) + rng.uniform(-1, 1, 3))
        low = rng.uniform(-1.5, 0.0, 3)
        region = View(low, low + rng.uniform(0.5, 2.0, 3))
        points = rng.uniform(-3, 3, (400, 3))
        both = (points @ piece.face_normals.T < piece.face_offsets).all(axis=1)
        both &= ((points > region.low) & (points < region.high)).all(axis=1)
        part = clipped(piece, region)
        if part is None:
            assert not both.any()
        else:
            inside = (points @ part.face_normals.T < part.face_offsets).all(axis=1)
            assert (inside == both).all()


def test_turning_the_z_axis_to_a_normal() -> None:
    """The quaternion turns (0, 0, 1) to the normal, the opposite direction included."""
    rng = np.random.default_rng(1)
    normals = [*np.eye(3), *-np.eye(3), *rng.normal(size=(20, 3))]
    for normal in (n / np.linalg.norm(n) for n in normals):
        w, *u = turn_to(normal)
        z = np.array([0.0, 0.0, 1.0])
        turned = z + 2 * w * np.cross(u, z) + 2 * np.cross(u, np.cross(u, z))
        np.testing.assert_allclose(turned, normal, atol=1e-12)


def test_the_page_is_one_small_file(regrasp: Plan) -> None:
    """Under 1.5 MB, and no element that would load another file."""
    text = page(regrasp)
    assert len(text.encode()) < 1_500_000
    frame = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    assert not re.search(r"""(src|href|action)\s*=\s*["'](?!data:)""", frame)
    assert "connect-src" not in frame
    assert "default-src 'none'" in frame


@pytest.mark.parametrize("text", ["</script>", "<!--", "&lt;", "\u2028", "'\""])
def test_embedded_json_cannot_leave_its_element(text: str) -> None:
    """What is embedded holds no character that HTML gives a meaning to, and reads back."""
    import json

    value = {"key": [text, 1.5, None]}
    held = embedded(value)
    assert not set(held) & set("<>&\u2028")
    assert json.loads(held) == value


def test_escaped_text_keeps_letters_of_all_scripts() -> None:
    """Letters stay; what HTML would act on, controls and lone surrogates are replaced."""
    assert escaped("掴み \u05d0 é\u200d") == "掴み \u05d0 é\u200d"
    assert escaped("<&\"'>") == "&lt;&amp;&quot;&#x27;&gt;"
    assert escaped("a\x00\x1b\ud800b").encode("utf-8") == "a\ufffd\ufffd\ufffdb".encode()
