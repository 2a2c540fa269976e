"""``python -m docs.tables.meshes``: meshes as they are found in wheels, loaded and planned with.

The wheels are downloaded into ``build/wheels`` and unpacked, not installed. A mesh that is refused
is tried with what the refusal offers, as typed. ``docs/meshes.md`` holds the table.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
import zipfile
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

import numpy as np

import gm_ompl
from gm_ompl.errors import GeometryError, ScenarioError
from gm_ompl.geometry.mesh import read_triangles
from gm_ompl.geometry.resting import resting_poses
from gm_ompl.scenario.inspection import inspect

from .pages import write_tables

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "build"

WHEELS = {
    "robot-properties-fingers": "*.stl",
    "gymnasium-robotics": "*/stls/hand/*.stl",
    "dm-control": "*/kinova/meshes_decimated/*.STL",
}
"""Where meshes come from, and which of them are taken."""

OFFER = re.compile(r"(bodies|weld|simplify|convex): (all|hull|decompose|\[\d+\]|[\d.e+-]+)")

PLAN_S = 10.0
"""The time that HybridRRTConnect has."""

COLUMNS = "| mesh | triangles | as it is | with | pieces | deviation | loaded in s | planned in s |"


@dataclass
class Row:
    """What became of one mesh; ``tried`` holds every offer and how it ended."""

    mesh: str
    triangles: int
    verdict: str
    keys: str = ""
    pieces: int = 0
    deviation: float = 0.0
    load_s: float = 0.0
    plan_s: float | None = None
    tried: dict[str, str] = field(default_factory=dict)


def meshes() -> list[tuple[str, Path]]:
    """Return the meshes' names and files, downloaded where they are not yet there."""
    found = []
    for wheel, pattern in WHEELS.items():
        folder = BUILD / "meshes" / wheel
        if not folder.exists():
            command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", wheel]
            subprocess.run([*command, "-d", str(BUILD / "wheels")], check=True)
            (file,) = (BUILD / "wheels").glob(f"{wheel.replace('-', '_')}-*.whl")
            with zipfile.ZipFile(file) as archive:
                wanted = [n for n in archive.namelist() if PurePosixPath(n).match(pattern)]
                archive.extractall(folder, wanted)
        files = sorted(p for p in folder.rglob("*") if p.is_file())
        found += [(f"{wheel}: {file.relative_to(folder).as_posix()}", file) for file in files]
    return found


def attempt(name: str, file: Path, decompose: bool) -> Row:
    """Return what becomes of a mesh, as it is or with what its refusal offers."""
    keys: list[str] = []
    offers: list[str] = []
    row = Row(name, len(read_triangles(file)[1]), "loads")
    try:
        took = _loaded(row, file, keys)
    except ScenarioError as error:
        row.verdict = _reason(str(error))
        offers = [f"{key}={value}" for key, value in OFFER.findall(str(error))]
    for offer in offers:
        if offer == "convex=decompose" and not decompose:
            continue
        try:
            took = _loaded(row if not row.keys else Row("", 0, ""), file, [offer])
            row.keys = row.keys or offer.replace("=", ": ")
            row.tried[offer] = f"{took:.1f} s"
        except (ScenarioError, GeometryError) as error:
            row.tried[offer] = f"REFUSED: {error}"
    if row.keys:
        keys = [row.keys.replace(": ", "=")]
    row.plan_s = _planned(file, keys) if row.pieces else None
    return row


def _loaded(row: Row, file: Path, keys: list[str]) -> float:
    started = time.perf_counter()
    found = inspect(str(file), keys)
    row.load_s = time.perf_counter() - started
    row.pieces, row.deviation = len(found.body.pieces), found.deviation / found.body.diagonal
    return row.load_s


def _reason(text: str) -> str:
    for words, short in (
        ("bodies (", "several bodies"), ("watertight", "not watertight"),
        ("no surface", "edges of more than two triangles"), ("planes", "too many hollows"),
        ("convex pieces; at most", "too many pieces"), ("too thin", "too thin to be cut"),
        ("too close", "too thin to be cut"), ("crosses itself", "crosses itself"),
        ("at most 20000", "too many triangles"), ("no volume", "no volume"),
    ):  # fmt: skip
        if words in text:
            return short
    return text


def _planned(file: Path, keys: list[str]) -> float | None:
    """Return how long it takes to plan sliding the part by half its size, lying; None: too long."""
    found = inspect(str(file), keys)
    D, turn = found.body.diagonal, found.rests[0].rotation.tolist()
    shape: dict[str, object] = {"mesh": file.name, "frame": {"rotation": {"quaternion": turn}}}
    for key in keys:
        name, _, value = key.partition("=")
        shape[name] = json.loads(value) if value[0] in "[0123456789" else value
    tree = {
        "format": "gm-ompl-scenario/1", "name": "mesh", "object": {"shape": shape, "mass": 0.2},
        "friction": {"environment": 0.4, "finger": 0.8},
        "fingers": {"count": 2, "radius": 0.05 * D, "max_normal_force": 10.0,
                    "placements": {"grid": [3, 3], "smallest_face": 0.01}},
        "motion": {"start": {"position": [0.0, 0.0, 2.0 * D]},
                   "path": [{"slide": {"by": [0.5 * D, 0.0, 0.0]}}]},
        "lattice": {"segments": 5}, "mechanics": {"z_min": 0.02},
        "cost": {"regrasp": D, "stability": 0.001 * D},
    }  # fmt: skip
    scenario = file.parent / "planned.yaml"
    scenario.write_text(json.dumps(tree))
    try:
        body = gm_ompl.load(scenario).problem.body
        down = resting_poses(body)
        height = min((pose.height for pose in down if pose.down[2] < -0.999), default=None)
        if height is None:
            return None
        resting = gm_ompl.load(scenario, [f"motion.start.position=[0, 0, {height!r}]"])
    finally:
        scenario.unlink()
    started = time.perf_counter()
    plan = gm_ompl.plan(resting, planner="HybridRRTConnect", time_limit=PLAN_S, seed=1)
    return time.perf_counter() - started if plan.cost is not None else None


def line(row: Row) -> str:
    """Return a mesh's row of the table."""
    planned = "-" if row.plan_s is None else f"{row.plan_s:.1f}"
    return (
        f"| {row.mesh} | {row.triangles} | {row.verdict} | {row.keys} | {row.pieces} | "
        f"{row.deviation:.1e} | {row.load_s:.1f} | {planned} |"
    )


def main(arguments: list[str]) -> None:
    """Try every mesh that has no result yet, and write the table; ``--decompose`` tries that, too."""
    store = BUILD / "meshes" / "rows.jsonl"
    store.parent.mkdir(parents=True, exist_ok=True)
    known = {}
    if store.exists():
        known = {r["mesh"]: Row(**r) for r in map(json.loads, store.read_text().splitlines())}
    for name, file in meshes():
        if name not in known:
            row = attempt(name, file, "--decompose" in arguments)
            with store.open("a") as out:
                out.write(json.dumps(row.__dict__) + "\n")
            known[name] = row
    head = [COLUMNS, "|---" * (COLUMNS.count("|") - 1) + "|"]
    table = "\n".join([*head, *(line(row) for row in known.values())]) + "\n"
    write_tables(ROOT / "docs" / "meshes.md", {"meshes": table})


if __name__ == "__main__":
    main(sys.argv[1:])
