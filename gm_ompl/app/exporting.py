"""``gm-ompl export``."""

from __future__ import annotations

from pathlib import Path

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, writable
from gm_ompl.app.plan_files import opened
from gm_ompl.errors import InputError
from gm_ompl.simulation.export import table
from gm_ompl.simulation.pace import Pace


def export_command(plan_file: Path, output: Path, speed: float, rate: float) -> Exit:
    """Write the plan over time as CSV."""
    target = writable(output)
    assert target is not None
    with opened(plan_file) as plan:
        text = table(plan, Pace(speed=speed), rate)
    try:
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"-o {output}: cannot be written: {error.strerror}") from error
    note(f"written to {output}")
    return Exit.OK
