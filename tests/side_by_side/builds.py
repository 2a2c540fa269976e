"""Builds of two versions of the package, each in an environment of its own below ``build/``."""

from __future__ import annotations

import hashlib
import io
import os
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
BUILDS: Final = ROOT / "build" / "side_by_side"
INSTALLED: Final = ("gm_ompl", "viz", "scenarios", "pyproject.toml", "README.md", "LICENSE")
"""What a wheel is made of."""


@dataclass(frozen=True)
class Build:
    """A version of the package in an environment of its own.

    Attributes:
        name: the commit, or "working tree".
        folder: of the environment.
    """

    name: str
    folder: Path

    @property
    def python(self) -> Path:
        """The environment's interpreter."""
        return self.folder / "bin" / "python"

    @property
    def command(self) -> Path:
        """The environment's ``gm-ompl``."""
        return self.folder / "bin" / "gm-ompl"

    def variables(self, cache: Path | None = None) -> dict[str, str]:
        """Return variables under which this build runs, its machine code kept in ``cache``."""
        kept = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        return {**kept, "XDG_CACHE_HOME": str(cache or self.folder / "cache")}


def of_commit(commit: str) -> Build:
    """Build a commit of the repository's history, unless that is done already."""
    whole = _git("rev-parse", "--verify", f"{commit}^{{commit}}").decode().strip()
    archive = _git("archive", whole, *INSTALLED)

    def unpack(folder: Path) -> None:
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            files.extractall(folder, filter="data")

    return _build(whole[:12], whole[:12], unpack)


def scenarios_of(commit: str) -> list[str]:
    """Return the names of the scenarios that a commit ships."""
    listed = _git("ls-tree", "-r", "--name-only", commit, "scenarios").decode().split()
    return [
        name.removeprefix("scenarios/").removesuffix(".yaml")
        for name in listed
        if name.endswith(".yaml")
    ]


def of_working_tree() -> Build:
    """Build what the working tree holds, unless that is done already; files that git ignores not.

    Environments of earlier working trees are removed.
    """
    listed = _git("ls-files", "-co", "--exclude-standard", "-z", *INSTALLED).decode()
    files = sorted(name for name in listed.split("\0") if name and (ROOT / name).is_file())
    digest = hashlib.sha256()
    for name in files:
        digest.update(name.encode() + b"\0" + (ROOT / name).read_bytes())
    place = f"tree-{digest.hexdigest()[:12]}"
    for earlier in BUILDS.glob("tree-*"):
        if earlier.name != place:
            shutil.rmtree(earlier)

    def copy(folder: Path) -> None:
        for name in files:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)

    return _build("working tree", place, copy)


def _build(name: str, place: str, unpack: Callable[[Path], None]) -> Build:
    """Install the sources that ``unpack`` writes; libraries that fit are shared with this run."""
    build, source = Build(name, BUILDS / place), BUILDS / place / "source"
    done = build.folder / "built"
    if done.exists():
        return build
    shutil.rmtree(build.folder, ignore_errors=True)
    source.mkdir(parents=True)
    unpack(source)
    subprocess.run([sys.executable, "-m", "venv", build.folder], check=True)
    libraries = next(build.folder.glob("lib/python*/site-packages"))
    # A line names a folder; it is searched after the environment's own, so the package itself, and
    # what its pyproject asks for in another version, come from the environment.
    shared = [path for path in sys.path if path.endswith("site-packages")]
    (libraries / "shared.pth").write_text("".join(f"{path}\n" for path in shared))
    pip: list[Path | str] = [
        build.python,
        "-m",
        "pip",
        "install",
        "-q",
        "--disable-pip-version-check",
    ]
    subprocess.run([*pip, "--ignore-installed", "--no-deps", source], check=True)
    subprocess.run([*pip, source], check=True)
    done.touch()
    return build


def _git(*words: str) -> bytes:
    return subprocess.run(["git", *words], cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout
