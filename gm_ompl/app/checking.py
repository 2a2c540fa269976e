"""``gm-ompl check``."""

from __future__ import annotations

from pathlib import Path

from gm_ompl import api
from gm_ompl.app.exits import Exit
from gm_ompl.app.output import say, say_json
from gm_ompl.plan.model import Plan


def check_command(plan_file: Path, as_json: bool) -> Exit:
    """Judge the plan in ``plan_file`` and show what holds."""
    report = api.check(Plan.load(plan_file))
    if as_json:
        say_json(report.to_dict())
    else:
        say(report.table())
    return Exit.OK if report.holds else Exit.REFUTED
