"""The JSON Schema of scenario files, for editors' completion."""

from __future__ import annotations

import json
from typing import Any

from gm_ompl.scenario.model import FORMAT, ScenarioModel


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of the format.

    It knows every key and each value's kind; what keys must satisfy together, only ``load``
    checks.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": FORMAT,
        **ScenarioModel.model_json_schema(),
    }


def json_schema_text() -> str:
    """Return the JSON Schema as the text of the shipped file ``scenario.schema.json``."""
    return json.dumps(json_schema(), indent=2, sort_keys=False) + "\n"
