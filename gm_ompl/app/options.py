"""Options and arguments that several verbs share."""

from __future__ import annotations

from typing import Annotated

import typer

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]

Scenario = Annotated[str, typer.Argument(metavar="SCENARIO", help="A shipped name, or a file.")]

Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Replace a value of the scenario; may be repeated."
    ),
]
