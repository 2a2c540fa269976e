"""``python -m docs.tables.house [PAGE]``: the house in figures, for docs/results/size.md.

Counts lines, floors of imports, circles, names used twice, and what is longer or takes more than
the house's style allows; the table says how many, stdout says which.
"""

from __future__ import annotations

import ast
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TypeAlias

import networkx as nx

from docs.tables.pages import write_page
from gm_ompl.study.report import number, table

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("gm_ompl", "viz", "docs")

MOST_LINES, MOST_IN_FUNCTION, MOST_PARAMETERS = 300, 40, 7
"""Of a file; of a function without its docstring; positional ones of a function."""

Trees: TypeAlias = Mapping[str, ast.Module]  # every module, by its dotted name as it is imported
Function: TypeAlias = ast.FunctionDef | ast.AsyncFunctionDef


def sources() -> dict[str, Path]:
    """Return the files by the names of their modules."""
    found = {}
    for path in sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")):
        parts = list(path.relative_to(ROOT).with_suffix("").parts)
        parts = ["gm_ompl", *parts] if parts[0] == "viz" else parts
        found[".".join(parts).removesuffix(".__init__")] = path
    return found


def imports(trees: Trees) -> Iterator[tuple[str, str]]:
    """Yield (module, module that it imports), inside functions too, but not for types alone."""
    for module, tree in trees.items():
        for node in _run(tree):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                above = ".".join(module.split(".")[: -node.level]) if node.level else ""
                base = ".".join(filter(None, (above, node.module)))
                names = [f"{base}.{alias.name}" for alias in node.names]
                names = [name if name in trees else base for name in names]
            else:
                continue
            yield from ((module, name) for name in names if name in trees and name != module)


def _run(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a module, those for type checkers alone left out."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        yield node
        yield from _run(node)


def room(module: str) -> str:
    """Return the top-level room of a module: a folder or a file of the package."""
    return module.split(".")[1] if "." in module else module


def floors(trees: Trees) -> tuple[list[str], list[set[str]], list[set[str]]]:
    """Return the longest chain of rooms, and the circles of rooms and of files."""
    files = nx.DiGraph(
        (a, b)
        for a, b in imports(trees)
        if a.startswith("gm_ompl.") and b.startswith("gm_ompl.") and room(a) != "__main__"
    )
    rooms = nx.DiGraph((room(a), room(b)) for a, b in files.edges if room(a) != room(b))
    whole = nx.condensation(rooms)
    chain = [" = ".join(sorted(whole.nodes[k]["members"])) for k in nx.dag_longest_path(whole)]
    room_circles, file_circles = (
        [circle for circle in nx.strongly_connected_components(graph) if len(circle) > 1]
        for graph in (rooms, files)
    )
    return chain, room_circles, file_circles


def shared_names(trees: Trees) -> dict[str, list[str]]:
    """Return the public classes whose names stand in several modules, with the modules."""
    places = defaultdict[str, list[str]](list)
    for module, tree in trees.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(module)
    return {name: where for name, where in sorted(places.items()) if len(where) > 1}


def functions(trees: Trees) -> Iterator[tuple[str, Function]]:
    """Yield every function with where it stands."""
    for module, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield f"{module}.{node.name}", node


def length(function: Function) -> int:
    """Return a function's lines without its docstring."""
    first = function.body[0]
    told = ast.get_docstring(function) is not None
    own = (first.end_lineno or first.lineno) - first.lineno + 1 if told else 0
    return (function.end_lineno or function.lineno) - function.lineno + 1 - own


def parameters(function: Function) -> int:
    """Return how many parameters may be given by position, ``self`` and ``cls`` left out."""
    given = [arg.arg for arg in (*function.args.posonlyargs, *function.args.args)]
    return len([name for name in given if name not in ("self", "cls")])


def figures() -> dict[str, list[str]]:
    """Return what is counted, in words, with what was found."""
    files = sources()
    texts = {module: path.read_text(encoding="utf-8") for module, path in files.items()}
    trees = {module: ast.parse(text) for module, text in texts.items()}
    lines = {module: text.count("\n") for module, text in texts.items()}
    per_room = defaultdict[str, int](int)
    for module, count in lines.items():
        per_room[room(module)] += count
    chain, room_circles, file_circles = floors(trees)
    known = list(functions(trees))
    return {
        "lines": [f"{name} {count}" for name, count in sorted(per_room.items())],
        "floors of imports": chain,
        "circles of rooms": [", ".join(sorted(circle)) for circle in room_circles],
        "circles of files": [", ".join(sorted(circle)) for circle in file_circles],
        "class names used twice": [
            f"{name}: {', '.join(where)}" for name, where in shared_names(trees).items()
        ],
        f"functions with more than {MOST_PARAMETERS} positional parameters": [
            name for name, function in known if parameters(function) > MOST_PARAMETERS
        ],
        f"files of more than {MOST_LINES} lines": [
            module for module, count in lines.items() if count > MOST_LINES
        ],
        f"functions of more than {MOST_IN_FUNCTION} lines": [
            name for name, function in known if length(function) > MOST_IN_FUNCTION
        ],
    }


def main() -> None:
    """Write the table, and say what it counts."""
    found = figures()
    counts = {what: len(which) for what, which in found.items()}
    counts["lines"] = sum(int(line.split()[-1]) for line in found["lines"])
    for what, which in found.items():
        sys.stdout.write(f"{what}: {counts[what]}\n" + "".join(f"  {name}\n" for name in which))
    rows = [(what, number(count)) for what, count in counts.items()]
    write_page("size", {"house": [table(("figure", "count"), rows)]})


if __name__ == "__main__":
    main()
