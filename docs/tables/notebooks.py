"""``python -m docs.tables.notebooks``: the examples as notebooks, from their scripts.

A script's docstring becomes a text, ``# %% words`` a text before the cell that it begins.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Final

EXAMPLES: Final = Path(__file__).resolve().parents[1] / "examples"
SCRIPT: Final = re.compile(
    r"(?P<needs># /// script\n(?:#.*\n)*?# ///\n)\"\"\"(?P<text>.*?)\"\"\"\n(?P<code>.*)", re.DOTALL
)
CELL: Final = re.compile(r"^# %%(.*)\n", re.MULTILINE)


def notebook(script: str) -> str:
    """Return a script's notebook, as the text of its file."""
    found = SCRIPT.fullmatch(script)
    assert found is not None, "an example begins with what it needs and a docstring"
    needed = re.search(r'dependencies = \["(.*)"\]', found["needs"])
    assert needed is not None
    cells = [_text(found["text"]), _code(f'# %pip install "{needed[1]}"')]
    first, *parts = CELL.split(found["code"])
    cells += [_code(first)] if first.strip() else []
    for words, code in zip(parts[::2], parts[1::2], strict=True):
        cells += [_text(words)] if words.strip() else []
        cells.append(_code(code))
    for k, cell in enumerate(cells):
        cell["id"] = f"cell-{k}"
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    made = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(made, indent=1) + "\n"


def _text(text: str) -> dict[str, Any]:
    return {"cell_type": "markdown", "metadata": {}, "source": text.strip()}


def _code(text: str) -> dict[str, Any]:
    return {"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": [],
            "source": text.strip()}  # fmt: skip


def main() -> None:
    """Write every notebook."""
    folder = EXAMPLES / "notebooks"
    folder.mkdir(exist_ok=True)
    for script in sorted(EXAMPLES.glob("*.py")):
        (folder / f"{script.stem}.ipynb").write_text(notebook(script.read_text()))


if __name__ == "__main__":
    main()
