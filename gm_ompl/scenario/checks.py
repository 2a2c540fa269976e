"""What a scenario's values must satisfy together, beyond each value's own kind.

A check names the sections it reads: where others are wrong, all mistakes are seen at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from pydantic import BaseModel

from gm_ompl.errors import did_you_mean
from gm_ompl.scenario.combination_checks import combination_findings
from gm_ompl.scenario.document import Path
from gm_ompl.scenario.fields import BoxModel, MeshUse, per_finger
from gm_ompl.scenario.free_checks import free_findings, free_lattice_findings
from gm_ompl.scenario.model import ScenarioModel
from gm_ompl.scenario.motion_checks import Finding, lattice_findings, motion_findings, one_of
from gm_ompl.scenario.placements import Placed
from gm_ompl.scenario.uncertain import FLOOR, uncertainty_findings

MOST = 1e15
"""No number is larger: products of a few, as in an inertia, must stay finite."""

LEAST = 1e-15
"""Nor is one that must be positive smaller, for the same reason."""

THINNEST = 1e-5
"""The shortest side of a box, of its longest, whatever the contact tolerance."""

MOST_FRICTION = 1e4
"""The flattest cone: its edges are within 0.01 deg of the surface."""

MOST_WEIGHTS = 1e5
"""The strongest finger, in weights of the object: tolerances count in these."""

BOX_FACES = ("+x", "-x", "+y", "-y", "+z", "-z")


def findings(model: ScenarioModel, valid: set[str]) -> Iterator[Finding]:
    """Yield every mistake; only sections named in ``valid`` are read."""
    for section in sorted(valid):
        yield from _magnitudes((section,), getattr(model, section))
    for needs, check in CHECKS:
        if needs <= valid:
            yield from check(model)


def _magnitudes(path: Path, part: object) -> Iterator[Finding]:
    """Yield the numbers whose products would overflow."""
    if isinstance(part, float) and abs(part) > MOST:
        yield path, part, f"must be from {-MOST:g} to {MOST:g}; use other units"
    elif isinstance(part, BaseModel):
        for key in type(part).model_fields:
            yield from _magnitudes((*path, key), getattr(part, key))
    elif isinstance(part, dict):
        for key, value in part.items():
            yield from _magnitudes((*path, key), value)
    elif isinstance(part, tuple):
        for i, value in enumerate(part):
            yield from _magnitudes((*path, i), value)


SHAPES = ("box", "hull", "mesh", "pieces")


def _shape(path: Path, part: Any) -> Iterator[Finding]:
    yield from one_of(path, part, SHAPES)
    yield from _mesh_keys(path, part)
    for i, piece in enumerate(part.pieces or ()):
        yield from one_of((*path, "pieces", i), piece, ("box", "hull"))
        yield from _box((*path, "pieces", i, "box"), piece.box)


def _uses(part: MeshUse) -> dict[str, tuple[str, bool]]:
    """Return what keys beside a shape are for, and whether it is such a shape."""
    mesh, hull = part.mesh is not None, getattr(part, "hull", None) is not None
    file = isinstance(part.mesh, str)
    made = hull or (mesh and not file) or getattr(part, "pieces", None) is not None
    keys = ("frame", "weld", "bodies", "simplify", "convex")
    return {
        "scale": ("a mesh file", file),
        "flat": ("a mesh or hull", mesh or hull),
        "deviation": ("a shape in a plan", made),
        **dict.fromkeys(keys, ("a mesh", mesh)),
    }


def _mesh_keys(path: Path, part: Any) -> Iterator[Finding]:
    for key, (use, fits) in _uses(part).items():
        value = getattr(part, key)
        if value is not None and not fits:
            given = value.model_dump(exclude_none=True) if isinstance(value, BaseModel) else value
            yield (*path, key), given, f"only for {use}; leave it out"
        elif value is not None and key != "deviation" and part.deviation is not None:
            wanted = "not with deviation, which says that it was done; leave out one"
            yield (*path, key), value, wanted


def _box(path: Path, box: BoxModel | None) -> Iterator[Finding]:
    if box is not None:
        for i, (low, high) in enumerate(zip(box.min, box.max, strict=True)):
            if not low < high:
                yield (*path, "max", i), high, f"must be > min, which is {low!r}"


def _object(model: ScenarioModel) -> Iterator[Finding]:
    shape = model.object.shape
    yield from _shape(("object", "shape"), shape)
    longest = max(shape.box or (0.0,))
    for i, side in enumerate(shape.box or ()):
        if longest <= MOST and side < max(LEAST, THINNEST * longest):
            least = f"must be >= {LEAST:g} and at least {THINNEST:g} of the longest side"
            yield ("object", "shape", "box", i), side, least
    centre, inertia = model.object.centre_of_mass, model.object.inertia
    if (centre is None) != (inertia is None):
        missing = "inertia" if inertia is None else "centre_of_mass"
        wanted = "missing; give both centre_of_mass and inertia, or neither for uniform density"
        yield ("object", missing), ..., wanted
    if inertia is not None:
        yield from _inertia(np.array(inertia))


def _inertia(J: np.ndarray[Any, np.dtype[np.float64]]) -> Iterator[Finding]:
    path, value = ("object", "inertia"), J.tolist()
    scale = float(np.abs(J).max())
    if not np.allclose(J, J.T, rtol=0, atol=1e-9 * scale):
        yield path, value, "must be symmetric"
        return
    least, middle, most = np.linalg.eigvalsh(J)
    if least <= 1e-12 * scale:
        yield path, value, "must be positive definite (all principal moments > 0)"
    elif most > (least + middle) * (1 + 1e-9):
        yield path, value, "no principal moment may exceed the sum of the other two"


def _per_finger(path: Path, value: object, count: int) -> Iterator[Finding]:
    if isinstance(value, tuple) and len(value) != count:
        yield path, list(value), f"needs one entry per finger: {count} (fingers.count)"


def _fingers(model: ScenarioModel) -> Iterator[Finding]:
    fingers = model.fingers
    for key in ("radius", "max_normal_force", "soft", "clearance"):
        yield from _per_finger(("fingers", key), getattr(fingers, key), fingers.count)
    yield from _soft(model)
    if fingers.leave and not fingers.transit:
        yield ("fingers", "leave"), True, "needs fingers.transit: true, without which nobody leaves"
    for key in ("start", "goal"):
        hand = getattr(fingers, key)
        if isinstance(hand, tuple):
            if len(hand) != fingers.count:
                wanted = f"needs one entry per finger, has {len(hand)}; fingers.count is "
                yield ("fingers", key), ..., f"{wanted}{fingers.count}"
            yield from _hand(model, ("fingers", key), hand)
    faces = fingers.placements.faces
    if not isinstance(faces, str):
        names = [str(face) for face in faces]
        for i, name in enumerate(names):
            if name in names[:i]:
                yield ("fingers", "placements", "faces", i), name, "given twice; keep one"


def _soft(model: ScenarioModel) -> Iterator[Finding]:
    """Compare the lengths of soft fingertips with their radii."""
    radius, soft = model.fingers.radius, model.fingers.soft
    radii, lengths = (x if isinstance(x, tuple) else (x,) for x in (radius, soft))
    for i, length in enumerate(lengths):
        least = radii[i] if len(radii) == len(lengths) else min(radii)
        if least < length <= MOST:
            path: Path = ("fingers", "soft", *((i,) if isinstance(soft, tuple) else ()))
            yield path, length, f"must be at most the fingertip's radius, {least:g}"


def _cost(model: ScenarioModel) -> Iterator[Finding]:
    floor, z_min = model.cost.z_floor, model.mechanics.z_min
    if (model.cost.samples_at, model.cost.samples_per_arc) == ("ends", 1):
        yield ("cost", "samples_per_arc"), 1, "must be >= 2 with samples_at: ends"
    if floor is not None and floor < LEAST:
        yield ("cost", "z_floor"), floor, f"must be >= {LEAST:g}; use other units"
    elif floor is not None and 0.0 < z_min < floor <= MOST:
        yield ("cost", "z_floor"), floor, f"must be <= mechanics.z_min, {z_min:g}, where it is > 0"


def _hand(model: ScenarioModel, path: Path, hand: Iterable[object]) -> Iterator[Finding]:
    placements = model.fingers.placements
    allowed = None if isinstance(placements.faces, str) else [str(f) for f in placements.faces]
    seen: dict[tuple[str, tuple[int, ...]], int] = {}
    for i, placed in enumerate(hand):
        if not isinstance(placed, Placed):
            continue
        for k in (0, 1):
            if placed.cell[k] >= placements.grid[k]:
                last = placements.grid[k] - 1
                yield (*path, i, "cell", k), placed.cell[k], f"the grid's last cell is {last}"
        name = str(placed.face)
        if allowed is not None and name not in allowed:
            wanted = f"not among fingers.placements.faces ({', '.join(allowed)})"
            yield (*path, i, "face"), name, wanted
        first = seen.setdefault((name, placed.cell), i)
        if first != i:
            yield (*path, i), ..., f"same place as finger {first}; fingers must be apart"


def _box_faces(model: ScenarioModel) -> Iterator[Finding]:
    if model.object.shape.box is None:
        return
    named: list[tuple[Path, object]] = []
    faces = model.fingers.placements.faces
    if not isinstance(faces, str):
        where = ("fingers", "placements", "faces")
        named += [((*where, i), face) for i, face in enumerate(faces)]
    for key in ("start", "goal"):
        hand = getattr(model.fingers, key)
        if isinstance(hand, tuple):
            named += [
                (("fingers", key, i, "face"), placed.face)
                for i, placed in enumerate(hand)
                if isinstance(placed, Placed)
            ]
    for path, face in named:
        if str(face) not in BOX_FACES:
            hint = did_you_mean(str(face), BOX_FACES)
            yield path, face, f"a box has the faces {', '.join(BOX_FACES)}{hint}"


def _strength(model: ScenarioModel) -> Iterator[Finding]:
    """Compare the fingers with the object's weight."""
    mass, limit = model.object.mass, model.fingers.max_normal_force
    if mass < LEAST:
        yield ("object", "mass"), mass, f"must be >= {LEAST:g}; use other units"
        return
    weight = mass * model.gravity
    limits = limit if isinstance(limit, tuple) else (limit,)
    for i, value in enumerate(limits):
        path: Path = ("fingers", "max_normal_force", *((i,) if limits is limit else ()))
        if value < LEAST:
            yield path, value, f"must be >= {LEAST:g}; use other units"
        elif model.gravity > 0 and MOST_WEIGHTS * weight < value <= MOST:
            yield (
                path,
                value,
                f"more than {MOST_WEIGHTS:g} times the object's weight, {weight:.6g}; too much for "
                "the mechanics' tolerances: lower it, or leave gravity out (gravity: 0)",
            )


def _friction(model: ScenarioModel) -> Iterator[Finding]:
    for key in ("environment", "finger"):
        given = getattr(model.friction, key)
        for i, value in enumerate(given if isinstance(given, tuple) else (given,)):
            if MOST_FRICTION < value <= MOST:
                path: Path = ("friction", key, *((i,) if isinstance(given, tuple) else ()))
                yield path, value, f"must be <= {MOST_FRICTION:g}"
    yield from _per_finger(("friction", "finger"), model.friction.finger, model.fingers.count)


def _environment(model: ScenarioModel) -> Iterator[Finding]:
    for name, obstacle in model.environment.obstacles.items():
        path: Path = ("environment", "obstacles", name)
        yield from _shape(path, obstacle)
        if isinstance(obstacle.box, BoxModel):
            yield from _box((*path, "box"), obstacle.box)


def _uncertainty(model: ScenarioModel) -> Iterator[Finding]:
    given, names = model.uncertainty, (FLOOR, *sorted(model.environment.obstacles))
    if given is not None:
        yield from uncertainty_findings(given, frictions(model), model.object.mass, names)


def frictions(model: ScenarioModel) -> tuple[float, tuple[float, ...]]:
    """Return the Coulomb coefficients of the environment and of each finger."""
    return model.friction.environment, per_finger(model.friction.finger, model.fingers.count)


def _expect(model: ScenarioModel) -> Iterator[Finding]:
    between = model.expect.regrasp_between
    if between is not None and not between[0] <= between[1]:
        yield ("expect", "regrasp_between"), [*between], "the first must not exceed the second"


CHECKS: tuple[tuple[set[str], Callable[[ScenarioModel], Iterator[Finding]]], ...] = (
    ({"object"}, _object),
    ({"fingers"}, _fingers),
    ({"object", "fingers"}, _box_faces),
    ({"friction", "fingers"}, _friction),
    ({"object", "fingers", "gravity"}, _strength),
    ({"environment"}, _environment),
    ({"motion"}, motion_findings),
    ({"motion"}, free_findings),
    ({"motion", "lattice"}, lattice_findings),
    ({"motion", "lattice"}, free_lattice_findings),
    ({"mechanics", "cost"}, _cost),
    ({"fingers", "mechanics", "motion", "hand", "uncertainty"}, combination_findings),
    ({"uncertainty", "friction", "fingers", "object", "environment"}, _uncertainty),
    ({"expect"}, _expect),
)
