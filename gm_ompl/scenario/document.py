"""YAML text -> a plain tree, with the place of every value."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any, TypeAlias

import yaml

from gm_ompl import limits
from gm_ompl.errors import ScenarioError
from gm_ompl.reading import is_text, one_line

Path: TypeAlias = tuple[str | int, ...]
"""Keys and list indices from the top of the scenario down to a value."""

MAX_VALUES = 300_000
"""More values than this, aliases counted each time they are used, are refused."""

WHOLE = re.compile(r"[-+]?(0|[1-9][0-9]{0,300})")
REAL = re.compile(r"[-+]?(\.[0-9]+|(0|[1-9][0-9]*)(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
WORDS: dict[str, object] = {
    "true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False,
    "null": None, "Null": None, "NULL": None, "~": None, "": None,
}  # fmt: skip


class StrictLoader(yaml.SafeLoader):
    """PyYAML's safe reader without its own guesses of types (yes, 1:30, 1_000, dates)."""

    yaml_implicit_resolvers: dict[str, list[tuple[str, re.Pattern[str]]]] = {}  # noqa: RUF012 (PyYAML names it)

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._left = MAX_VALUES

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose one node; stops where a text has far too many of them."""
        self._left -= 1
        limits.check()
        if self._left < 0:
            raise yaml.YAMLError(f"more than {MAX_VALUES} values")
        return super().compose_node(parent, index)


def scalar(text: str) -> object:
    """Return what a plain (unquoted) scalar means; YAML 1.2's core rules, decimal only."""
    if text in WORDS:
        return WORDS[text]
    if WHOLE.fullmatch(text):
        return int(text)
    return float(text) if REAL.fullmatch(text) else text


def dotted(path: Path) -> str:
    """Return ``path`` as the user writes it: keys and list numbers with dots between."""
    return ".".join(str(part) for part in path)


def shown(value: object) -> str:
    """Return ``value`` for a message, long ones cut."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


@dataclass
class Document:
    """A scenario as read: its tree, and where each part of it stands.

    Attributes:
        label: the file's name, or another name for where the text came from.
        tree: mappings, lists and scalars.
        places: "line:column" per path, or the "--set KEY=VALUE" that wrote it.
        problems: mistakes found while reading.
        folder: where files that the scenario names are looked for; None: nowhere.
    """

    label: str
    tree: object = None
    places: dict[Path, str] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    folder: FilePath | None = None

    def where(self, path: Path) -> str:
        """Return "file:line:column" (or "--set KEY=VALUE") of the nearest known place."""
        for end in range(len(path), -1, -1):
            place = self.places.get(path[:end])
            if place is not None:
                return place if place.startswith("--set") else f"{self.label}:{place}"
        return self.label

    def line(self, path: Path, text: str) -> str:
        """Return one problem line: where, key path, what."""
        where = self.where(path)
        if not path or where.startswith(f"--set {dotted(path)}="):
            return one_line(f"{where}: {text}")
        return one_line(f"{where}: {dotted(path)}: {text}")


def parse(text: str, label: str) -> Document:
    """Return the tree in YAML (or JSON) ``text``.

    Raises:
        ScenarioError: the text is not one YAML document that holds a mapping.
    """
    label = one_line(label)
    try:
        node = yaml.compose(text, Loader=StrictLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f"{mark.line + 1}:{mark.column + 1}" if mark else "1:1"
        raise ScenarioError(
            f"{label}:{place}: not valid YAML: {error.problem or error.context}"
        ) from None
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split())
        raise ScenarioError(f"{label}:1:1: not valid YAML text: {reason}") from None
    except RecursionError:
        raise ScenarioError(f"{label}:1:1: nested too deeply for a scenario") from None
    if node is None:
        raise ScenarioError(f"{label}:1:1: the file is empty; expected a scenario (YAML)")
    document = Document(label)
    if not isinstance(node, yaml.MappingNode):
        raise ScenarioError(
            f"{label}:1:1: expected a mapping of keys (format:, name:, object:, ...)"
        )
    try:
        document.tree = _Builder(document).build(node, (), ())
    except RecursionError:
        raise ScenarioError(f"{label}:1:1: nested too deeply for a scenario") from None
    if document.problems:
        raise ScenarioError(document.problems)
    return document


def _mark(node: yaml.Node) -> str:
    return f"{node.start_mark.line + 1}:{node.start_mark.column + 1}"


class _Builder:
    """Turns YAML nodes into plain values, noting places and mistakes."""

    def __init__(self, document: Document) -> None:
        self.document, self.count = document, 0

    def build(self, node: yaml.Node, path: Path, above: tuple[int, ...]) -> object:
        """Return the value of ``node``; ``above`` holds the ids of the nodes around it."""
        self.count += 1
        if self.count > MAX_VALUES:
            raise ScenarioError(
                f"{self.document.label}:1:1: more than {MAX_VALUES} values; too large"
            )
        self.document.places.setdefault(path, _mark(node))
        if id(node) in above:
            self._wrong(node, path, "an alias refers to the value that contains it")
            return None
        above = (*above, id(node))
        if not node.tag.startswith("tag:yaml.org,2002:") or node.tag.split(":")[-1] not in (
            "map",
            "seq",
            "str",
        ):
            self._wrong(node, path, f"the tag {shown(node.tag)} is not allowed; leave it out")
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, path, above)
        if isinstance(node, yaml.SequenceNode):
            return [
                self.build(item, (*path, i), above) for i, item in enumerate(node.value)
            ]  # fmt: skip
        assert isinstance(node, yaml.ScalarNode)
        text = str(node.value)
        if not is_text(text):
            self._wrong(node, path, "half of a surrogate pair is no text")
        return scalar(text) if node.style is None else text

    def _mapping(
        self, node: yaml.MappingNode, path: Path, above: tuple[int, ...]
    ) -> Mapping[str, object]:
        values: dict[str, object] = {}
        for key_node, value_node in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                self._wrong(key_node, path, "a key must be a plain word")
                continue
            key = str(key_node.value)
            if not is_text(key):
                self._wrong(key_node, path, "half of a surrogate pair is no text")
                continue
            here = (*path, key)
            if key in values:
                first = self.document.places[here]
                self._wrong(
                    key_node, here, f"key given twice (first at {first}); keep only one of them"
                )
                continue
            self.document.places[here] = _mark(key_node)
            values[key] = self.build(value_node, here, above)
        return values

    def _wrong(self, node: yaml.Node, path: Path, text: str) -> None:
        key = f"{dotted(path)}: " if path else ""
        line = one_line(f"{self.document.label}:{_mark(node)}: {key}{text}")
        self.document.problems.append(line)


class _Dumper(yaml.SafeDumper):
    """Writes text so that ``parse`` reads it as text, and short lists on one line."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002 (PyYAML's hook)
        """Write every value out in full."""
        return True


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    style = None if scalar(text) is text and text.isprintable() else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _represent_text)


def dump(tree: Mapping[str, object]) -> str:
    """Return ``tree`` as YAML text that ``parse`` reads back unchanged."""
    text: str = yaml.dump(
        dict(tree), Dumper=_Dumper, sort_keys=False, default_flow_style=None, allow_unicode=True,
        width=100,
    )  # fmt: skip
    return text
