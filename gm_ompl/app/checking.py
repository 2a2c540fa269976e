"""``gm-ompl check``."""

from __future__ import annotations

from pathlib import Path

from gm_ompl import api
from gm_ompl.app.exits import Exit
from gm_ompl.app.output import say, say_json
from gm_ompl.app.plan_files import opened


def check_command(plan_file: Path, as_json: bool) -> Exit:
    """Judge the plan in ``plan_file`` and show what holds."""
    with opened(plan_file) as plan:
        report = api.check(plan)
    if as_json:
        say_json(report.to_dict())
    else:
        say(report.table())
    return Exit.OK if report.holds else Exit.REFUTED
