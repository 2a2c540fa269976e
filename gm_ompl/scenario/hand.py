"""The hand: placements on the object's faces, limits per finger, given starts and goals."""

from __future__ import annotations

import math

import numpy as np

from gm_ompl.geometry.patches import Anywhere
from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.surface import PlacementTable, face_areas, face_labels, placements, room
from gm_ompl.problem import Fingers
from gm_ompl.scenario.document import Path
from gm_ompl.scenario.fields import per_finger
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import ScenarioModel
from gm_ompl.scenario.placements import Placed
from gm_ompl.scenario.shapes import is_mesh

MAX_PLACEMENTS = 200_000
"""More grid points than this on all faces together are refused."""

MESH_MARGIN = 1e-3
"""Least distance of a placement from its face's rim on a mesh, relative to D."""

MESH_SMALLEST_FACE = 1e-4
"""Faces of a mesh with less than this part of its surface get no placements."""

CLEARANCE = 0.5
"""How much wider than a fingertip a gap is that counts as open, in its radii, unless said."""

WHERE: Path = ("fingers", "placements")


def make_fingers(model: ScenarioModel, body: Body, notes: Notes) -> Fingers | None:
    """Return the hand, or None after noting what is wrong with it."""
    chosen = model.fingers.placements
    labels = face_labels(body)
    names = _faces(model, body, labels)
    total = chosen.grid[0] * chosen.grid[1] * len(names)
    if total > MAX_PLACEMENTS:
        wanted = f"gives {total} placements, more than {MAX_PLACEMENTS}; use a coarser grid"
        notes.wrong((*WHERE, "grid"), list(chosen.grid), wanted)
    for i, name in enumerate(names):
        if name not in labels:
            wanted = f"no such face; the faces are {', '.join(labels)}"
            notes.wrong((*WHERE, "faces", i), name, wanted)
    if notes.problems:
        return None
    grid = (chosen.grid[0], chosen.grid[1])
    table = placements(body, grid, names, margin_of(model, body))
    n = model.fingers.count
    if n and not len(table):
        _no_placement(model, body, names, notes)
        return None
    radius = np.array(per_finger(model.fingers.radius, n))
    clearance = model.fingers.clearance
    return Fingers(
        radius=radius,
        max_normal_force=np.array(per_finger(model.fingers.max_normal_force, n)),
        friction=np.array(per_finger(model.friction.finger, n)),
        soft=np.array(per_finger(model.fingers.soft, n)),
        placements=table,
        start=_hand(model, "start", table, notes),
        goal=_hand(model, "goal", table, notes),
        clearance=CLEARANCE * radius if clearance is None else np.array(per_finger(clearance, n)),
        transit=model.fingers.transit,
        leave=model.fingers.leave,
        named=model.hand is not None,
        anywhere=_anywhere(model, names),
    )


def _anywhere(model: ScenarioModel, names: tuple[str, ...]) -> Anywhere | None:
    given = model.fingers.placements.continuous
    return None if given is None else Anywhere(names, given.margin, given.gap)


def margin_of(model: ScenarioModel, body: Body) -> float:
    """Return the least distance of a placement from its face's rim."""
    chosen = model.fingers.placements
    margin = chosen.margin if chosen.continuous is None else chosen.continuous.margin
    if margin is not None:
        return margin
    return MESH_MARGIN * body.diagonal if is_mesh(model.object.shape) else 0.0


def _smallest_face(model: ScenarioModel) -> float:
    least = model.fingers.placements.smallest_face
    if least is not None:
        return least
    return MESH_SMALLEST_FACE if is_mesh(model.object.shape) else 0.0


def _faces(model: ScenarioModel, body: Body, labels: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the faces with placements."""
    chosen, least = model.fingers.placements, _smallest_face(model)
    if not isinstance(chosen.faces, str):
        return tuple(str(face) for face in chosen.faces)
    if least == 0.0:
        return labels
    areas = face_areas(body)
    return tuple(
        label for label, area in zip(labels, areas, strict=True) if area >= least * areas.sum()
    )


def offered_faces(model: ScenarioModel, body: Body) -> tuple[str, ...]:
    """Return the names of the faces on which fingers may be placed."""
    return _faces(model, body, face_labels(body))


def _no_placement(model: ScenarioModel, body: Body, names: tuple[str, ...], notes: Notes) -> None:
    """Note which key leaves the fingers no placement at all, and what would leave one."""
    chosen = model.fingers.placements
    if not names:
        areas = face_areas(body)
        most = _rounded_down(float(areas.max() / areas.sum()), 1.0)
        wanted = (
            "leaves no face for the fingers: the largest has "
            f"{most:g} of the surface; must be at most that"
        )
        _blame("smallest_face", chosen.smallest_face, _smallest_face(model), wanted, notes)
        return
    widest = room(body, (chosen.grid[0], chosen.grid[1]), names)
    if widest is not None:
        wanted = (
            "leaves the fingers no placement: with this grid and these faces it must be at most "
            f"{_rounded_down(widest, body.diagonal):g}"
        )
        if chosen.continuous is not None:
            path = (*WHERE, "continuous", "margin")
            notes.wrong(path, chosen.continuous.margin, wanted)
        else:
            _blame("margin", chosen.margin, margin_of(model, body), wanted, notes)
        return
    wanted = (
        "leaves the fingers no placement: every cell's centre is off its face, in a hole or under "
        "another piece; use another grid or other faces"
    )
    notes.wrong((*WHERE, "grid"), list(chosen.grid), wanted)


def _blame(key: str, given: float | None, value: float, wanted: str, notes: Notes) -> None:
    """Note that a key's value, or its default for meshes, is wrong."""
    if given is None:
        wanted = f"the default for a mesh, {value:g}, {wanted}"
        notes.add((*WHERE, key), wanted)
    else:
        notes.wrong((*WHERE, key), given, wanted)


def _rounded_down(value: float, scale: float) -> float:
    """Return ``value`` with four digits, not larger; 0 where it is rounding of ``scale``."""
    if value <= 1e-9 * scale:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return float(f"{math.floor(value / unit * (1 + 1e-12)) * unit:.12g}")


def _hand(
    model: ScenarioModel, key: str, table: PlacementTable, notes: Notes
) -> tuple[int | None, ...]:
    hand = getattr(model.fingers, key)
    if isinstance(hand, str):
        return (None,) * model.fingers.count
    rows: list[int | None] = []
    for i, placed in enumerate(hand):
        row = None
        if isinstance(placed, Placed):
            row = table.find(str(placed.face), placed.cell)
            if row is None:
                path = ("fingers", key, i)
                wanted = _nowhere(placed, table)
                notes.wrong(path, {"face": str(placed.face), "cell": list(placed.cell)}, wanted)
        rows.append(row)
    return tuple(rows)


def _nowhere(placed: Placed, table: PlacementTable) -> str:
    """Return why there is no such placement."""
    name = str(placed.face)
    if name not in table.labels:
        return f"no placement there; the faces are {', '.join(table.labels)}"
    here = table.cell[table.face == table.labels.index(name)]
    if len(here):
        near = here[np.abs(here - np.array(placed.cell)).sum(axis=1).argmin()].tolist()
        return (
            "no placement there: the cell's centre is off the face, in a hole, covered or nearer "
            f"to the rim than fingers.placements.margin; the nearest cell with one is {near}"
        )
    used = ", ".join(table.labels[k] for k in np.unique(table.face))
    return (
        "no placement on this face: fingers.placements (faces, smallest_face, margin, grid) "
        f"leave some on {used} alone"
    )
