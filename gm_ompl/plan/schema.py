"""The JSON Schema of the plan file."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from gm_ompl.plan.model import Plan


def plan_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) that every plan file satisfies."""
    schema = Plan.model_json_schema(by_alias=True, mode="serialization")
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def shipped_schema() -> dict[str, Any]:
    """Return the schema that ships with the package, the file ``plan.schema.json``."""
    text = (files("gm_ompl.plan") / "plan.schema.json").read_text(encoding="utf-8")
    schema: dict[str, Any] = json.loads(text)
    return schema
