"""``python -m docs.tables.meshes``: meshes as they are found in wheels, loaded and planned with.

The wheels are downloaded into ``build/wheels`` and unpacked, not installed. A mesh that is refused
is tried with what the refusal offers, as typed. ``docs/results/meshes.md`` holds the table.
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
from gm_ompl.errors import ScenarioError
from gm_ompl.geometry.mesh import read_triangles
from gm_ompl.geometry.pose import Pose
from gm_ompl.scenario.inspection import Inspection, inspect
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.study.report import table

from .pages import write_tables

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "build"

WHEELS = {
    "robot-properties-fingers": "*.stl",
    "gymnasium-robotics": "*/stls/hand/*.stl",
}
"""Where meshes come from, and which of them are taken."""

OFFER = re.compile(r"(bodies|weld|simplify|convex): (all|hull|decompose|\[\d+\]|[\d.e+-]+)")

PLAN_S = 10.0  # the time that HybridRRTConnect has

HEAD = (
    "mesh", "triangles", "as it is", "with", "pieces", "deviation", "loaded in s", "planned in s",
)  # fmt: skip


@dataclass
class MeshFound:
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


def attempt(name: str, file: Path, decompose: bool) -> MeshFound:
    """Return what becomes of a mesh, as it is or with what its refusal offers."""
    row = MeshFound(name, len(read_triangles(file)[1]), "loads")
    used: Inspection | None = None
    offers: list[str] = []
    started = time.perf_counter()
    try:
        used = inspect(str(file))
    except ScenarioError as error:
        row.verdict = _reason(str(error))
        offers = [f"{key}={value}" for key, value in OFFER.findall(str(error))]
    row.load_s = time.perf_counter() - started
    for offer in offers:
        if offer == "convex=decompose" and not decompose:
            continue
        started = time.perf_counter()
        try:
            found = inspect(str(file), [offer])
        except ScenarioError as error:
            row.tried[offer] = f"REFUSED: {error}"
            continue
        took = time.perf_counter() - started
        row.tried[offer] = f"{took:.1f} s, {found.deviation / found.body.diagonal:.1e}"
        if used is None:
            used, row.keys, row.load_s = found, offer.replace("=", ": "), took
    if used is not None:
        row.pieces = len(used.body.pieces)
        row.deviation = used.deviation / used.body.diagonal
        row.plan_s = _planned(used)
    return row


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


def _planned(found: Inspection) -> float | None:
    """Return how long it takes to plan sliding the part by half its size, lying; None: too long."""
    D, rest = found.body.diagonal, found.rests[0]
    turn = Pose.from_quaternion(np.zeros(3), rest.rotation).rotation
    shape = found.scenario.model.object.shape.model_dump(mode="json", exclude_none=True)
    for part in (shape.get("mesh", {}), *shape.get("pieces", ())):
        for key in ("vertices", "hull"):
            if key in part:
                part[key] = (np.array(part[key]) @ turn.T).tolist()
    areas = np.array([face.region.area for _, face in found.faces])
    largest = float(areas.max() / areas.sum())
    tree = {
        "format": "gm-ompl-scenario/1", "name": "mesh", "object": {"shape": shape, "mass": 0.2},
        "friction": {"environment": 0.4, "finger": 0.8},
        "fingers": {"count": 2, "radius": 0.05 * D, "max_normal_force": 10.0,
                    "placements": {"grid": [3, 3], "smallest_face": min(0.003, 0.5 * largest)}},
        "motion": {"start": {"position": [0.0, 0.0, rest.height]},
                   "path": [{"slide": {"by": [0.5 * D, 0.0, 0.0]}}]},
        "lattice": {"segments": 5}, "mechanics": {"z_min": 0.002},
        "cost": {"regrasp": D, "stability": 0.001 * D},
    }  # fmt: skip
    scenario = Scenario.from_resolved(tree)
    started = time.perf_counter()
    plan = gm_ompl.plan(scenario, planner="HybridRRTConnect", time_limit=PLAN_S, seed=1)
    return time.perf_counter() - started if plan.cost is not None else None


def cells(row: MeshFound) -> tuple[object, ...]:
    """Return a mesh's row of the table."""
    planned = "-" if row.plan_s is None else f"{row.plan_s:.1f}"
    numbers = (row.pieces, f"{row.deviation:.1e}", f"{row.load_s:.1f}", planned)
    return (row.mesh, row.triangles, row.verdict, row.keys, *numbers)


def main(arguments: list[str]) -> None:
    """Try every mesh without a result, and write the table; ``--decompose`` tries that, too."""
    store = BUILD / "meshes" / "rows.jsonl"
    store.parent.mkdir(parents=True, exist_ok=True)
    known = {}
    if store.exists():
        known = {r["mesh"]: MeshFound(**r) for r in map(json.loads, store.read_text().splitlines())}
    gm_ompl.plan("paper/push", planner="HybridRRTConnect", max_iterations=50)  # compiles
    for name, file in meshes():
        if name not in known:
            row = attempt(name, file, "--decompose" in arguments)
            with store.open("a") as out:
                out.write(json.dumps(row.__dict__) + "\n")
            known[name] = row
    content = table(HEAD, [cells(row) for row in known.values()])
    write_tables(ROOT / "docs" / "results" / "meshes.md", {"meshes": content})


if __name__ == "__main__":
    main(sys.argv[1:])
