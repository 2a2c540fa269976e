"""A few of what ``python -m tests.verify explored`` counts by the thousand."""

from __future__ import annotations

from tests.verify.count_explore import explored


def test_random_settings_are_answered() -> None:
    """Whatever is turned: a plan that holds in check, none, or words; no exception."""
    results = [explored(8 * k + k % 2) for k in range(16)]
    assert [result.note for result in results if not result.holds] == []
    assert {result.outcome for result in results} >= {"solved", "refused"}
