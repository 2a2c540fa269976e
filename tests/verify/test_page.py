"""The page of the long counts."""

from __future__ import annotations

from tests.verify import counting
from tests.verify.__main__ import TABLE, register


def test_every_count_has_a_row() -> None:
    """What is claimed stands in the table, also where it was never counted in full."""
    register()
    page = TABLE.read_text()
    rows = [line.split(" | ")[0].removeprefix("| ") for line in page.splitlines()]
    assert {"limits", "moved_meshes", "rest_hulls", "rest_meshes"} <= counting.REGISTRY.keys()
    assert [row for row in rows if row in counting.REGISTRY] == sorted(counting.REGISTRY)
