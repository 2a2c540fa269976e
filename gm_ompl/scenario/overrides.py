"""``--set KEY=VALUE``: change a parsed scenario before it is validated."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from gm_ompl.errors import ScenarioError
from gm_ompl.reading import one_line
from gm_ompl.scenario.document import Document, Path, parse, shown


def apply_overrides(document: Document, overrides: Iterable[str]) -> list[str]:
    """Change ``document.tree`` in place; return one line per override that cannot be applied.

    Args:
        document: what was read.
        overrides: "KEY=VALUE"; KEY is a dotted path, list items by number; VALUE is YAML.
    """
    problems: list[str] = []
    for text in overrides:
        try:
            _apply(document, text)
        except ScenarioError as error:
            problems.extend(error.problems)
    return problems


def _apply(document: Document, text: str) -> None:
    place = one_line(f"--set {text}")
    key, equals, value_text = text.partition("=")
    parts = key.strip().split(".")
    if not equals or not all(parts):
        raise ScenarioError(
            [f"{place}: expected KEY=VALUE, for example fingers.max_normal_force=5"]
        )
    value = _value(place, value_text)
    target, path = _target(document, parts, place)
    last = _index(target, parts[-1], path, place)
    target[last] = value
    path = (*path, last)
    for known in [p for p in document.places if p[: len(path)] == path]:
        del document.places[known]
    document.places[path] = place


def _value(place: str, text: str) -> object:
    """Return VALUE read as YAML, strictly as in a file."""
    try:
        wrapped: Any = parse("value: " + text.strip(), place).tree
    except ScenarioError:
        raise ScenarioError([f"{place}: the value is not valid YAML"]) from None
    if set(wrapped) != {"value"}:
        raise ScenarioError([f"{place}: the value is not one YAML value"])
    return wrapped["value"]


def _target(document: Document, parts: list[str], place: str) -> tuple[Any, Path]:
    """Return the mapping or list that holds the last part, made on the way where absent."""
    target: Any = document.tree
    path: Path = ()
    for part in parts[:-1]:
        step = _index(target, part, path, place)
        if isinstance(target, dict) and target.get(step) is None:
            target[step] = {}
            document.places[(*path, step)] = place
        target, path = target[step], (*path, step)
    return target, path


def _index(target: Any, part: str, path: Path, place: str) -> str | int:
    """Return ``part`` as a key of the mapping or an index of the list ``target``."""
    if isinstance(target, dict):
        return part
    name = ".".join(map(str, path))
    if isinstance(target, list):
        if part.isascii() and part.isdigit() and int(part) < len(target):
            return int(part)
        items = f"items are 0 to {len(target) - 1}" if target else "it is empty"
        raise ScenarioError([f"{place}: {name} is a list; no item {part!r}, {items}"])
    raise ScenarioError(
        [f"{place}: {name} is {shown(target)}; it has no keys or items, set it as a whole"]
    )
