"""The regression of shipped scenarios notices what is worse, and only that."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.executed import PROVEN
from tests.verify.regression import BASELINE, Figures, main, read_baseline, worse

THEN = Figures("solved", 100.0, 1, 10.0, 200.0)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"status": "budget", "cost": None}, "status is budget"),
        ({"cost": 100.1}, "cost is 100.1"),
        ({"time_ratio": 16.0}, "1.60 times as long"),
        ({"memory_mb": 260.0}, "260 MiB"),
    ],
)
def test_what_is_worse_is_said(changes: dict[str, object], sentence: str) -> None:
    """Status, cost, time and memory, each by itself."""
    (found,) = worse(replace(THEN, **changes), THEN, unit=1.0)  # type: ignore[arg-type]
    assert sentence in found


def test_what_is_better_or_noise_is_not_worse() -> None:
    """Cheaper, quicker, smaller; and times too short to be told apart."""
    better = Figures("solved", 90.0, 1, 5.0, 100.0)
    assert list(worse(better, THEN, unit=1.0)) == []
    assert list(worse(replace(THEN, time_ratio=20.0), THEN, unit=0.001)) == []


def test_every_shipped_scenario_has_its_baseline() -> None:
    """The recorded baseline knows the shipped scenarios of known optimum and no other."""
    assert set(read_baseline(BASELINE)) == set(PROVEN)


def test_a_recorded_baseline_holds_until_it_is_better(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Against itself nothing is worse but, on a busy machine, time; a lower cost is noticed."""
    baseline = tmp_path / "baseline.json"
    assert main(["paper/slide", "--baseline", str(baseline)]) == 2
    assert main(["paper/slide", "--baseline", str(baseline), "--record"]) == 0
    tree = json.loads(baseline.read_text())
    tree["paper/slide"]["time_ratio"] *= 100.0
    baseline.write_text(json.dumps(tree))
    assert main(["paper/slide", "--baseline", str(baseline)]) == 0
    tree["paper/slide"]["cost"] *= 0.9
    baseline.write_text(json.dumps(tree))
    capsys.readouterr()
    assert main(["paper/slide", "--baseline", str(baseline)]) == 5
    assert "WORSE: cost is" in capsys.readouterr().out
