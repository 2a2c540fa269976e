"""The house keeps its order: what docs/results/size.md counts stays within the house's style."""

from __future__ import annotations

import ast

import pytest

from docs.tables import house


@pytest.fixture(scope="module")
def found() -> dict[str, list[str]]:
    return house.figures()


def test_no_circles_and_few_floors(found: dict[str, list[str]]) -> None:
    """No file imports itself by way of others; the longest chain of rooms does not grow."""
    assert found["circles of rooms"] == found["circles of files"] == []
    assert len(found["floors of imports"]) <= 12


def test_no_two_classes_share_a_name(found: dict[str, list[str]]) -> None:
    """One name means one thing, wherever it stands."""
    assert found["class names used twice"] == []


def test_files_and_functions_are_short(found: dict[str, list[str]]) -> None:
    """Files have at most 300 lines, functions 40."""
    assert found["files of more than 300 lines"] == []
    assert found["functions of more than 40 lines"] == []


def test_few_parameters_are_positional(found: dict[str, list[str]]) -> None:
    """At most seven, compiled functions' among them."""
    assert found["functions with more than 7 positional parameters"] == []


def test_what_is_wrong_is_found() -> None:
    """A circle, a name used twice and a long list of parameters do not pass unseen."""
    sources = {
        "gm_ompl.a.x": "from gm_ompl.b import y\nclass Twin: ...\ndef f(a, b, c, *, d): ...",
        "gm_ompl.b.y": "def g():\n    import gm_ompl.a.x\nclass Twin: ...",
    }
    trees = {name: ast.parse(text) for name, text in sources.items()}
    chain, rooms, files = house.floors(trees)
    assert (chain, rooms) == (["a = b"], [{"a", "b"}])
    assert files == [{"gm_ompl.a.x", "gm_ompl.b.y"}]
    assert house.shared_names(trees) == {"Twin": ["gm_ompl.a.x", "gm_ompl.b.y"]}
    counts = {name: house.parameters(node) for name, node in house.functions(trees)}
    assert counts == {"gm_ompl.a.x.f": 3, "gm_ompl.b.y.g": 0}
