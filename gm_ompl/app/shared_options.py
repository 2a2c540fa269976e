"""Options that several verbs share."""

from __future__ import annotations

from functools import partial
from typing import Any

from gm_ompl.app.commands import argument, option
from gm_ompl.app.completing import scenarios

as_json_option = partial(option, False, "Print one JSON object and nothing else.", None, "--json")
scenario_option = partial(
    argument, "A shipped name, or a file; - reads stdin.", "SCENARIO", autocompletion=scenarios
)
scenarios_option = partial(
    argument, "Shipped names, or files.", "SCENARIO...", autocompletion=scenarios
)
changes_option = partial(
    option, None, "Replace a value of the scenario; may be repeated.", "KEY=VALUE", "--set"
)
executor_option = partial(
    option, "local", "Where runs are made: local, or dask://HOST:PORT.", "WHERE"
)
speed_option = partial(option, 0.1, "The fastest vertex's speed, object sizes per s.", "V")
plan_file_option = partial(argument, "A plan, as plan -o writes it; - reads stdin.", "PLAN.json")


def output_option(default: Any, text: str, metavar: str) -> Any:
    """Return an option that names a file to write."""
    return option(default, text, metavar, "--output", "-o")
