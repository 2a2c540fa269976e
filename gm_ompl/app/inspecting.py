"""``gm-ompl inspect``: a shape in numbers, and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gm_ompl import limits
from gm_ompl.app.commands import Exit
from gm_ompl.app.output import note, say, say_json, writable
from gm_ompl.app.showing import check_viewer
from gm_ompl.app.verbs import InspectVerb
from gm_ompl.arrays import Array
from gm_ompl.geometry.solids import volume
from gm_ompl.scenario.inspection import Inspection, inspect
from gm_ompl.writing import write_text

SHOWN = 12  # resting poses, pieces and faces that are listed at most


def inspect_command(request: InspectVerb) -> Exit:
    """Show what is to know of a mesh, or of a scenario's object."""
    target = writable(request.html, "--html")
    if target is not None:
        check_viewer()
    with limits.holding(request.time_limit, request.memory_limit):
        found = inspect(request.mesh, request.overrides or ())
    if request.as_json:
        say_json(found.to_dict())
    else:
        for line in lines(found):
            say(line)
    if target is not None:
        from gm_ompl.viz.inspection import inspection_page

        write_text(target, inspection_page(found, "\n".join(lines(found))))
        note(f"shown in {request.html}")
    return Exit.OK


def lines(found: Inspection) -> Iterator[str]:
    """Yield the inspection for people."""
    body, mass = found.body, found.scenario.problem.mass
    yield f"{found.scenario.name}: {' x '.join(_numbers(np.ptp(body.vertices, axis=0)))}"
    if found.scenario.model.object.shape.deviation is not None:
        yield f"  deviation       {found.deviation:.3g} at most between the file's surface and this"
    yield f"  volume          {found.own.volume:.6g}"
    yield f"  centre of mass  {', '.join(_numbers(found.own.centre))} (in the shape's coordinates)"
    yield f"  inertia         about it, at mass {mass:g}"
    for row in np.asarray(found.scenario.problem.inertia):
        yield f"                  {'  '.join(f'{value:13.6g}' for value in row)}"
    resting = f"{len(found.rests)}, steadiest first" if found.rests else "none"
    yield from _listed("resting poses", resting, [
        f"{direction(pose.down)} down: height {pose.height:.9g}, falls beyond "
        f"{np.rad2deg(pose.tilt):.3g} deg, on {pose.corners} corners, "
        f"quaternion [{', '.join(_numbers(np.asarray(pose.rotation)))}]"
        for pose in found.rests
    ])  # fmt: skip
    sizes = [volume(piece) for piece in body.pieces]
    yield from _listed("convex pieces", f"{len(sizes)}", [
        f"{k}: {len(piece.vertices)} corners, {len(piece.faces)} faces, "
        f"{size / sum(sizes):.1%} of the volume"
        for k, (piece, size) in enumerate(zip(body.pieces, sizes, strict=True))
    ])  # fmt: skip
    areas = {name: face.region.area for name, face in found.faces}
    offered = [(name, face) for name, face in found.faces if name in found.offered]
    yield from _listed("faces", f"{len(areas)}; {len(offered)} of them offered to fingers", [
        f"{name}: {direction(face.normal)}, {areas[name] / sum(areas.values()):.1%} of the surface"
        for name, face in sorted(offered, key=lambda entry: -areas[entry[0]])
    ])  # fmt: skip


def _listed(what: str, head: str, rows: Sequence[str]) -> Iterator[str]:
    """Yield a heading and the first rows below it."""
    yield f"  {what:15s} {head}"
    yield from (f"    {row}" for row in rows[:SHOWN])
    if len(rows) > SHOWN:
        yield f"    and {len(rows) - SHOWN} more (--json has them all)"


def direction(vector: Array) -> str:
    """Return a unit vector as an axis ("-z") where it is one, else as numbers."""
    axis = int(np.abs(vector).argmax())
    if abs(vector[axis]) > 1.0 - 1e-9:
        return ("+" if vector[axis] > 0.0 else "-") + "xyz"[axis]
    return f"[{', '.join(f'{value:.3f}' for value in vector + 0.0)}]"


def _numbers(values: Array) -> list[str]:
    return [f"{value:.6g}" for value in values]
