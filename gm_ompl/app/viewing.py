"""``gm-ompl view``."""

from __future__ import annotations

import sys
from pathlib import Path

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, say, writable
from gm_ompl.app.plan_files import opened
from gm_ompl.plan.model import Plan


def view_command(plan_file: Path, html: Path | None, port: int) -> Exit:
    """Show the plan in the browser until interrupted, or write its page."""
    target = writable(html, "--html")
    if target is not None:
        with opened(plan_file) as plan:
            write_html(plan, target)
        note(f"written to {html}")
        return Exit.OK
    from gm_ompl.viz.page import page
    from gm_ompl.viz.server import address, serving

    with opened(plan_file) as plan:
        text = page(plan)
    with serving(lambda: text, port) as server:
        try:
            say(f"{plan_file} is shown at {address(server)} (Ctrl-C ends)")
            sys.stdout.flush()
            server.serve_forever()
        except KeyboardInterrupt:
            note("")  # the terminal shows ^C on the line
    return Exit.OK


def write_html(plan: Plan, target: Path) -> None:
    """Write the stand-alone page of ``plan``."""
    from gm_ompl.viz.page import write_page

    write_page(plan, target)
