"""Reading and writing JSON files: whole or not at all, and mistakes named by line and key."""

from __future__ import annotations

import functools
import itertools
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from pydantic import BaseModel, ValidationError

from gm_ompl.errors import InputError, PlanError, did_you_mean
from gm_ompl.reading import Kind, is_text, one_line, read_text, refuse_other
from gm_ompl.scenario.load import shipped
from gm_ompl.writing import write_text

MAX_BYTES = 32 * 2**20  # far above any plan; keeps a wrong file from filling the memory
MAX_VALUES = 2_000_000  # likewise: ten thousand steps have less than half of them
BEGINNING = 200  # of every list and object; where a large file has mistakes there, they will do
MAX_DEPTH = 60  # a scenario inside a plan has less than ten
LINE_WIDTH = 110  # values that fit are written on one line
MAX_SHOWN = 20  # mistakes reported at once

_Model = TypeVar("_Model", bound=BaseModel)
Place: TypeAlias = tuple[int | str, ...]
Mistake: TypeAlias = tuple[Place, str]
# pydantic names a union's member inside an error's path
_KINDS = ("displacement", "regrasp", "arc: translation", "arc: rotation", "arc: straight")


def plain(value: dict[str, Any]) -> dict[str, Any]:
    """Return a deep copy made of JSON's own types.

    Raises:
        ValueError: it holds NaN, Infinity or something that JSON has no type for.
    """
    try:
        return dict(json.loads(json.dumps(value, allow_nan=False)))
    except TypeError as error:
        raise ValueError(str(error)) from error


def dumps(value: Any) -> str:
    """Return ``value`` as JSON, indented, short lists and objects on one line."""
    return "".join(_lines(value, "")) + "\n"


def _lines(value: Any, indent: str) -> Iterator[str]:
    flat = json.dumps(value, allow_nan=False, ensure_ascii=False)
    if len(flat) + len(indent) <= LINE_WIDTH or not isinstance(value, (dict, list)):
        yield flat
        return
    inner = indent + " "
    (opening, closing), items = "[]", [("", item) for item in value]
    if isinstance(value, dict):
        opening, closing = "{}"
        items = [(json.dumps(key, ensure_ascii=False) + ": ", item) for key, item in value.items()]
    yield opening + "\n"
    for number, (key, item) in enumerate(items):
        yield inner + key
        yield from _lines(item, inner)
        yield ",\n" if number + 1 < len(items) else "\n"
    yield indent + closing


def write(path: Path, text: str) -> None:
    """Write ``text`` to ``path`` in one go: readers see the old file or the new one.

    Raises:
        PlanError: the file cannot be written.
    """
    try:
        write_text(path, text)
    except InputError as error:
        raise PlanError(str(error)) from error


def _hint(path: Path) -> str:
    known = str(path) in shipped()
    makes = "a plan of the scenario of that name" if known else "one"
    return f"; `gm-ompl plan {path if known else 'SCENARIO'} -o PLAN.json` makes {makes}"


KIND = Kind("plan", "JSON, as `gm-ompl plan -o` writes it", MAX_BYTES, PlanError, _hint)


def read(path: Path, model: type[_Model], format_name: str) -> _Model:
    """Read ``path`` into ``model``; its key ``format`` must be ``format_name``.

    Raises:
        PlanError: every mistake on its own line, with file, line, key, value and remedy.
    """
    text = read_text(path, KIND)
    data = _syntax(path, text)
    if not isinstance(data, dict):
        raise PlanError(f"{path}:1: not a plan: the file must hold one JSON object")
    if data.get("format") != format_name:
        refuse_other(one_line(str(path)), data.get("format"), KIND)
        raise PlanError(
            f"{where(path, text, ('format',))}: {_other_format(data.get('format'), format_name)}"
        )
    found = list(_unusable(path, data))
    try:
        if not found:
            if len(text) > 2**17:  # pydantic would list every mistake there is, a kilobyte each
                beginning = json.dumps(_beginning(data))
                model.model_validate_json(beginning, by_alias=True, by_name=False)
            return model.model_validate_json(text, by_alias=True, by_name=False)
    except ValidationError as error:
        found = _mistakes(data, error)
    raise located(path, text, found)


def located(
    path: Path, text: str, mistakes: Sequence[tuple[Sequence[int | str], str]], *more: str
) -> PlanError:
    """Return the error that names the lines of ``text`` where mistakes are, and then says more."""
    lines = [f"{where(path, text, place)}: {wrong}" for place, wrong in mistakes[:MAX_SHOWN]]
    if len(mistakes) > MAX_SHOWN:
        lines.append(f"{path}: and {len(mistakes) - MAX_SHOWN} more mistakes")
    return PlanError("\n".join(map(one_line, (*lines, *more))))


def _other_format(given: object, format_name: str) -> str:
    if given == "gm-ompl-plan/1":
        return (
            f'"{given}": an older format, without the arcs along which the object moves; this '
            f'version reads "{format_name}": plan again (the scenario is in the file)'
        )
    return (
        f'{_shown(given)}: not a plan that can be read; a plan file says "format": "{format_name}"'
    )


class _DuplicateKeyError(ValueError): ...


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
        raise PlanError(f"{path}:{error.lineno}:{error.colno}: {hint}") from error
    except _DuplicateKeyError as error:
        raise PlanError(f"{path}: {error}") from error
    except (RecursionError, ValueError) as error:  # ValueError: an integer of too many digits
        raise PlanError(f"{path}: not a plan: nested too deeply or too long a number") from error


def _unusable(path: Path, data: Any) -> Iterator[Mistake]:
    """Yield the values that are no JSON although Python reads them, and what is wrong with each."""
    waiting: list[tuple[Place, Any]] = [((), data)]
    for _ in range(MAX_VALUES):
        if not waiting:
            return
        place, value = waiting.pop()
        if len(place) > MAX_DEPTH:
            raise PlanError(f"{path}: not a plan: nested too deeply, {key_path(place[:3])} ...")
        if isinstance(value, float) and not math.isfinite(value):
            yield place, f"{value}: must be a finite number"
        elif isinstance(value, str) and not is_text(value):
            yield place, f"{_shown(value)}: must be text; half of a surrogate pair is none"
        elif isinstance(value, dict):
            if not all(map(is_text, value)):
                yield place, "a key must be text; half of a surrogate pair is none"
                continue
            waiting.extend(((*place, key), value[key]) for key in reversed(value))
        elif isinstance(value, list):
            waiting.extend(((*place, i), value[i]) for i in reversed(range(len(value))))
    raise PlanError(f"{path}: not a plan: more than {MAX_VALUES} values")


def _beginning(value: Any) -> Any:
    """Return ``value`` with the first entries of every list and object alone."""
    if isinstance(value, dict):
        return {key: _beginning(value[key]) for key in itertools.islice(value, BEGINNING)}
    return [_beginning(item) for item in value[:BEGINNING]] if isinstance(value, list) else value


def _shown(value: Any) -> str:
    text = json.dumps(value, default=str)
    return text if len(text) <= 60 else text[:57] + "..."


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


def _mistakes(data: Any, error: ValidationError) -> list[Mistake]:
    """Return the place of every mistake that pydantic found, and what is wrong there."""
    found = [(_place(data, e["loc"]), e) for e in error.errors(include_url=False)]
    missing = [place for place, e in found[:MAX_SHOWN] if e["type"] == "missing"]
    mistakes = []
    for place, e in found:
        if e["type"] == "missing":
            wrong = _REMEDIES["missing"]
        elif e["type"] == "extra_forbidden":
            beside = [str(other[-1]) for other in missing if other[:-1] == place[:-1]]
            wrong = f"unknown key{did_you_mean(str(place[-1]), beside)}; remove it"
        else:
            remedy = _REMEDIES.get(e["type"], str(e["msg"])).format(**e.get("ctx", {}))
            wrong = f"{_shown(e['input'])}: {remedy}"
        mistakes.append((place, wrong))
    return mistakes


def _place(data: Any, loc: Sequence[int | str]) -> Place:
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


def where(path: Path, text: str, place: Sequence[int | str]) -> str:
    """Return "file:line: key path" of what stands at ``place`` in the valid JSON ``text``."""
    line = text.count("\n", 0, locate(text, place)) + 1
    return f"{path}:{line}: {key_path(place)}"


def key_path(place: Sequence[int | str]) -> str:
    """Return ``steps[3].cost`` for ("steps", 3, "cost")."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
    return text.lstrip(".") or "(top level)"


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
    while text[at] in " \t\r\n":
        at += 1
    return at
