"""``gm-ompl list``."""

from __future__ import annotations

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, say, say_json
from gm_ompl.app.plan_verbs import ListVerb
from gm_ompl.scenario.load import random_names, read, shipped

KEYS = ("name", "description", "source")


def list_command(request: ListVerb) -> Exit:
    """Show the shipped scenarios and name the random families."""
    rows = []
    for name in shipped():
        tree = read(name).tree  # the text alone: nothing is built
        fields = tree if isinstance(tree, dict) else {}
        rows.append({"name": name} | {key: str(fields.get(key, "")) for key in KEYS[1:]})
    if request.as_json:
        say_json({"scenarios": rows, "families": list(random_names())})
        return Exit.OK
    widths = [max((len(row[key]) for row in rows), default=0) for key in KEYS]
    for row in rows:
        cells = (row[key].ljust(width) for key, width in zip(KEYS, widths, strict=True))
        say("  ".join(cells).rstrip())
    note(f"random families: {', '.join(random_names())}")
    return Exit.OK
