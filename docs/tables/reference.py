"""Reference pages from the program itself: commands, keys of scenarios and plans, planners."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any, Final

import typer.main

from gm_ompl.app.main import app
from gm_ompl.app.verbs import GROUPS
from gm_ompl.planfile.model import (
    DisplacementStep,
    PlacementRecord,
    Plan,
    RegraspStep,
    SegmentRecord,
    Statistics,
)
from gm_ompl.planners.registry import PLANNERS
from gm_ompl.scenario.model import json_schema
from gm_ompl.study.report import table

PARTS: Final = {
    "The plan": Plan,
    "A displacement step": DisplacementStep,
    "A segment of it": SegmentRecord,
    "A regrasping step": RegraspStep,
    "A placement": PlacementRecord,
    "Statistics": Statistics,
}
"""The parts of a plan file, in the order of the page."""

LIMITS: Final = {
    "minimum": ">= {}", "exclusiveMinimum": "> {}", "maximum": "<= {}", "exclusiveMaximum": "< {}",
}  # fmt: skip


def commands() -> str:
    """Return every verb under its group's heading: what it does, its options."""
    verbs = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    parts = []
    for group, names in GROUPS.items():
        parts.append(f"## {group}\n")
        parts += [_verb(name, verbs[name]) for name in names]
    return "\n".join(parts)


def _verb(name: str, verb: Any) -> str:
    rows = []
    for one in verb.params:
        shown = ", ".join(one.opts) if one.param_type_name == "option" else one.name.upper()
        metavar = one.metavar if one.param_type_name == "option" else None
        default = "" if one.default in (None, False, ...) or one.required else f"`{one.default}`"
        rows.append((f"`{shown}{f' {metavar}' if metavar else ''}`", one.help or "", default))
    text = inspect.cleandoc(verb.help or "")
    head = ("option", "meaning", "default")
    return f"### `gm-ompl {name}`\n\n{text}\n\n{table(head, [_cells(row) for row in rows])}"


def scenario_keys() -> str:
    """Return a table of every key of a scenario: dotted, with its kind, default and meaning."""
    schema = json_schema()
    rows = [_cells(row) for row in _keys(schema, schema["$defs"], "", {})]
    return table(("key", "holds", "left out", "meaning"), rows)


def _keys(
    node: dict[str, Any], kinds: dict[str, Any], prefix: str, seen: dict[str, str]
) -> Iterator[tuple[str, str, str, str]]:
    """Yield a row per key; one that holds keys is followed by them, if it is the first such one.

    Args:
        node: what has the keys, as JSON Schema.
        kinds: what else the schema defines.
        prefix: what stands before the keys, with its dot.
        seen: where kinds with keys were first met; grows.
    """
    needed = node.get("required", ())
    for name, found in node.get("properties", {}).items():
        refs = _references(found)
        default = found.get("default", ...)
        plain = default in (..., None, "") or isinstance(default, dict)
        left = "required" if name in needed else "" if plain else f"`{_plain(default)}`"
        known = [f"keys as of `{seen[ref]}`" for ref in refs if ref in seen]
        told = found.get("description") or " / ".join(_first(kinds[ref]) for ref in refs)
        yield (
            f"`{prefix}{name}`",
            _kind(found, kinds),
            left,
            "; ".join(filter(None, [told, *known])),
        )
        for ref in refs:
            if ref not in seen:
                seen[ref] = f"{prefix}{name}"
                yield from _keys(kinds[ref], kinds, f"{prefix}{name}.", seen)


def _references(found: dict[str, Any]) -> list[str]:
    """Return the names of what keys a value may hold."""
    if "$ref" in found:
        return [str(found["$ref"]).rsplit("/", 1)[1]]
    inner = [found.get("items"), found.get("additionalProperties")]
    inner += [*found.get("anyOf", ()), *found.get("oneOf", ())]
    names = [name for one in inner if isinstance(one, dict) for name in _references(one)]
    return list(dict.fromkeys(names))


def _kind(found: dict[str, Any], kinds: dict[str, Any]) -> str:
    """Return what a value is, in words."""
    if "$ref" in found:
        return _kind(kinds[found["$ref"].rsplit("/", 1)[1]], kinds)
    if "const" in found or "enum" in found:
        return ", ".join(f"`{_plain(one)}`" for one in found.get("enum", [found.get("const")]))
    options = [one for one in found.get("anyOf", found.get("oneOf", ())) if one != {"type": "null"}]
    if options:
        return " or ".join(dict.fromkeys(_kind(one, kinds) for one in options))
    kind = found.get("type", "")
    if kind == "array":
        items: dict[str, Any] = found.get("items") or next(iter(found.get("prefixItems", ())), {})
        return f"list of {_kind(items, kinds)}"
    words = {
        "object": "keys",
        "string": "text",
        "integer": "whole number",
        "boolean": "true, false",
    }
    limits = [text.format(_plain(found[key])) for key, text in LIMITS.items() if key in found]
    return " ".join([words.get(kind, kind), *limits])


def _first(kind: dict[str, Any]) -> str:
    text: str = kind.get("description", "").split("\n")[0]
    return text


def plan_keys() -> str:
    """Return a table for each part of a plan file, from its class's docstring."""
    parts = []
    for heading, part in PARTS.items():
        text = inspect.cleandoc(part.__doc__ or "").split("Attributes:\n")[1]
        found = re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", text, re.MULTILINE)
        rows = [(f"`{name.rstrip('_')}`", " ".join(said.split())) for name, said in found]
        parts.append(f"### {heading}\n\n{table(('key', 'meaning'), [_cells(row) for row in rows])}")
    return "\n".join(parts)


def planners() -> str:
    """Return every planner with what it promises, then its parameters."""
    rows, parts = [], []
    for name, planner in PLANNERS.items():
        specs = planner.specs
        what = "proven on the lattice" if not specs.randomised else "improves its plan"
        rows.append((f"`{name}`", what if specs.optimal else "first plan", _sentence(planner)))
        own = [(f"`{one.name}`", one.default, one.meaning) for one in planner.parameters]
        if own:
            shown = table(("parameter", "default", "meaning"), [_cells(row) for row in own])
            parts.append(f"### {name}\n\n{shown}")
    head = table(("planner", "promises", "how"), [_cells(row) for row in rows])
    return "\n".join([head, "## Parameters\n", *parts])


def _sentence(planner: type[Any]) -> str:
    return inspect.cleandoc(planner.__doc__ or "").split("\n\n")[0].replace("\n", " ")


def _plain(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else f"{value}"


def _cells(row: tuple[Any, ...]) -> list[str]:
    return [_plain(cell).replace("|", "\\|").replace("\n", " ").replace("``", "`") for cell in row]
