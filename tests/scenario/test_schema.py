"""The JSON Schema that ships for editors."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from gm_ompl.scenario.model import ScenarioModel, json_schema, json_schema_text


def test_the_shipped_schema_is_current() -> None:
    """scenario.schema.json is what the models say; write json_schema_text() there to renew it."""
    shipped = (files("gm_ompl.scenarios") / "scenario.schema.json").read_text(encoding="utf-8")
    assert shipped == json_schema_text()
    assert json.loads(shipped) == json_schema()


def test_it_knows_every_key_and_allows_no_other() -> None:
    """Every object in the schema is closed, save the obstacles, which have names."""
    schema = json_schema()
    assert set(schema["properties"]) == set(ScenarioModel.model_fields)

    def closed(node: Any) -> None:
        if isinstance(node, dict):
            if "properties" in node and "type" in node:
                assert node["additionalProperties"] is False
            for part in node.values():
                closed(part)
        elif isinstance(node, list):
            for part in node:
                closed(part)

    closed(schema)
