"""The text of a new scenario: every value fits the object and says what it is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

GRAVITY: Final = 9.8

_TEXT: Final = """\
# yaml-language-server: $schema=scenario.schema.json
# A scenario for gm-ompl. Change what you like: unknown keys and unfit values are refused, with
# the line and what would be right. Lengths in one unit throughout (the shape's own), masses in kg:
# forces are then in newtons. `gm-ompl plan FILE -o plan.json` plans it.
format: gm-ompl-scenario/1
name: {name}
object:
  shape: {shape}  # {comment}
  mass: {mass}
friction: {{environment: 0.4, finger: 0.7}}  # Coulomb coefficients: floor and obstacles, fingertips
gravity: {gravity}
fingers:
  count: {fingers}
  radius: {radius}  # of the spherical fingertips; a list gives each its own
  max_normal_force: {force}  # what each finger can press with at most: here the object's weight
  placements: {{grid: [5, 5], faces: all}}  # where fingertips may be, on each face
environment:
  floor: true  # z = 0
  obstacles: {{}}
  #   wall: {{box: {{min: [{far}, -{far}, 0], max: [{farther}, {far}, {far}]}}}}
motion:
{motion}
mechanics:
  z_min: {z_min}  # the least disturbing force that must be resisted, all along
cost:
  regrasp: {regrasp}  # a regrasp costs as much as so long a way of the fingertips
  stability: {stability}  # how much a small margin costs; far below z_min
  samples_per_arc: 3
"""

_MOTIONS: Final = {
    "slide": """\
  start: {start}  # `rest` lowers the object onto what is below
  path:  # pieces follow each other; one more could be: tumble: {{towards: +x, angle: 90 deg}}
    - slide: {{by: [{x}, 0, 0]}}
lattice: {{segments: 10}}  # arcs per piece; more are finer and take longer""",
    "tumble": """\
  start: {start}  # `rest` lowers the object onto what is below
  path:  # pieces follow each other; one more could be: slide: {{by: [{x}, 0, 0]}}
    - tumble: {{towards: +x, angle: 90 deg}}  # about the bottom edge on that side
lattice: {{segments: 30}}  # arcs per piece; more are finer and take longer""",
    "planar": """\
  planar: {{x: [-{x}, {xx}], y: [-{x}, {x}], yaw: [-180 deg, 180 deg]}}  # x, y and yaw on the floor
  start: {start}  # `rest` lowers the object onto what is below
  goal: {{x: [{x}, {xx}], y: [-{x}, {x}], yaw: [90 deg, 90 deg]}}  # a place, or ranges
lattice: {{steps: {{x: {half}, y: {half}, yaw: 15 deg}}}}""",
    "free": """\
  free:  # start and goal only: how the object gets there is found
    region: {{x: [-{x}, {xx}], y: [0, 0], z: [0, {high}]}}  # of the centre of mass, all along
    translate: [x]  # axes along which it is moved, besides along its contacts
    rotate: [y]  # axes that it may turn about
  start: {start}  # `rest` lowers the object onto what is below
  goal: {{x: [{x}, {xx}], rotation: {{axis: [0, 1, 0], angle: 90 deg}}}}  # a place, or ranges
lattice: {{steps: {{translation: {half}, rotation: 30 deg}}, depth: 12}}""",
}


def scenario_text(name: str, comment: str, shape: str, given: Mapping[str, Any]) -> str:
    """Return the scenario as commented YAML.

    Args:
        name: what it is called.
        comment: what stands beside the shape.
        shape: the value of ``object.shape``, as YAML.
        given: ``size`` of the object as it lies (3 lengths), ``rotation`` (unit quaternion w, x, y,
            z), ``mass``, ``fingers`` (how many) and ``motion`` (a kind).
    """
    size, mass = given["size"], float(given["mass"])
    diagonal, weight = math.hypot(*size), mass * GRAVITY
    lengths = {
        "x": _short(size[0]), "xx": _short(2 * float(_short(size[0]))),
        "half": _short(0.5 * float(_short(size[0]))), "high": _short(diagonal),
        "start": _start(given["rotation"]),
    }  # fmt: skip
    return _TEXT.format(
        name=name,
        comment=comment,
        shape=shape,
        mass=f"{mass:g}",
        gravity=f"{GRAVITY:g}",
        fingers=given["fingers"],
        radius=_short(0.08 * diagonal),
        force=_short(weight),
        far=_short(2 * diagonal),
        farther=_short(2.2 * diagonal),
        motion=_MOTIONS[given["motion"]].format(**lengths),
        z_min=_short(0.02 * weight),
        regrasp=_short(10 * diagonal),
        stability=_short(0.001 * weight),
    )


def _start(rotation: Sequence[float]) -> str:
    turned = "" if rotation[0] == 1.0 else f", rotation: {{quaternion: {list(rotation)}}}"
    return f"{{position: [0, 0, rest]{turned}}}"


def _short(value: float) -> str:
    """Return a number with two digits, as YAML reads it."""
    return f"{float(f'{value:.2g}'):.12g}"
