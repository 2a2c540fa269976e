"""``gm-ompl export``."""

from __future__ import annotations

from pathlib import Path

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, writable
from gm_ompl.plan.model import Plan
from gm_ompl.simulation.export import table
from gm_ompl.simulation.pace import Pace
from gm_ompl.writing import write_text


def export_command(plan_file: Path, output: Path, speed: float, rate: float) -> Exit:
    """Write the plan over time as CSV."""
    target = writable(output)
    assert target is not None
    text = table(Plan.load(plan_file), Pace(speed=speed), rate)
    write_text(target, text)
    note(f"written to {output}")
    return Exit.OK
