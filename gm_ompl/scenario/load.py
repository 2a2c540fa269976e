"""Find and read scenarios: files, shipped names, random families."""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from gm_ompl.arguments import kind_of
from gm_ompl.errors import ScenarioError, did_you_mean
from gm_ompl.reading import STDIN, Kind, one_line, read_text, refuse_other
from gm_ompl.scenario.document import Document, parse
from gm_ompl.scenario.overrides import Changes
from gm_ompl.scenario.scenario import Scenario

MAX_BYTES = 8 * 1024 * 1024
"""Larger files are refused unread."""

SUFFIXES = (".yaml", ".yml", ".json")


def load(name: str | os.PathLike[str] | Mapping[str, Any], overrides: Changes = ()) -> Scenario:
    """Return the scenario of a shipped name, a random family's name, or a file, or in a mapping.

    Args:
        name: "paper/slide", "random/tumble/17", or a path; what exists as a file, ends in
            .yaml, .yml or .json, or is a ``PathLike`` is a file, and "-" the standard input. A
            mapping has a file's keys.
        overrides: "KEY=VALUE" as ``--set`` takes them, one or several, or values by dotted key.

    Raises:
        ScenarioError: no such scenario, or one line per mistake in it.
    """
    if isinstance(name, Mapping):
        return Scenario.from_mapping(name, overrides)
    if not isinstance(name, (str, os.PathLike)):
        raise ScenarioError(f"scenario: {kind_of(name)}: must be a name, a file or a mapping")
    return Scenario.from_document(read(name), overrides)


def read(name: str | os.PathLike[str]) -> Document:
    """Return the parsed text of a scenario, not yet validated.

    Raises:
        ScenarioError: no such scenario, or its text is not YAML.
    """
    text = os.fspath(name)
    is_path = not isinstance(name, str) or text.endswith(SUFFIXES) or Path(text) == STDIN
    if not is_path and text.startswith("random/"):
        return _random(text)
    if not is_path:
        shipped_file = _shipped().get(text)
        if shipped_file is not None:
            text, file = shipped_file.read_text(encoding="utf-8"), Path(str(shipped_file))
            return _beside(parse(text, str(file)), file)
    if is_path or os.path.exists(text):
        document = parse(read_text(Path(text), KIND), text)
        assert isinstance(document.tree, dict), "the reader accepts nothing else"
        refuse_other(document.label, document.tree.get("format"), KIND)
        return _beside(document, Path(text))
    names = [*shipped(), *random_names()]
    raise ScenarioError(
        f"{one_line(text)}: no such scenario or file{did_you_mean(text, names)}; "
        f"shipped: {', '.join(names)}"
    )


def _beside(document: Document, file: Path) -> Document:
    """Return ``document``, the files it names looked for beside ``file``."""
    document.folder = file.parent
    return document


def shipped() -> tuple[str, ...]:
    """Return the names of the shipped scenarios, in alphabetical order."""
    return tuple(sorted(_shipped()))


def random_names() -> tuple[str, ...]:
    """Return one name per random family, its seed left open."""
    from gm_ompl.scenario.families import FAMILIES  # numpy's generators load on demand

    return tuple(f"random/{family}/SEED" for family in FAMILIES)


def _shipped() -> dict[str, Traversable]:
    found: dict[str, Traversable] = {}

    def walk(folder: Traversable, prefix: str) -> None:
        for entry in folder.iterdir():
            if entry.is_dir():
                walk(entry, f"{prefix}{entry.name}/")
            elif entry.name.endswith(".yaml"):
                found[prefix + entry.name.removesuffix(".yaml")] = entry

    walk(files("gm_ompl.scenarios"), "")
    return found


def _random(text: str) -> Document:
    from gm_ompl.scenario.families import FAMILIES, family_yaml

    _, _, rest = text.partition("/")
    family, _, seed = rest.partition("/")
    if family not in FAMILIES:
        raise ScenarioError(
            f"{one_line(text)}: no such family{did_you_mean(family, FAMILIES)}; "
            f"families are {', '.join(FAMILIES)}"
        )
    if not (seed.isascii() and seed.isdigit() and len(seed) <= 18):
        raise ScenarioError(
            f"{one_line(text)}: the seed must be a whole number >= 0, "
            f"for example random/{family}/17"
        )
    return parse(family_yaml(family, int(seed)), f"random/{family}/{int(seed)}")


def _hint(path: Path) -> str:
    stem = str(path)
    for suffix in SUFFIXES:
        stem = stem.removesuffix(suffix)
    return did_you_mean(stem, shipped())


KIND = Kind("scenario", "YAML", MAX_BYTES, ScenarioError, _hint)
