"""``gm-ompl check``."""

from __future__ import annotations

from gm_ompl import api
from gm_ompl.app.exits import Exit
from gm_ompl.app.output import say, say_json
from gm_ompl.app.plan_verbs import CheckVerb
from gm_ompl.plan.model import Plan


def check_command(request: CheckVerb) -> Exit:
    """Judge the plan in the file and show what holds."""
    report = api.check(Plan.load(request.plan_file))
    if request.as_json:
        say_json(report.to_dict())
    else:
        say(report.table())
    return Exit.OK if report.holds else Exit.REFUTED
