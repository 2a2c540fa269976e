"""What a controller reads: timed poses, control modes and commanded forces, as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

import numpy as np

from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.schedule import schedule
from gm_ompl.simulation.timeline import PHASES, Pace, Timeline

POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def table(plan: Plan, pace: Pace | None = None, rate: float = 100.0) -> str:
    """Return the plan over time as CSV with a commented header, ``rate`` rows per second.

    Raises:
        InputError: the plan moves nothing, or ``rate`` is no rate.
    """
    if not (np.isfinite(rate) and 1.0 <= rate <= 10000.0):
        raise InputError(f"--rate {rate}: must be from 1 to 10000 rows per second")
    pace = pace or Pace()
    problem = problem_of(plan)
    line = schedule(plan, problem, pace, 1.0 / rate)
    out = io.StringIO()
    for text in _header(problem.name, line, pace):
        out.write(f"# {text}\n")
    rows = [_row(line, k) for k in range(len(line))]
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def _header(name: str, line: Timeline, pace: Pace) -> list[str]:
    return [
        f"gm-ompl export of a plan for {name}",
        "world frame: right-handed, z up, gravity along -z, origin as in the scenario",
        "units: time in seconds; lengths and forces in the scenario's own units",
        "object: pose of its centre of mass; quaternion (w, x, y, z), object to world",
        "finger i: pose of the fingertip's centre; it turns with the object",
        "mode: position, force, switch (between the two) or free (no contact planned)",
        "f_com: commanded normal force along the normal (nx, ny, nz), which points into the",
        "object; empty but under force control and in a switch",
        "lean: force (x, y, z) to lean on the object with where position is controlled",
        "phase: settle, approach, switch, move, lift, transit or land",
        f"pace: fastest vertex {pace.speed:g} diagonals of the object per second",
        *(f"note: {note}" for note in line.notes),
    ]


def _row(line: Timeline, k: int) -> dict[str, str]:
    """Return instant ``k`` by the names of the columns."""
    turn = Pose(line.rotation[k], line.position[k]).quaternion()
    row = {"time": f"{line.time[k]:.6f}", "phase": PHASES[line.phase[k]], "step": f"{line.step[k]}"}

    def add(what: str, names: Sequence[str], *values: float) -> None:
        numbers = zip(names, values, strict=True)
        row.update({f"{what}_{name}": f"{value + 0.0:.9g}" for name, value in numbers})

    add("object", POSE, *line.position[k], *turn)
    for i in range(line.fingers):
        finger = f"finger{i}"
        add(finger, POSE, *line.centre[k, i], *turn)
        add(finger, ("nx", "ny", "nz"), *line.normal[k, i])
        row[f"{finger}_mode"] = mode = instant_mode(line, k, i)
        row[f"{finger}_f_com"] = ""
        if mode in ("force", "switch"):
            add(finger, ("f_com",), line.f_com[k, i])
        add(f"{finger}_lean", ("x", "y", "z"), *line.lean[k, i])
    return row


def instant_mode(line: Timeline, k: int, i: int) -> str:
    """Return a finger's mode at an instant: position, force, switch or free."""
    if not line.down[k, i]:
        return "free"
    share = float(line.force_share[k, i])
    return "force" if share >= 1.0 else "position" if share <= 0.0 else "switch"
