"""``python -m docs.tables.size [PAGE]``: what an installation without extras weighs.

Installs the checkout into a fresh environment, and weighs each distribution there. Takes a minute
or two, and what pip must download.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import venv
from collections.abc import Iterator, Mapping
from importlib.metadata import Distribution, distributions
from pathlib import Path
from typing import Final

from docs.tables.pages import write_page
from gm_ompl.study.report import table

ROOT: Final = Path(__file__).resolve().parents[2]
MOST: Final = 620.0
"""An environment may weigh this much [MB of 1024 x 1024 bytes], pip and setuptools included."""

OWN: Final = "gm-ompl"
HEAD: Final = ("dependency", "MB", "MB with what it alone brings", "brings")


def named(text: str) -> str:
    """Return the name that a requirement or a distribution begins with, as pip compares names."""
    found = re.match(r"[\w.-]+", text)
    assert found is not None
    return re.sub(r"[-_.]+", "-", found[0]).lower()


def needs(one: Distribution) -> set[str]:
    """Return the names of what a distribution asks for without extras."""
    return {named(text) for text in one.requires or () if "extra ==" not in text}


def weight(one: Distribution) -> float:
    """Return how much of the disk its files take [MB], compiled modules included."""
    files = {Path(str(one.locate_file(file))).resolve() for file in one.files or ()}
    for file in [path for path in files if path.suffix == ".py"]:
        files |= set((file.parent / "__pycache__").glob(f"{file.stem}.*.pyc"))
    return sum(path.stat().st_blocks for path in files if path.is_file()) * 512 / 2**20


def reached(start: set[str], asked: Mapping[str, set[str]]) -> set[str]:
    """Return what is asked for from ``start`` on, at whatever depth."""
    found: set[str] = set()
    waiting = list(start)
    while waiting:
        name = waiting.pop()
        if name in asked and name not in found:
            found.add(name)
            waiting += asked[name]
    return found


def rows(folder: Path) -> Iterator[tuple[str, str, str, str]]:
    """Yield a row per dependency in the environment whose packages lie in ``folder``, then sums."""
    installed = {named(one.name): one for one in distributions(path=[str(folder)])}
    asked = {name: needs(one) for name, one in installed.items()}
    sizes = {name: weight(one) for name, one in installed.items()}
    shares = []
    for name in asked[OWN] & installed.keys():
        alone = reached({name}, asked) - reached(asked[OWN] - {name}, asked)
        shares.append((sum(sizes[one] for one in alone), name, sorted(alone - {name})))
    for whole, name, others in sorted(shares, reverse=True):
        yield name, f"{sizes[name]:.0f}", f"{whole:.0f}", ", ".join(others)
    yield "gm-ompl itself", f"{sizes[OWN]:.0f}", "", ""


def environment(folder: Path) -> Path:
    """Install the checkout into a new environment; return where its packages lie."""
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "-qq", ROOT], check=True)
    return next((folder / "lib").glob("python3.*")) / "site-packages"


def whole(folder: Path) -> float:
    """Return how much of the disk a folder takes [MB]."""
    return sum(path.lstat().st_blocks for path in folder.rglob("*")) * 512 / 2**20


def main() -> int:
    """Measure and write; exit code 1 where it is too much."""
    with tempfile.TemporaryDirectory() as scratch:
        packages = environment(Path(scratch))
        total = whole(Path(scratch))
        found = [*rows(packages), ("the environment", f"{total:.0f}", f"at most {MOST:.0f}", "")]
    write_page("size", {"size": [table(HEAD, found)]})
    sys.stdout.write(f"{total:.0f} MB of at most {MOST:.0f}\n")
    return int(total > MOST)


if __name__ == "__main__":
    sys.exit(main())
