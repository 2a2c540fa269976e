"""The hand: placements on the object's faces, limits per finger, given starts and goals."""

from __future__ import annotations

import numpy as np

from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.surface import PlacementTable, face_areas, face_labels, placements
from gm_ompl.problem import Fingers
from gm_ompl.scenario.fields import per_finger
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import Placed, ScenarioModel

MAX_PLACEMENTS = 200_000
"""More grid points than this on all faces together are refused."""

MESH_MARGIN = 1e-3
"""Least distance of a placement from its face's rim on a mesh, relative to D."""

MESH_SMALLEST_FACE = 1e-4
"""Faces of a mesh with less than this part of its surface get no placements."""


def make_fingers(model: ScenarioModel, body: Body, notes: Notes) -> Fingers | None:
    """Return the hand, or None after noting what is wrong with it."""
    chosen = model.fingers.placements
    labels = face_labels(body)
    names = _faces(model, body, labels)
    total = chosen.grid[0] * chosen.grid[1] * len(names)
    if total > MAX_PLACEMENTS:
        wanted = f"gives {total} placements, more than {MAX_PLACEMENTS}; use a coarser grid"
        notes.wrong(("fingers", "placements", "grid"), list(chosen.grid), wanted)
    for i, name in enumerate(names):
        if name not in labels:
            wanted = f"no such face; the faces are {', '.join(labels)}"
            notes.wrong(("fingers", "placements", "faces", i), name, wanted)
    if notes.problems:
        return None
    margin = chosen.margin
    if margin is None:
        margin = MESH_MARGIN * body.diagonal if model.object.shape.mesh is not None else 0.0
    table = placements(body, (chosen.grid[0], chosen.grid[1]), names, margin)
    n = model.fingers.count
    return Fingers(
        radius=np.array(per_finger(model.fingers.radius, n)),
        max_normal_force=np.array(per_finger(model.fingers.max_normal_force, n)),
        friction=np.array(per_finger(model.friction.finger, n)),
        placements=table,
        start=_hand(model, "start", table, notes),
        goal=_hand(model, "goal", table, notes),
    )


def _faces(model: ScenarioModel, body: Body, labels: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the faces with placements."""
    chosen = model.fingers.placements
    if not isinstance(chosen.faces, str):
        return tuple(str(face) for face in chosen.faces)
    least = chosen.smallest_face
    if least is None:
        least = MESH_SMALLEST_FACE if model.object.shape.mesh is not None else 0.0
    if least == 0.0:
        return labels
    areas = face_areas(body)
    return tuple(
        label for label, area in zip(labels, areas, strict=True) if area >= least * areas.sum()
    )


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
                wanted = f"no placement there; the faces are {', '.join(table.labels)}"
                notes.wrong(path, {"face": str(placed.face), "cell": list(placed.cell)}, wanted)
        rows.append(row)
    return tuple(rows)
