"""Reading and writing JSON files: whole or not at all, and mistakes named by line and key."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from gm_ompl.errors import InputError, PlanFileError, did_you_mean
from gm_ompl.writing import write_text

MAX_BYTES = 512 * 2**20  # far above any plan; keeps a wrong file from filling the memory
LINE_WIDTH = 110  # values that fit are written on one line
MAX_SHOWN = 20  # mistakes reported at once

_Model = TypeVar("_Model", bound=BaseModel)
_Path = tuple[int | str, ...]
_KINDS = ("displacement", "regrasp")  # pydantic names a union's member inside an error's path


def plain(value: dict[str, Any]) -> dict[str, Any]:
    """Return a deep copy made of JSON's own types.

    Raises:
        ValueError: it holds NaN, Infinity or something that JSON has no type for.
    """
    try:
        copy: dict[str, Any] = json.loads(json.dumps(value, allow_nan=False))
    except TypeError as error:
        raise ValueError(str(error)) from error
    return copy


def dumps(value: Any) -> str:
    """Return ``value`` as JSON, indented, short lists and objects on one line."""
    return "".join(_lines(value, "")) + "\n"


def _lines(value: Any, indent: str) -> Iterator[str]:
    flat = json.dumps(value, allow_nan=False, ensure_ascii=False)
    if len(flat) + len(indent) <= LINE_WIDTH or not isinstance(value, (dict, list)):
        yield flat
        return
    inner = indent + " "
    if isinstance(value, dict):
        items = [(json.dumps(key, ensure_ascii=False) + ": ", item) for key, item in value.items()]
    else:
        items = [("", item) for item in value]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    yield opening + "\n"
    for number, (key, item) in enumerate(items):
        yield inner + key
        yield from _lines(item, inner)
        yield ",\n" if number + 1 < len(items) else "\n"
    yield indent + closing


def write(path: Path, text: str) -> None:
    """Write ``text`` to ``path`` in one go: readers see the old file or the new one.

    Raises:
        PlanFileError: the file cannot be written.
    """
    try:
        write_text(path, text)
    except InputError as error:
        raise PlanFileError(str(error)) from error


def read(path: Path, model: type[_Model], format_name: str) -> _Model:
    """Read ``path`` into ``model``; its key ``format`` must be ``format_name``.

    Raises:
        PlanFileError: every mistake on its own line, with file, line, key, value and remedy.
    """
    text = _text(path)
    data = _syntax(path, text)
    if not isinstance(data, dict):
        raise PlanFileError(f"{path}:1: not a plan: the file must hold one JSON object")
    if data.get("format") != format_name:
        raise PlanFileError(
            f"{_where(path, text, ('format',))}: {json.dumps(data.get('format'))}: not a plan; "
            f'a plan file says "format": "{format_name}"'
        )
    mistakes = [
        f"{_where(path, text, place)}: {value}: must be a finite number"
        for place, value in _not_finite(data, ())
    ]
    try:
        if not mistakes:
            return model.model_validate_json(text, by_alias=True, by_name=False)
    except ValidationError as error:
        mistakes = _mistakes(path, text, data, error)
    if len(mistakes) > MAX_SHOWN:
        mistakes[MAX_SHOWN:] = [f"{path}: and {len(mistakes) - MAX_SHOWN} more mistakes"]
    raise PlanFileError("\n".join(mistakes))


def _text(path: Path) -> str:
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise PlanFileError(
                f"{path}: {size} bytes; plan files of up to {MAX_BYTES} bytes are read"
            )
        return path.read_bytes().decode("utf-8")
    except OSError as error:
        raise PlanFileError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise PlanFileError(
            f"{path}: byte {error.start}: not a text file in UTF-8; a plan file is JSON"
        ) from error


class _DuplicateKeyError(ValueError):
    pass


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) < len(pairs):
        names = [key for key, _ in pairs]
        twice = next(key for key in names if names.count(key) > 1)
        raise _DuplicateKeyError(f"{twice}: the key is there twice in one object; remove one")
    return result


def _syntax(path: Path, text: str) -> Any:
    """Parse the JSON, no key twice."""
    try:
        return json.loads(text, object_pairs_hook=_object)
    except json.JSONDecodeError as error:
        hint = "the file is empty" if not text.strip() else f"not valid JSON: {error.msg}"
        raise PlanFileError(f"{path}:{error.lineno}:{error.colno}: {hint}") from error
    except _DuplicateKeyError as error:
        raise PlanFileError(f"{path}: {error}") from error
    except (RecursionError, ValueError) as error:  # ValueError: an integer of too many digits
        raise PlanFileError(
            f"{path}: not a plan: nested too deeply or too long a number"
        ) from error


def _not_finite(value: Any, place: _Path) -> Iterator[tuple[_Path, float]]:
    """Yield the place of every NaN and infinity: no JSON, but Python reads and 1e999 makes them."""
    if isinstance(value, float) and not math.isfinite(value):
        yield place, value
    items = value.items() if isinstance(value, dict) else ()
    for key, item in enumerate(value) if isinstance(value, list) else items:
        yield from _not_finite(item, (*place, key))


_REMEDIES = {
    "missing": "required key is missing; add it",
    "literal_error": "must be {expected}",
    "float_type": "must be a number",
    "finite_number": "must be a finite number",
    "int_type": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be a string",
    "tuple_type": "must be a list",
    "too_short": "must have at least {min_length} items",
    "too_long": "must have at most {max_length} items",
    "greater_than_equal": "must be at least {ge}",
    "dict_type": "must be an object",
    "model_type": "must be an object",
    "union_tag_not_found": "each step needs a kind: 'displacement' or 'regrasp'",
    "union_tag_invalid": "kind must be 'displacement' or 'regrasp'",
}


def _mistakes(path: Path, text: str, data: Any, error: ValidationError) -> list[str]:
    """Return one line per mistake that pydantic found."""
    found = [(_place(data, e["loc"]), e) for e in error.errors(include_url=False)]
    missing = [place for place, e in found if e["type"] == "missing"]
    lines = []
    for place, e in found:
        where = _where(path, text, place)
        if e["type"] == "missing":
            lines.append(f"{where}: {_REMEDIES['missing']}")
        elif e["type"] == "extra_forbidden":
            beside = [str(other[-1]) for other in missing if other[:-1] == place[:-1]]
            lines.append(f"{where}: unknown key{did_you_mean(str(place[-1]), beside)}; remove it")
        else:
            value = json.dumps(e["input"], default=str)
            value = value if len(value) <= 60 else value[:57] + "..."
            remedy = _REMEDIES.get(e["type"], str(e["msg"])).format(**e.get("ctx", {}))
            lines.append(f"{where}: {value}: {remedy}")
    return lines


def _where(path: Path, text: str, place: _Path) -> str:
    line = text.count("\n", 0, locate(text, place)) + 1
    return f"{path}:{line}: {key_path(place)}"


def _place(data: Any, loc: Sequence[int | str]) -> _Path:
    """Return the path inside the file: pydantic's, without the names of union members."""
    place: list[int | str] = []
    for part in loc:
        if part in _KINDS and not (isinstance(data, dict) and part in data):
            continue
        place.append(part)
        inside = isinstance(data, dict) and part in data
        inside = inside or (isinstance(data, list) and isinstance(part, int) and part < len(data))
        data = data[part] if inside else None
    return tuple(place)


def key_path(place: Sequence[int | str]) -> str:
    """Return ``steps[3].cost`` for ("steps", 3, "cost")."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
    return text.lstrip(".") or "(top level)"


_BLANK = " \t\r\n"


def locate(text: str, place: Sequence[int | str]) -> int:
    """Return where in the valid JSON ``text`` the value at ``place`` begins.

    A part of ``place`` that is not there ends the walk at what holds it.
    """
    decoder = json.JSONDecoder()
    at = _skip(text, 0)
    for part in place:
        inner, index = _skip(text, at + 1), 0
        while text[inner] not in "]}":
            key: int | str = index
            if text[at] == "{":
                key, inner = decoder.raw_decode(text, inner)
                inner = _skip(text, _skip(text, inner) + 1)  # over the colon
            if key == part:
                break
            _, inner = decoder.raw_decode(text, inner)
            inner = _skip(text, inner)
            inner = _skip(text, inner + 1) if text[inner] == "," else inner
            index += 1
        else:
            return at
        at = inner
    return at


def _skip(text: str, at: int) -> int:
    while text[at] in _BLANK:
        at += 1
    return at
