"""Changes of a scenario before it is checked: ``--set KEY=VALUE``, and values by their keys."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any, TypeAlias

from gm_ompl.arguments import kind_of, plain
from gm_ompl.errors import ScenarioError
from gm_ompl.reading import one_line
from gm_ompl.scenario.document import Document, Path, dotted, parse, shown

Changes: TypeAlias = str | Mapping[str, object] | Iterable[str]
"""What replaces values: "KEY=VALUE", a list of such, or values by their keys. KEY is a dotted path,
list items by number; VALUE in a text is YAML."""


def apply_overrides(document: Document, overrides: Changes) -> list[str]:
    """Change ``document.tree`` in place; return one line per override that cannot be applied."""
    problems: list[str] = []
    for place, key, value in _listed(overrides, problems):
        try:
            _assign(document, place, key, value)
        except ScenarioError as error:
            problems.extend(error.problems)
    return problems


def _listed(overrides: Changes, problems: list[str]) -> Iterator[tuple[str, str, object]]:
    """Yield where each change comes from, its key and value; note those that are none."""
    if isinstance(overrides, Mapping):
        for key, value in overrides.items():
            if not isinstance(key, str):
                problems.append(f"--set: the key {kind_of(key)} must be text")
                continue
            place = one_line(f"--set {key}={shown(value)}")
            yield place, key, plain(value, partial(_note, problems, place))
        return
    alone = isinstance(overrides, (str, bytes)) or not isinstance(overrides, Iterable)
    for text in (overrides,) if alone else overrides:
        if not isinstance(text, str):
            wanted = "expected KEY=VALUE, for example fingers.max_normal_force=5"
            problems.append(f"--set {kind_of(text)}: {wanted}")
            continue
        key, equals, value_text = text.partition("=")
        place = one_line(f"--set {text}")
        try:
            yield place, key if equals else "", _value(place, value_text) if equals else None
        except ScenarioError as error:
            problems.extend(error.problems)


def _note(problems: list[str], place: str, path: Path, text: str) -> None:
    problems.append(one_line(": ".join(part for part in (place, dotted(path), text) if part)))


def _assign(document: Document, place: str, key: str, value: object) -> None:
    parts = key.strip().split(".")
    if not all(parts):
        raise ScenarioError(f"{place}: expected KEY=VALUE, for example fingers.max_normal_force=5")
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
        raise ScenarioError(f"{place}: the value is not valid YAML") from None
    if set(wrapped) != {"value"}:
        raise ScenarioError(f"{place}: the value is not one YAML value")
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
        raise ScenarioError(f"{place}: {name} is a list; no item {part!r}, {items}")
    raise ScenarioError(
        f"{place}: {name} is {shown(target)}; it has no keys or items, set it as a whole"
    )
