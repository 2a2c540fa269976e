"""The package list, what ships, and what importing costs."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from importlib.metadata import requires, version
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
HEAVY = (
    "fcl", "highspy", "meshcat", "numba", "numpy", "ompl", "pydantic", "scipy", "trimesh", "yaml",
)  # fmt: skip


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())


def test_package_list_is_the_tree(project: dict[str, Any]) -> None:
    """A sub-package left off the list would be missing from the wheel alone."""
    inside = {
        ".".join(path.parent.relative_to(ROOT).parts)
        for path in (ROOT / "gm_ompl").rglob("__init__.py")
    }
    outside = {
        "gm_ompl." + ".".join(path.parent.relative_to(ROOT).parts)
        for folder in ("scenarios", "viz")
        for path in (ROOT / folder).rglob("__init__.py")
    }
    assert set(project["tool"]["setuptools"]["packages"]) == inside | outside


def test_no_module_lies_outside_a_package() -> None:
    """Python files in a folder without __init__.py would not be packaged."""
    folders = {path.parent for top in ("gm_ompl", "viz") for path in (ROOT / top).rglob("*.py")}
    assert [folder for folder in folders if not (folder / "__init__.py").exists()] == []


def test_both_outer_folders_import_from_the_package() -> None:
    """viz/ and scenarios/ are gm_ompl.viz and gm_ompl.scenarios, here and in the wheel."""
    code = "import gm_ompl.viz, gm_ompl.scenarios; print(gm_ompl.viz.__file__)"
    result = _python("-c", code)
    assert result.returncode == 0, result.stderr


def test_the_wheel_is_tested_where_that_is_asked_for() -> None:
    """With GM_OMPL_TEST_WHEEL set, the package does not come from the checkout."""
    import gm_ompl

    from_checkout = Path(gm_ompl.__file__).is_relative_to(ROOT / "gm_ompl")
    assert not (from_checkout and os.environ.get("GM_OMPL_TEST_WHEEL"))


def test_tests_are_the_checkout_s() -> None:
    """A package that installs a ``tests`` of its own (dartpy does) does not stand in for them."""
    import tests

    assert tests.__file__ is not None
    assert Path(tests.__file__) == ROOT / "tests" / "__init__.py"
    found = subprocess.run(
        [sys.executable, "-c", "import tests; print(tests.__file__)"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert Path(found.stdout.strip()) == ROOT / "tests" / "__init__.py"


def test_data_files_ship() -> None:
    """The type marker and the scenarios are found through importlib.resources."""
    assert (files("gm_ompl") / "py.typed").is_file()
    shipped = [entry.name for entry in (files("gm_ompl.scenarios") / "paper").iterdir()]
    assert {"push.yaml", "slide.yaml"} <= set(shipped)


def test_version_has_one_place(project: dict[str, Any]) -> None:
    """The package's version is that of the installed distribution, which is the project file's."""
    import gm_ompl

    assert gm_ompl.__version__ == version("gm-ompl") == project["project"]["version"]
    assert f"## {gm_ompl.__version__}" in (ROOT / "CHANGELOG.md").read_text()


def test_ompl_is_pinned() -> None:
    """OMPL's bindings are used as tested: no other release is accepted."""
    assert "ompl==2.0.1" in (requires("gm-ompl") or [])


@pytest.mark.parametrize("arguments", [["--help"], ["plan", "--help"], ["check", "--help"]])
def test_help_imports_no_heavy_library(arguments: list[str]) -> None:
    """``--help`` answers at once: what a verb needs is imported when it runs.

    A verb's help may load pydantic: some releases of typer use it to describe options.
    """
    unwanted = [name for name in HEAVY if name != "pydantic" or len(arguments) == 1]
    code = f"""
import sys
from gm_ompl.app.main import app
try:
    app({arguments!r})
except SystemExit as done:
    assert not done.code, done.code
print("LOADED", *[name for name in {unwanted!r} if name in sys.modules])
"""
    result = _python("-c", code)
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "LOADED"


def test_planning_loads_what_it_needs_and_no_more() -> None:
    """A box that is planned by astar asks for no mesh, picture, simulation, study or OMPL."""
    unneeded = (
        "coacd", "dartpy", "distributed", "highspy", "IPython", "matplotlib", "meshcat", "mujoco",
        "networkx", "ompl", "optuna", "PIL", "plotly", "pyarrow",
    )  # fmt: skip
    code = f"""
import sys
from gm_ompl.app.main import app
try:
    app(["plan", "paper/slide", "--set", "lattice.segments=3",
         "--set", "fingers.placements.grid=[2, 2]"])
except SystemExit as done:
    assert not done.code, done.code
print("LOADED", *[name for name in {unneeded!r} if name in sys.modules])
"""
    result = _python("-c", code, patience=600)  # it may have to compile
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "LOADED"


def test_importing_the_package_imports_no_library() -> None:
    """``import gm_ompl`` is free; names load what they need."""
    result = _python(
        "-c", f"import gm_ompl, sys; print([n for n in {HEAVY!r} if n in sys.modules])"
    )
    assert result.stdout.strip() == "[]"


def _python(*arguments: str, patience: float = 120) -> subprocess.CompletedProcess[str]:
    # -P: the checkout's folder must not stand in for the installed package.
    return subprocess.run(
        [sys.executable, "-P", *arguments],
        capture_output=True,
        text=True,
        timeout=patience,
        check=False,
    )
