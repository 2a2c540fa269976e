"""``gm-ompl export``."""

from __future__ import annotations

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, writable
from gm_ompl.app.show_verbs import ExportVerb
from gm_ompl.errors import InputError
from gm_ompl.plan.model import Plan
from gm_ompl.simulation.export import table
from gm_ompl.simulation.pace import Pace


def export_command(request: ExportVerb) -> Exit:
    """Write the plan over time as CSV."""
    target = writable(request.output)
    assert target is not None
    text = table(Plan.load(request.plan_file), Pace(speed=request.speed), request.rate)
    try:
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"-o {request.output}: cannot be written: {error.strerror}") from error
    note(f"written to {request.output}")
    return Exit.OK
