"""``gm-ompl new``: a commented scenario to begin with, which can be planned as it is."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import typer

from gm_ompl.app.commands import Exit
from gm_ompl.app.completing import MOTIONS
from gm_ompl.app.output import note, writable
from gm_ompl.app.template import scenario_text
from gm_ompl.app.verbs import NewVerb
from gm_ompl.arrays import Array
from gm_ompl.errors import InputError, did_you_mean
from gm_ompl.geometry.pose import Pose
from gm_ompl.scenario.inspection import MESHES, inspect
from gm_ompl.writing import is_stdout, write_text

BOX: Final = (5.0, 5.0, 10.0)
UPRIGHT: Final = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Part:
    """The object that a scenario is written for.

    Attributes:
        name: what the scenario is called.
        shape: the value of ``object.shape``, as YAML.
        size: (3,), of its bounding box as it lies at the start.
        rotation: unit quaternion (w, x, y, z) that lays it on its steadiest face.
        comment: what stands above the shape.
    """

    name: str
    shape: str
    size: tuple[float, ...]
    rotation: tuple[float, ...]
    comment: str


def new_command(request: NewVerb) -> Exit:
    """Ask what is not said, write the scenario."""
    target = writable(request.output)
    asks = sys.stdin.isatty() and sys.stderr.isatty() and not request.yes
    ask = _asked if asks else _default
    mesh = request.mesh or ask("mesh file (none: a box)", "") or None
    part = _part_of(mesh, request, target) if mesh else _box(request.size, ask)
    mass = request.mass or _number("mass", ask("mass", "1"))
    fingers = request.fingers or int(_number("fingers", ask("fingers", "2")))
    motion = request.motion or ask(f"motion ({', '.join(MOTIONS)})", "slide")
    if motion not in MOTIONS:
        raise InputError(
            f"--motion {motion}: no such motion{did_you_mean(motion, MOTIONS)}; "
            f"there are: {', '.join(MOTIONS)}"
        )
    text = scenario_text(part.name, part.comment, part.shape, {
        "size": part.size, "rotation": part.rotation, "mass": mass, "fingers": fingers,
        "motion": motion,
    })  # fmt: skip
    if target is None or is_stdout(target):
        sys.stdout.write(text)
    else:
        write_text(target, text)
        note(f"written to {request.output}; next: gm-ompl plan {request.output} -o plan.json")
    return Exit.OK


def _asked(question: str, default: str) -> str:
    answer: str = typer.prompt(question, default=default, err=True)
    return answer.strip()


def _default(_question: str, default: str) -> str:
    return default


def _box(size: str | None, ask: Callable[[str, str], str]) -> Part:
    text = size or ask("size of the box, X,Y,Z", ",".join(f"{side:g}" for side in BOX))
    sides = tuple(_number("size", side) for side in text.split(","))
    if len(sides) != 3:
        raise InputError(f"--size {text}: must be three numbers, X,Y,Z")
    shape = f"{{box: [{', '.join(f'{side:g}' for side in sides)}]}}"
    return Part("my/box", shape, sides, UPRIGHT, "a box, by its size along x, y and z")


def _part_of(mesh: str, request: NewVerb, target: Path | None) -> Part:
    """Return the part in a mesh file, on the face on which it lies steadiest.

    Raises:
        InputError: ``--size`` is given as well, or the file is no mesh.
        ScenarioError: no such file, or no usable shape in it; the message names keys that help.
    """
    if request.size is not None:
        raise InputError(f"--size {request.size}: the mesh {mesh} has a size of its own")
    if not mesh.lower().endswith(MESHES):
        raise InputError(f"{mesh}: must be a mesh file: {', '.join(MESHES)}")
    changes = request.overrides or []
    found = inspect(mesh, changes)
    lying = found.rests[0].rotation if found.rests else np.array(UPRIGHT)
    turned: Array = found.body.vertices @ Pose.from_quaternion(np.zeros(3), lying).rotation.T
    folder = target.parent if target is not None and not is_stdout(target) else Path.cwd()
    file = os.path.relpath(Path(mesh).resolve(), folder)
    keys = [f"mesh: {_quoted(file)}", *(change.replace("=", ": ", 1) for change in changes)]
    size = " x ".join(f"{side:.4g}" for side in np.ptp(found.body.vertices, axis=0))
    comment = (
        f"{size} as drawn, in {len(found.body.pieces)} convex piece(s): gm-ompl inspect shows it"
    )
    return Part(
        f"my/{Path(mesh).stem}", f"{{{', '.join(keys)}}}",
        tuple(np.ptp(turned, axis=0).tolist()), tuple(lying.tolist()), comment,
    )  # fmt: skip


def _quoted(file: str) -> str:
    plain = file.replace("_", "").replace("-", "").replace(".", "").replace("/", "").isalnum()
    return file if plain else "'" + file.replace("'", "''") + "'"


def _number(name: str, text: Any) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise InputError(f"--{name} {text}: must be a positive number")
    return value
