"""Files changed at random: every verb says what it makes of them; none breaks."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.app.mutations import mutated
from tests.app.verbs import trouble

PART = range(60)
"""The rest is a count of ``make verify``, but for"""
KEPT = (171,)
"""what broke once: HiGHS, asked without presolve, ends a direction of a plan with "Unknown"."""


@pytest.mark.parametrize("first", PART[::10])
def test_mutated_files_end_well(first: int, tmp_path: Path) -> None:
    """Exit code 0, 2, 3, 4 or 5, no traceback, no library's warning, nothing that hangs."""
    found = [line for n in range(first, first + 10) for line in trouble(mutated(n), tmp_path, n)]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("number", KEPT)
def test_what_broke_once_ends_well(number: int, tmp_path: Path) -> None:
    """Files that a verb ended with 1 for."""
    assert not trouble(mutated(number), tmp_path, number)


def test_a_mutant_is_the_same_every_time() -> None:
    """A number names a file, and the kinds are mixed."""
    assert [mutated(n) for n in range(6)] == [mutated(n) for n in range(6)]
    assert {mutated(n).kind for n in range(6)} == {"scenario", "plan", "parameters"}
