"""``gm-ompl explain``."""

from __future__ import annotations

import math
import re

from gm_ompl import api
from gm_ompl.app.exits import Exit
from gm_ompl.app.explain_text import lines
from gm_ompl.app.output import say, say_json, show_warnings
from gm_ompl.app.plan_verbs import ExplainVerb
from gm_ompl.errors import InputError

_PLACEMENT = re.compile(r"([^:,\s]+):(?:(\d+)\.(\d+)|\[\s*(\d+)\s*,\s*(\d+)\s*\])")


def explain_command(request: ExplainVerb) -> Exit:
    """Explain a scenario and show it."""
    at = None if request.at is None else read_coordinates(request.at)
    places = None if request.placements is None else read_placements(request.placements)
    scenario = api.load(request.scenario, request.overrides or ())
    show_warnings(scenario)
    explanation = api.explain(
        scenario,
        at,
        places,
        samples=request.samples,
        seed=request.seed,
        time_limit=request.time_limit,
    )
    if request.as_json:
        say_json(explanation.to_dict())
    else:
        for line in lines(explanation):
            say(line)
    return Exit.OK


def read_placements(text: str) -> list[tuple[str, tuple[int, int]]]:
    """Return (face, cell) per finger from "FACE:i.j,FACE:[i,j]".

    Raises:
        InputError: the text is something else.
    """
    found, at = [], 0
    while at <= len(text):
        match = _PLACEMENT.match(text.strip(), at)
        if match is None:
            break
        face, *cell = match.groups()
        i, j = (int(part) for part in cell if part is not None)
        found.append((face, (i, j)))
        at = match.end()
        if at == len(text.strip()):
            return found
        if text.strip()[at] != ",":
            break
        at += 1
    raise InputError(
        f"--placements {text!r}: must be FACE:CELL per finger, separated by commas, CELL as i.j "
        "or [i,j]; for example -x:3.2,+z:[0,1]"
    )


def read_coordinates(text: str) -> list[float]:
    """Return object coordinates from "S", or "X,Y,YAW" in the plane (yaw in rad, or "90 deg").

    Raises:
        InputError: the text is something else.
    """
    values = []
    for part in text.split(","):
        number, unit = part.strip(), 1.0
        if number.endswith("deg"):
            number, unit = number[:-3], math.pi / 180.0
        elif number.endswith("rad"):
            number = number[:-3]
        try:
            values.append(float(number) * unit)
        except ValueError:
            raise InputError(
                f"--at {text!r}: must be a number (from 0 to 1 along a path), or X,Y,YAW"
            ) from None
    return values
