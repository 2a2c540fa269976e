"""``gm-ompl view``."""

from __future__ import annotations

import sys
from pathlib import Path

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, say, writable
from gm_ompl.app.show_verbs import ViewVerb
from gm_ompl.plan import files
from gm_ompl.plan.model import Plan


def view_command(request: ViewVerb) -> Exit:
    """Show the plan in the browser until interrupted, or write its page."""
    target = writable(request.html, "--html")
    plan = Plan.load(request.plan_file)
    if target is not None:
        write_html(plan, target)
        note(f"written to {request.html}")
        return Exit.OK
    from gm_ompl.viz.page import page
    from gm_ompl.viz.server import address, serving

    text = page(plan)
    with serving(lambda: text, request.port) as server:
        try:
            say(f"{request.plan_file} is shown at {address(server)} (Ctrl-C ends)")
            sys.stdout.flush()
            server.serve_forever()
        except KeyboardInterrupt:
            note("")  # the terminal shows ^C on the line
    return Exit.OK


def write_html(plan: Plan, target: Path) -> None:
    """Write the stand-alone page of ``plan``."""
    from gm_ompl.viz.page import page

    files.write(target, page(plan))
