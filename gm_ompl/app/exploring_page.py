"""The page and its scripts, as texts."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import asdict

from gm_ompl.exploring.knobs import knobs
from gm_ompl.exploring.planners import names
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.viz.page import asset, embedded, escaped, filled
from gm_ompl.viz.scene import viewer_script

SCRIPTS = ("viewer.js", "page.js", "explore.js")


def site_files(scenario: Scenario, name: str, overrides: Sequence[str]) -> dict[str, str]:
    """Return the page, under the name "", and its scripts.

    Args:
        scenario: what is explored.
        name: what the user calls it.
        overrides: what is changed in it for all that is planned.
    """
    changes = " ".join(f"--set {shlex.quote(change)}" for change in overrides)
    setup = {
        "name": scenario.name,
        "command": f"gm-ompl plan {shlex.quote(name)} {changes}".strip(),
        "planners": names(),
        "knobs": [asdict(knob) for knob in knobs(scenario)],
    }
    tags = [f'<script type="application/json" id="setup">{embedded(setup)}</script>']
    tags += [f'<script src="{script}"></script>' for script in SCRIPTS]
    nothing = dict.fromkeys(("SUMMARY", "BANDS", "CHAIN", "FINGERS", "TOLERANCE"), "")
    page = filled({
        **nothing,
        "TITLE": escaped(scenario.name),
        "DESCRIPTION": escaped(scenario.model.description),
        "POLICY": "base-uri 'none'",  # the rest is in the headers
        "STYLE": asset("page.css") + asset("explore.css"),
        "KNOBS": asset("explore.html"),
        "SCRIPTS": "\n".join(tags),
    })  # fmt: skip
    return {"": page, "viewer.js": viewer_script()} | {name: asset(name) for name in SCRIPTS[1:]}
