"""Files that are no usable mesh: refused with the reason, and with keys that mend it when typed."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from gm_ompl.app.main import app
from gm_ompl.errors import ScenarioError
from gm_ompl.geometry import decomposition, remedies, usage
from gm_ompl.scenario.inspection import inspect
from tests.moved import parts

OFFER = re.compile(r"(bodies|weld|simplify|convex): (all|hull|decompose|\[\d+\]|[\d.e+-]+)")


def box(size: float = 1.0) -> trimesh.Trimesh:
    return trimesh.creation.box([size, 2 * size, 3 * size])


def both(a: trimesh.Trimesh, b: trimesh.Trimesh) -> trimesh.Trimesh:
    return trimesh.util.concatenate([a, b])


def without(mesh: trimesh.Trimesh, *rows: int) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, np.delete(mesh.faces, rows, axis=0), process=False)


def moved(mesh: trimesh.Trimesh, *by: float) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices + np.array(by), mesh.faces, process=False)


def torn(gap: float) -> trimesh.Trimesh:
    """A box whose triangles do not quite meet."""
    mesh = box()
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    corners = corners + gap * np.random.default_rng(1).uniform(-1, 1, corners.shape)
    return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)


def fine(rounds: int) -> trimesh.Trimesh:
    mesh = box()
    for _ in range(rounds):
        mesh = mesh.subdivide()
    return mesh


def dented(count: int) -> trimesh.Trimesh:
    return trimesh.creation.annulus(r_min=1, r_max=2, height=1, sections=count)


def klein() -> trimesh.Trimesh:
    """Two boxes, one of them turned inward and moved half out: a surface through itself."""
    inner = moved(box(), 0.5, 0.0, 0.0)
    return both(box(), trimesh.Trimesh(inner.vertices, inner.faces[:, ::-1], process=False))


BAD: dict[str, tuple[Callable[[], trimesh.Trimesh], str]] = {
    "two apart": (lambda: both(box(), moved(box(), 9, 0, 0)), "there are 2 bodies"),
    "two that touch": (lambda: both(box(), moved(box(), 1, 0, 0)), "there are 2 bodies"),
    "two of two sizes that touch": (lambda: both(box(), moved(box(2.0), 1.5, 0, 0)), "2 bodies"),
    "one through another": (lambda: both(box(), moved(box(), 0.5, 0.1, 0.2)), "there are 2 bodies"),
    "one triangle missing": (lambda: without(box(), 3), "not watertight: 3 of its edges"),
    "open on one side": (lambda: without(box(), 2, 3), "not watertight"),
    "a loose triangle": (lambda: both(box(), without(moved(box(), 5, 0, 0), *range(1, 12))),
                         "there are 2 bodies"),
    "torn": (lambda: torn(1e-4), "bodies"),
    "a triangle twice": (lambda: both(box(), without(box(), *range(1, 12))), ""),
    "a hole of many facets": (lambda: dented(12), "not convex along 12 planes; at most 8"),
    "too many triangles": (lambda: fine(2), "192 triangles; at most 100"),
    "a surface through itself": (klein, ""),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_what_a_refusal_offers_works_when_typed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every key that the message offers is typed and the mesh loads; at least one is offered."""
    for module, limit, low in (
        (decomposition, "MAX_DENTS", 8),
        (usage, "MAX_FACES", 100),
        (remedies, "FEWER", 50),
    ):
        monkeypatch.setattr(module, limit, low)  # small meshes are quick
    make, reason = BAD[name]
    file = tmp_path / "part.stl"
    make().export(file)
    with pytest.raises(ScenarioError) as caught:
        inspect(str(file))
    text = str(caught.value)
    assert reason in text
    offers = OFFER.findall(text)
    assert offers
    for key, value in offers:
        if value != "decompose":
            assert inspect(str(file), [f"{key}={value}"]).own.volume > 0.0


def test_decompose_works_when_typed(tmp_path: Path) -> None:
    """Meshes with hollows, and double ones, become convex pieces near them."""
    pytest.importorskip("coacd")
    for mesh, pieces in ((parts()["L"], 2), (BAD["two apart"][0](), 2)):
        file = tmp_path / "part.stl"
        mesh.export(file)
        found = inspect(str(file), ["convex=decompose"])
        assert found.deviation < 1e-3 * found.body.diagonal
        assert len(found.body.pieces) == pieces


def _flat(file: Path) -> None:
    mesh = box()
    mesh.vertices[:, 2] = 0.0
    mesh.export(file)


NO_MESH: dict[str, tuple[str, Callable[[Path], Any], str]] = {
    "missing": ("part.stl", lambda file: (file.parent / "prat.stl").write_bytes(b""),
                "did you mean 'prat.stl'"),
    "another ending": ("part.dxf", lambda file: file.write_text(""), "ends in .stl, .obj"),
    "text": ("part.stl", lambda file: file.write_text("this is no mesh"), "save a surface"),
    "cut short": ("part.stl", lambda file: file.write_bytes(bytes(range(128, 256))), "save it as"),
    "empty": ("part.obj", lambda file: file.write_text(""), "save"),
    "points alone": ("part.obj", lambda file: file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
                     "save a surface"),
    "not a number": ("part.obj", lambda file: file.write_text(
        "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"), "save"),
    "flat": ("part.stl", _flat, "give it a thickness: {box: [1, 2, 0.002]}"),
    "a folder": ("part.stl", lambda file: file.mkdir(), "a mesh is a file in .stl"),
}  # fmt: skip


@pytest.mark.parametrize("name", NO_MESH)
def test_what_is_no_mesh_is_refused_with_advice(name: str, tmp_path: Path) -> None:
    """One message, which says what to do; the command ends with 2."""
    ending, make, advice = NO_MESH[name]
    file = tmp_path / ending
    make(file)
    scenario = tmp_path / "part.yaml"
    scenario.write_text(
        "format: gm-ompl-scenario/1\nname: bad\n"
        f"object: {{shape: {{mesh: {ending}}}, mass: 1}}\n"
        "friction: {environment: 0.5, finger: 0.5}\n"
        "fingers: {count: 1, radius: 0.1, max_normal_force: 5}\n"
        "motion: {start: {position: [0, 0, 9]}, path: [{slide: {by: [1, 0, 0]}}]}\n"
        "lattice: {segments: 1}\n"
    )
    ended = CliRunner().invoke(app, ["inspect", str(scenario)])
    assert ended.exit_code == 2
    assert "object.shape.mesh" in ended.stderr
    assert advice in ended.stderr


@pytest.mark.parametrize(
    ("key", "wanted"),
    [
        ("bodies=[3]", "there is no body 3; there are 1 bodies"),
        ("convex=hul", "did you mean 'hull'?"),
        ("weld=-1", ">= 0"),
        ("simplify=3", ">= 4"),
        ("frame={rotation: {axis: [0, 0, 0], angle: 90 deg}}", "must not be all zeros"),
        ("frame={rotation: {axis: [1, 0, 0]}}", "{axis: [0, 0, 1], angle: 90 deg}"),
        ("frame={rotation: {yaw: 30}}", "an angle with its unit"),
        ("deviation=1", "leave it out"),
    ],
)
def test_wrong_keys_are_named(key: str, wanted: str, tmp_path: Path) -> None:
    """Keys beside a mesh: what is wrong, and what would be right."""
    file = tmp_path / "part.stl"
    box().export(file)
    with pytest.raises(ScenarioError) as caught:
        inspect(str(file), [key])
    assert wanted in str(caught.value)
    assert key.partition("=")[0] in str(caught.value)
