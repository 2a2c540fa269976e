"""Where in a JSON text a value stands, for messages."""

from __future__ import annotations

import functools
import json
from collections.abc import Sequence
from pathlib import Path


def where(path: Path, text: str, place: Sequence[int | str]) -> str:
    """Return "file:line: key path" of what stands at ``place`` in the valid JSON ``text``."""
    line = text.count("\n", 0, locate(text, place)) + 1
    return f"{path}:{line}: {key_path(place)}"


def key_path(place: Sequence[int | str]) -> str:
    """Return ``steps[3].cost`` for ("steps", 3, "cost")."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
    return text.lstrip(".") or "(top level)"


_BLANK = " \t\r\n"


def locate(text: str, place: Sequence[int | str]) -> int:
    """Return where in the valid JSON ``text`` the value at ``place`` begins.

    A part of ``place`` that is not there ends the walk at what holds it.
    """
    at = _skip(text, 0)
    for part in place:
        inside = _inside(text, at)
        if part not in inside:
            return at
        at = inside[part]
    return at


@functools.lru_cache(maxsize=8)  # many mistakes stand in few places
def _inside(text: str, at: int) -> dict[int | str, int]:
    """Return where each value begins in the list or object that begins at ``at``."""
    decoder, found = json.JSONDecoder(), dict[int | str, int]()
    inner = _skip(text, at + 1) if text[at] in "[{" else at
    while inner > at and text[inner] not in "]}":
        key: int | str = len(found)
        if text[at] == "{":
            key, inner = decoder.raw_decode(text, inner)
            inner = _skip(text, _skip(text, inner) + 1)  # over the colon
        found[key] = inner
        _, inner = decoder.raw_decode(text, inner)
        inner = _skip(text, inner)
        inner = _skip(text, inner + 1) if text[inner] == "," else inner
    return found


def _skip(text: str, at: int) -> int:
    while text[at] in _BLANK:
        at += 1
    return at
