"""Scenario, plan and parameter files changed at random, as slips, editors and programs change them.

``mutated(instance)`` is the same file for the same number, everywhere.
"""

from __future__ import annotations

import copy
import functools
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

import gm_ompl
from gm_ompl.planners.registry import PLANNERS
from gm_ompl.scenario.load import read, shipped

SMALL = {
    "paper/slide": ("lattice.segments=3", "fingers.placements.grid=[2, 2]"),
    "paper/regrasp": ("lattice.segments=4", "fingers.placements.grid=[3, 3]"),
    "planar/turn": ("fingers.placements.grid=[2, 2]",),
}
"""Scenarios made small enough to be planned in a moment: their plans are mutated."""

PARAMETRIC = ("astar", "HybridRRT", "HybridRRTConnect", "HybridRRTstar", "RRTConnect", "BITstar")

NUMBERS: tuple[Any, ...] = (
    0, -1, 1, 2, 7, 0.5, -0.0, 1e-300, 1e-30, 1e-9, 1e9, 1e14, 1e16, 1e30, 1e300, -1e300,
    float("inf"), float("-inf"), float("nan"), 10**30, 2**63, 10**400,
)  # fmt: skip
WORDS: tuple[str, ...] = (
    "", " ", "any", "all", "+x", "nan", "1e5", "90 deg", "1e400 rad", "%s %d %n", "{} {0} {x}",
    "$HOME", "../../etc/passwd", "ä ö 漢字 🤖", "\u202eabc", "a\nb\r\nc", "a\0b", "\ud800",
    "x" * 5000, "[bold]x[/bold]", "$\\frac{1", "<script>alert(1)</script>", "\x1b[31m", "true",
    "null", "~",
)  # fmt: skip
OTHERS: tuple[Any, ...] = (None, True, False, [], {}, [[]], {"": {}}, [None], ["any", 1, {}])

Tree = Any
Path = tuple[Any, ...]


@dataclass(frozen=True)
class Mutant:
    """A mutated file.

    Attributes:
        kind: "scenario", "plan" or "parameters".
        origin: what was mutated: a scenario's name, or a planner's.
        content: of the file.
    """

    kind: str
    origin: str
    content: bytes


def mutated(instance: int) -> Mutant:
    """Return file number ``instance``: half are scenarios, a third plans, the rest parameters."""
    rng = np.random.default_rng([2005, instance])
    kind = ("scenario", "plan", "scenario", "plan", "scenario", "parameters")[instance % 6]
    origin, tree = _original(kind, rng)
    for _ in range(_pick(rng, (1, 1, 1, 2, 3))):
        path = _somewhere(tree, rng)
        tree = _pick(rng, CHANGES)(tree, path, rng)
    text = _written(tree, kind, rng)
    content = text.encode("utf-8", errors="surrogatepass")
    if rng.random() < 0.1:
        content = _pick(rng, DAMAGES)(content, rng)
    return Mutant(kind, origin, content)


def _original(kind: str, rng: np.random.Generator) -> tuple[str, Tree]:
    if kind == "parameters":
        name = _pick(rng, PARAMETRIC)
        return name, {p.name: p.default for p in PLANNERS[name].parameters} or {"seed": 1}
    if kind == "plan":
        name = _pick(rng, tuple(SMALL))
        return name, copy.deepcopy(plan_of(name))
    name = _pick(rng, shipped())
    tree: Tree = copy.deepcopy(read(name).tree)
    tree["fingers"].setdefault("placements", {})["grid"] = [2, 2]
    return name, tree


@functools.cache
def plan_of(name: str) -> Tree:
    """Return the plan of a small scenario as its file holds it."""
    scenario = gm_ompl.load(name, SMALL[name])
    return gm_ompl.plan(scenario, "HybridRRTConnect", max_iterations=5000).to_dict()


def _pick(rng: np.random.Generator, choices: Any) -> Any:
    return choices[int(rng.integers(len(choices)))]


def _paths(tree: Tree, path: Path = ()) -> Iterator[Path]:
    yield path
    if isinstance(tree, (dict, list)):
        for key in tree if isinstance(tree, dict) else range(len(tree)):
            yield from _paths(tree[key], (*path, key))


def _somewhere(tree: Tree, rng: np.random.Generator) -> Path:
    """Return a path below the top, each depth as likely as another."""
    path: Path = ()
    here = tree
    while isinstance(here, (dict, list)) and here and (not path or rng.random() < 0.75):
        key = _pick(rng, list(here)) if isinstance(here, dict) else int(rng.integers(len(here)))
        path, here = (*path, key), here[key]
    return path


def _at(tree: Tree, path: Path) -> Tree:
    for key in path:
        tree = tree[key]
    return tree


def _set(tree: Tree, path: Path, value: Any) -> Tree:
    if not path:
        return value
    _at(tree, path[:-1])[path[-1]] = value
    return tree


def _delete(tree: Tree, path: Path, _: np.random.Generator) -> Tree:
    if path:
        del _at(tree, path[:-1])[path[-1]]
    return tree


def _rename(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    holder = _at(tree, path[:-1])
    if path and isinstance(holder, dict):
        key = str(path[-1])
        holder[_pick(rng, (key[:-1], key + "s", key.upper(), *WORDS))] = holder.pop(path[-1])
    return tree


def _repeat(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    holder = _at(tree, path[:-1])
    if path and isinstance(holder, list):
        holder[path[-1] : path[-1]] = [
            copy.deepcopy(holder[path[-1]]) for _ in range(_pick(rng, (1, 2, 30)))
        ]
    return tree


def _number(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    return _set(tree, _leaf(tree, path, rng, (int, float)), _pick(rng, NUMBERS))


def _scale(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    leaf = _leaf(tree, path, rng, (int, float))
    value = _at(tree, leaf)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return tree
    factor = _pick(rng, (-1, 0.5, 1 + 1e-9, 1.1, 2, 10, 1e-6, 1e6))
    return _set(tree, leaf, type(value)(value * factor) if abs(value) < 1e15 else value)


def _leaf(tree: Tree, path: Path, rng: np.random.Generator, kinds: Any) -> Path:
    """Return a path at or below ``path`` with a value of these kinds, or ``path``."""
    below = [(*path, *more) for more in _paths(_at(tree, path))]
    fitting = [found for found in below if isinstance(_at(tree, found), kinds)]
    return _pick(rng, fitting) if fitting else path


def _word(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    return _set(tree, _leaf(tree, path, rng, str), _pick(rng, WORDS))


def _other(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    return _set(tree, path, copy.deepcopy(_pick(rng, OTHERS)))


def _swap(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    """Put one part of the file in another's place."""
    return _set(tree, path, copy.deepcopy(_at(tree, _somewhere(tree, rng))))


def _nest(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    value: Tree = copy.deepcopy(_at(tree, path))
    for _ in range(_pick(rng, (1, 2, 50, 150))):
        value = [value] if rng.random() < 0.5 else {"x": value}
    return _set(tree, path, value)


def _long(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    return _set(tree, path, [_pick(rng, (0, 1.5, "x"))] * _pick(rng, (3, 100, 20_000)))


def _extra(tree: Tree, path: Path, rng: np.random.Generator) -> Tree:
    here = _at(tree, path)
    if isinstance(here, dict):
        here[_pick(rng, WORDS)] = _pick(rng, NUMBERS + OTHERS)
    return tree


CHANGES: tuple[Callable[[Tree, Path, np.random.Generator], Tree], ...] = (
    _delete, _rename, _repeat, _number, _number, *[_scale] * 6, _word, _other, _swap, _nest, _long,
    _extra,
)  # fmt: skip


def _written(tree: Tree, kind: str, rng: np.random.Generator) -> str:
    """Return the tree as JSON, or where it can be as YAML."""
    if kind == "plan" or rng.random() < 0.3:
        return json.dumps(tree, indent=1, ensure_ascii=bool(rng.random() < 0.5))
    return yaml.safe_dump(tree, sort_keys=False, allow_unicode=True)


def _cut(content: bytes, rng: np.random.Generator) -> bytes:
    return content[: int(rng.integers(len(content) + 1))]


def _noise(content: bytes, rng: np.random.Generator) -> bytes:
    at = int(rng.integers(len(content) + 1))
    return content[:at] + rng.bytes(int(rng.integers(1, 40))) + content[at + 1 :]


def _double(content: bytes, _: np.random.Generator) -> bytes:
    return content + b"\n" + content


def _marked(content: bytes, _: np.random.Generator) -> bytes:
    return b"\xef\xbb\xbf" + content


def _wide(content: bytes, _: np.random.Generator) -> bytes:
    return content.decode("utf-8", errors="replace").encode("utf-16")


def _carriage(content: bytes, _: np.random.Generator) -> bytes:
    return content.replace(b"\n", b"\r\n")


def _nothing(_: bytes, rng: np.random.Generator) -> bytes:
    nothing: bytes = _pick(
        rng, (b"", b"\n", b"null", b"[]", b"{}", b"\0", b"---\n...\n", b"%", b"&a *a")
    )
    return nothing


def _random(_: bytes, rng: np.random.Generator) -> bytes:
    return rng.bytes(500)


DAMAGES: tuple[Callable[[bytes, np.random.Generator], bytes], ...] = (
    _cut, _cut, _noise, _noise, _double, _marked, _wide, _carriage, _nothing, _random,
)  # fmt: skip
