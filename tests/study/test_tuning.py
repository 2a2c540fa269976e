"""Tuning: what is searched, that a killed study goes on as if undisturbed, and honest gains."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest

import gm_ompl
from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.forks import RunLimits
from gm_ompl.planners.registry import PLANNERS
from gm_ompl.study.report import tuning_html
from gm_ompl.study.scores import PENALTY, gain, score
from gm_ompl.study.store import RunRecord, Store
from gm_ompl.study.task import Task
from gm_ompl.study.tuning import OBJECTIVES, Design, searched, tune
from gm_ompl.study.workers import Outcome

EVIL = "<img src=x onerror=alert(1)>"


class Pretended:
    """Runs whose mode decisions and cost are known functions of the parameters."""

    def __init__(self, breaks_after: int | None = None) -> None:
        self.made: list[str] = []
        self.breaks_after = breaks_after

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, Outcome]]:
        for task in tasks:
            if len(self.made) == self.breaks_after:
                raise KeyboardInterrupt
            self.made.append(task.key())
            lean = float(task.parameters["placement_bias"])
            decisions = round(1000.0 * (1.0 + (lean - 5.0) ** 2)) + task.seed % 7
            yield task, {
                "status": "solved", "cost": 10.0 + lean, "first_plan_s": 0.1, "search_s": 0.2,
                "mode_decisions": decisions, "first_plan_decisions": decisions,
            }  # fmt: skip

    def close(self) -> None:
        pass


def design(objective: str = "decisions", trials: int = 12) -> Design:
    training, held = ["paper/slide", "paper/push"], ["random/small/4"]
    return Design("HybridRRT", list(map(gm_ompl.load, training)), list(map(gm_ompl.load, held)),
                  2, RunLimits(max_iterations=50), objective, trials, 0)  # fmt: skip


def test_only_bounded_parameters_are_searched() -> None:
    """Every parameter searched has two ends or choices, and its default lies within."""
    for planner in PLANNERS.values():
        for parameter in searched(planner.parameters):
            assert parameter.checked(parameter.default) == parameter.default
            assert parameter.kind in (bool, str) or None not in (parameter.low, parameter.high)


def test_tuning_finds_what_is_better_and_says_how_much(tmp_path: Path) -> None:
    """Of a bowl about a bias of 5 the winner is nearer than the default, 2; its gain the ratio."""
    with Store(tmp_path / "runs.sqlite") as store:
        tuned = tune(design(trials=30), store, Pretended(), tmp_path / "journal")
    first, best = tuned.trials[0], tuned.trials[tuned.best]
    defaults = {p.name: p.default for p in PLANNERS["HybridRRT"].parameters}
    assert first.parameters == defaults
    lean = float(best.parameters["placement_bias"])
    assert abs(lean - 5.0) < 1.5 and best.values < first.values
    assert max(tuned.importances, key=lambda name: tuned.importances[name]) == "placement_bias"
    won = tuned.gains["decisions"]
    assert won.supported and won.factor == pytest.approx(10.0 / (1 + (lean - 5) ** 2), rel=0.05)
    assert tuned.gains["cost"].factor == pytest.approx(12.0 / (10.0 + lean))
    page = tuning_html(tuned, OBJECTIVES["decisions"], EVIL)
    assert EVIL not in page and page.count('class="plotly-graph-div"') == 2


def test_a_killed_study_goes_on_as_if_undisturbed(tmp_path: Path) -> None:
    """No finished trial or run is made again, and every further trial is the same."""
    with Store(tmp_path / "calm.sqlite") as store:
        calm = tune(design(), store, Pretended(), tmp_path / "calm")
    first, second = Pretended(breaks_after=22), Pretended()
    with Store(tmp_path / "runs.sqlite") as store:
        with pytest.raises(KeyboardInterrupt):
            tune(design(), store, first, tmp_path / "journal")
        again = tune(design(), store, second, tmp_path / "journal")
    assert [trial.parameters for trial in again.trials] == [t.parameters for t in calm.trials]
    assert (again.best, again.gains) == (calm.best, calm.gains)
    assert not set(first.made) & set(second.made)


def test_two_objectives_give_a_front(tmp_path: Path) -> None:
    """No trial of the front is beaten by another; decisions and cost pull apart."""
    with Store(tmp_path / "runs.sqlite") as store:
        tuned = tune(design("both", 15), store, Pretended(), tmp_path / "journal")
    assert tuned.best in tuned.front and len(tuned.front) > 1
    for place in tuned.front:
        own = tuned.trials[place].values
        assert not any(
            all(a < b for a, b in zip(other.values, own, strict=True)) for other in tuned.trials
        )
    assert tuning_html(tuned, OBJECTIVES["both"], "both").count('class="plotly-graph-div"') == 4


@pytest.mark.parametrize("objective", ["z", "tolerance"])
def test_tuning_knows_margins_and_tolerances(objective: str, tmp_path: Path) -> None:
    """Where a parameter makes plans more robust it is found, against what is as robust today."""

    class Robust(Pretended):
        """Plans hold the more, and tolerate the more, the nearer a parameter is to 5."""

        def run(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, Outcome]]:
            for task, outcome in super().run(tasks):
                good = 1.0 / (1.0 + (float(task.parameters["placement_bias"]) - 5.0) ** 2)
                assert task.tolerance == (objective == "tolerance")
                yield task, {**outcome, "cost": 1.0, "least_z": good, "tolerance": good}

    with Store(tmp_path / "runs.sqlite") as store:
        tuned = tune(design(objective, 15), store, Robust(), tmp_path / "journal")
    assert abs(float(tuned.trials[tuned.best].parameters["placement_bias"]) - 5.0) < 1.5
    found = tuned.gains[objective]
    assert found.supported and found.factor > 1.0


def test_what_is_robust_is_scored_by_its_inverse() -> None:
    """Half the margin, or the tolerance, of the defaults is twice their measure; none is ten."""
    base = [record("a", 0, 1, least_z=2.0, tolerance=1.0)]
    for name in ("z", "tolerance"):
        worse = [record("a", 0, 1, least_z=1.0, tolerance=0.5)]
        assert score(name, base, base) == pytest.approx(1.0)
        assert score(name, worse, base) == pytest.approx(2.0)
        none = [record("a", 0, 1, least_z=0.0, tolerance=0.0)]
        assert score(name, none, base) == pytest.approx(PENALTY)


def record(
    scenario: str, seed: int, decisions: int, *, solved: bool = True,
    least_z: float | None = None, tolerance: float | None = None,
) -> RunRecord:  # fmt: skip
    return RunRecord(
        key=f"{scenario}{seed}", scenario=scenario, scenario_key=scenario, planner="p",
        parameters={}, seed=seed, time_limit=None, memory_limit=None, max_iterations=9, code="",
        status="solved" if solved else "budget", cost=1.0 if solved else None,
        mode_decisions=decisions, first_plan_decisions=decisions if solved else None,
        least_z=least_z, tolerance=tolerance,
    )  # fmt: skip


def test_a_run_without_a_plan_counts_ten_times() -> None:
    """The geometric mean of 100 and of 10 x 1000."""
    runs = [record("a", 0, 100), record("a", 1, 1000, solved=False)]
    assert score("decisions", runs, runs) == pytest.approx(1000.0)


def test_intervals_of_gains_hold_what_they_say() -> None:
    """Of 60 pairs of samples with a true factor of 2, about 95% of the intervals hold it."""
    rng, held = np.random.default_rng(0), 0
    for _ in range(60):
        old, new = [], []
        for scenario in "abcdefghijklmno":
            hard = rng.normal(7.0, 1.0)
            for seed in range(3):
                old.append(record(scenario, seed, round(math.exp(hard + rng.normal(0.7, 0.5)))))
                new.append(record(scenario, seed, round(math.exp(hard + rng.normal(0.0, 0.5)))))
        found = gain("decisions", old, new)
        held += found.low <= math.exp(0.7) <= found.high
    assert held >= 0.85 * 60


def test_wrong_designs_are_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The same scenario on both sides, nothing held out, nothing to tune, optuna missing."""
    slide, good = gm_ompl.load("paper/slide"), design()
    for planner, held in (("HybridRRT", [slide]), ("HybridRRT", []), ("nonsense", good.held_out)):
        with pytest.raises(InputError):
            Design(planner, [slide], held, 1, RunLimits(), "time", 1, 0)
    monkeypatch.setitem(sys.modules, "optuna", None)
    with (
        Store(tmp_path / "runs.sqlite") as store,
        pytest.raises(MissingExtraError, match=r"gm-ompl\[tune\]"),
    ):
        tune(good, store, Pretended(), tmp_path / "journal")


def test_the_command_writes_what_plan_reads(tmp_path: Path) -> None:
    """PARAMS works with ``plan --params``; a second call makes no trial and says the same."""
    params = tmp_path / "params.json"
    command = [
        sys.executable, "-P", "-m", "gm_ompl", "tune", "random/small/1", "random/small/4",
        "random/small/5", "--planner", "HybridRRT", "--trials", "2", "--seeds", "1",
        "--max-iterations", "30", "-o", str(params),
    ]  # fmt: skip
    first = subprocess.run(command, capture_output=True, text=True)
    assert first.returncode == 0, first.stderr
    assert "held out, decisions" in first.stdout
    assert (tmp_path / "params-study" / "report.html").exists()
    scenario = gm_ompl.load("random/small/4")
    gm_ompl.plan(scenario, "HybridRRT", max_iterations=5, parameters=json.loads(params.read_text()))
    again = subprocess.run(command, capture_output=True, text=True)
    assert again.stdout == first.stdout and "trial 0 of" not in again.stderr
