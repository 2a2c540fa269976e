"""Mistakes as one line each: file, line, key path, value, and what would be right."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from gm_ompl import limits
from gm_ompl.errors import GeometryError, ScenarioError, did_you_mean
from gm_ompl.scenario.document import Document, Path, shown
from gm_ompl.scenario.fields import TAGS
from gm_ompl.scenario.model import ScenarioModel

EXAMPLES = {
    "format": "format: gm-ompl-scenario/1",
    "name": "name: my/scenario",
    "object": "object: {shape: {box: [5, 5, 10]}, mass: 1}",
    "shape": "shape: {box: [5, 5, 10]}",
    "mass": "mass: 1",
    "friction": "friction: {environment: 0.5, finger: 0.7}",
    "environment": "environment: 0.5",
    "finger": "finger: 0.7",
    "fingers": "fingers: {count: 2, radius: 1, max_normal_force: 10}",
    "count": "count: 2",
    "radius": "radius: 1",
    "max_normal_force": "max_normal_force: 10",
    "motion": "motion: {start: {position: [0, 0, 5]}, path: [{slide: {by: [15, 0, 0]}}]}",
    "start": "start: {position: [0, 0, 5]}",
    "position": "position: [0, 0, 5]",
    "lattice": "lattice: {segments: 30}",
    "by": "by: [15, 0, 0]",
    "towards": "towards: +x",
    "angle": "angle: 90 deg",
    "min": "min: [-100, -100, 0]",
    "max": "max: [-3, 100, 100]",
    "x": "x: [-2, 20]",
    "y": "y: [-10, 10]",
    "z": "z: [0, 10]",
    "region": "region: {x: [-2, 20], y: [-10, 10], z: [0, 10]}",
    "yaw": "yaw: [-180 deg, 180 deg]",
    "face": "face: -x",
    "cell": "cell: [3, 2]",
    "s": "s: 0.5",
}
"""What a missing key may look like, by its name."""

WANTED = {
    "float_type": "must be a finite number, for example 1.5 or 1e-3 (no unit)",
    "finite_number": "must be a finite number, for example 1.5 or 1e-3",
    "int_type": "must be a whole number, for example 3",
    "int_from_float": "must be a whole number, for example 3",
    "bool_type": "must be true or false",
    "string_type": "must be text; put it in quotes",
    "tuple_type": "must be a list in square brackets",
    "dict_type": "must be a mapping of keys",
    "model_type": "must be a mapping of keys",
    "model_attributes_type": "must be a mapping of keys",
    "greater_than": "must be > {gt:g}",
    "greater_than_equal": "must be >= {ge:g}",
    "less_than": "must be < {lt:g}",
    "less_than_equal": "must be <= {le:g}",
    "string_too_short": "must not be empty",
    "literal_error": "must be {expected}",
    "amount": "must be a number >= 0 or a percentage, for example 0.05 or 10 %",
    "angle": "must be an angle with its unit, for example 90 deg or 1.57 rad",
}


def path_of(location: tuple[str | int, ...]) -> Path:
    """Return a pydantic location as a path in the file, the unions' tags left out.

    A location starts with a key of the file; one that ends in an unknown key is no tag either.
    """
    inner = tuple(part for part in location[:-1] if part not in TAGS)
    return inner if location[-1] in TAGS and inner else (*inner, location[-1])


def value_problem(document: Document, path: Path, value: object, wanted: str) -> str:
    """Return the line that says ``value`` at ``path`` is wrong and what is wanted."""
    return document.line(path, f"value {shown(value)}: {wanted}")


def validation_problems(document: Document, error: ValidationError) -> list[str]:
    """Return one line per mistake that pydantic found."""
    details = error.errors(include_url=False)
    places = [path_of(detail["loc"]) for detail in details]
    return [
        _line(document, detail, path)
        for detail, path in zip(details, places, strict=True)
        if not (detail["type"] == "too_short" and _holds_others(path, places))
    ]


def _holds_others(path: Path, places: Iterable[Path]) -> bool:
    """Whether a mistake lies inside ``path``: pydantic counts wrong entries as absent."""
    return any(len(other) > len(path) and other[: len(path)] == path for other in places)


def _line(document: Document, detail: ErrorDetails, path: Path) -> str:
    kind, context = detail["type"], detail.get("ctx", {})
    if kind == "extra_forbidden":
        return document.line(path, unknown_key(path))
    if kind == "missing":
        key = str(path[-1])
        return document.line(path, f"missing; add it, for example {EXAMPLES.get(key, key + ':')}")
    if kind in ("too_short", "too_long"):
        return value_problem(document, path, detail["input"], _length(kind, context))
    wanted = WANTED[kind].format(**context) if kind in WANTED else detail["msg"]
    if kind == "literal_error" and isinstance(detail["input"], str):
        words = str(context["expected"]).replace("'", "\n").split("\n")
        wanted += did_you_mean(detail["input"], [word for word in words if word.strip(" ,or")])
    return value_problem(document, path, detail["input"], wanted)


def _length(kind: str, context: dict[str, Any]) -> str:
    have = context.get("actual_length")
    if kind == "too_short":
        return f"must have {_at('least', context['min_length'])}, has {have}"
    return f"must have {_at('most', context['max_length'])}, has {have}"


def _at(bound: str, count: int) -> str:
    return f"at {bound} {count} {'entry' if count == 1 else 'entries'}"


def unknown_key(path: Path) -> str:
    """Return what is wrong with the key at ``path``, which the format does not have."""
    valid = keys_at(path[:-1])
    if path[-1] in valid:  # of another of several kinds of mapping
        return "does not go with the other keys here; leave out it or them"
    return f"unknown key{did_you_mean(str(path[-1]), valid)} (keys here: {', '.join(valid)})"


def keys_at(path: Path) -> list[str]:
    """Return the keys that a mapping at ``path`` may have."""
    schema = _schema()
    candidates = [schema]
    for part in path:
        candidates = [
            below for candidate in candidates for below in _below(_expand(schema, candidate), part)
        ]
    keys: dict[str, None] = {}
    for candidate in candidates:
        for leaf in _expand(schema, candidate):
            keys.update(dict.fromkeys(leaf.get("properties", {})))
    return list(keys)


@cache
def _schema() -> dict[str, Any]:
    return ScenarioModel.model_json_schema()


def _expand(schema: dict[str, Any], node: dict[str, Any]) -> list[dict[str, Any]]:
    """Return ``node`` with references followed and alternatives listed."""
    if "$ref" in node:
        return _expand(schema, schema["$defs"][node["$ref"].rsplit("/", 1)[-1]])
    choices = [*node.get("anyOf", []), *node.get("oneOf", []), *node.get("allOf", [])]
    return [leaf for choice in choices for leaf in _expand(schema, choice)] or [node]


def _below(nodes: list[dict[str, Any]], part: str | int) -> list[dict[str, Any]]:
    found = []
    for node in nodes:
        if isinstance(part, int):
            below = node.get("items")
        else:
            below = node.get("properties", {}).get(part, node.get("additionalProperties"))
        if isinstance(below, dict):
            found.append(below)
    return found


T = TypeVar("T")


class Notes:
    """Collects mistakes, so that the user sees all at once."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.problems: list[str] = []

    def attempt(self, path: Path, make: Callable[[], T]) -> T | None:
        """Return ``make()``, or None after noting its GeometryError at ``path``."""
        limits.check()
        try:
            return make()
        except GeometryError as error:
            self.add(path, str(error))
            return None

    def add(self, path: Path, text: str) -> None:
        """Note what is wrong at ``path``."""
        self.problems.append(self.document.line(path, text))

    def wrong(self, path: Path, value: object, wanted: str) -> None:
        """Note that ``value`` at ``path`` is wrong."""
        self.problems.append(value_problem(self.document, path, value, wanted))

    def stop(self) -> None:
        """Raise what was noted, if anything."""
        if self.problems:
            raise ScenarioError(self.problems)
