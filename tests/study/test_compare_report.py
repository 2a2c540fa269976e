"""What a comparison tells: figures, intervals, the page, OMPL's log, the command."""

from __future__ import annotations

import json
import math
import os
import re
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from docs.tables.comparison import Comparison, marked, references, runs
from docs.tables.pages import write_tables
from gm_ompl.errors import MissingExtraError
from gm_ompl.study.ompl_log import STATUSES, write_benchmark
from gm_ompl.study.report import cost_quantiles, report_html, success_curve
from gm_ompl.study.store import RunRecord, write_parquet
from gm_ompl.study.summary import difference, differences, paired_difference, summarise

EVIL = "<img src=x onerror=alert(1)></script>'\"; [bold]"
OPTIMA = {"k": 10.0}


def run(
    planner: str, seed: int, time: float | None, cost: float | None, **more: object
) -> RunRecord:
    values: dict[str, object] = {
        "key": f"{planner}{seed}", "scenario": EVIL, "scenario_key": "k", "planner": planner,
        "parameters": {"range_share": 0.5}, "seed": seed, "time_limit": 5.0, "memory_limit": None,
        "max_iterations": None, "code": "1", "status": "budget" if cost is None else "solved",
        "cost": cost, "first_plan_s": time, "search_s": 5.0, "peak_mb": 100.0,
        "regrasps": None if cost is None else 1, "least_z": None if cost is None else 0.5,
        "mode_decisions": 3, "iterations": 4,
        "history": () if time is None or cost is None
        else ((time, 2 * cost, 0.0), (2 * time, cost, 0.0)),
    }  # fmt: skip
    return RunRecord(**{**values, **more})  # type: ignore[arg-type]


RUNS = (
    run("astar", 0, 1.0, 10.0, optimal=True),
    *(run("RRT", seed, 0.5 + 0.1 * seed, 12.0 + seed) for seed in range(3)),
    run("RRT", 3, None, None, status="crash"),
)


def test_summaries_count_runs_without_a_plan() -> None:
    """Success is a share of all runs; the median time treats a failed run as infinite."""
    astar, rrt = summarise(RUNS, OPTIMA)
    assert (astar.success, astar.ratio, astar.first_plan_s) == (1.0, 1.0, 1.0)
    assert rrt.success == 0.75 and rrt.others == {"crash": 1}
    assert rrt.first_plan_s == pytest.approx(0.7)  # of 0.5, 0.6, 0.7, inf: the upper middle
    assert rrt.ratio == pytest.approx(1.3)
    (alone,) = summarise([run("RRT", 0, None, None)], OPTIMA)
    assert alone.first_plan_s is None and alone.cost is None and alone.ratio is None


def test_intervals_hold_the_true_difference_as_often_as_they_say() -> None:
    """Of 200 pairs of normal samples of 30, about 95% of the intervals hold the difference."""
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(200):
        a, b = rng.normal(3.0, 1.0, 30), rng.normal(1.0, 2.0, 30)
        _, low, high = difference(a, b, lambda x: np.asarray(x.mean(axis=-1)))
        assert low is not None and high is not None
        held += low <= 2.0 <= high
    assert 0.88 * 200 <= held <= 0.99 * 200


def test_differences_say_what_is_not_known() -> None:
    """Where too many runs found nothing there is no difference; the same runs, the same values."""
    found = {(row.planner, row.what): row for row in differences(RUNS, OPTIMA)}
    success = found["RRT", "success"]
    assert success.value == pytest.approx(-0.25) and success.low is not None
    assert success.low <= -0.25 <= (success.high or 0.0)
    assert found["RRT", "cost / optimum"].supported
    assert list(found.values()) == list(differences(RUNS, OPTIMA))
    seldom = found["RRT", "first plan [s]"]  # of some samples of four, most found nothing
    assert seldom.low is not None and seldom.high == math.inf and not seldom.supported
    never = [RUNS[0], run("RRT", 0, None, None)]
    first = {row.what: row for row in differences(never, OPTIMA)}["first plan [s]"]
    assert (first.value, first.low, first.high, first.supported) == (None, None, None, False)


def test_curves_follow_the_runs() -> None:
    """Success rises at each first plan; quartiles count a run without a plan as infinite."""
    rrt = RUNS[1:]
    times, share = success_curve(rrt, 5.0)
    assert times == pytest.approx([0.0, 0.5, 0.6, 0.7, 5.0])
    assert share == [0.0, 0.25, 0.5, 0.75, 0.75]
    low, middle, high = cost_quantiles(rrt, np.array([0.4, 0.55, 5.0]))
    assert (low[0], middle[1], high[2]) == (None, None, None)
    assert low[1:] == [None, 13.0] and middle[2] == 14.0


def test_the_page_is_whole_and_escapes_names() -> None:
    """No name gets into the page as markup, and nothing is loaded from elsewhere."""
    page = report_html(RUNS, OPTIMA)
    assert EVIL not in page and "<img" not in re.sub(r"<script.*?</script>", "", page, flags=re.S)
    assert "&lt;img src=x onerror=alert(1)&gt;" in page
    assert not re.search(r"<(script|link)[^>]+(src|href)=", page)
    assert page.count("plotly.js v") >= 1 and page.count('class="plotly-graph-div"') == 3


def test_planner_names_are_text_in_charts() -> None:
    """A planner's name that looks like markup is shown as it is."""
    page = report_html([run("<b>bold</b>", 0, 1.0, 2.0)], {})
    assert "<b>bold</b>" not in page and "&lt;b&gt;bold" in page


def test_ompl_reads_the_log(tmp_path: Path) -> None:
    """OMPL's script makes its database of it: its tables, our columns, every run and step."""
    *logs, database = write_benchmark(RUNS, OPTIMA, tmp_path / "ompl")
    assert len(logs) == 1 and "<" not in logs[0].name
    connection = sqlite3.connect(database)
    rows = connection.execute(
        "SELECT p.name, r.status, r.solved, r.time_to_first_plan, r.regrasps, r.least_z, "
        "r.cost_ratio, r.seed FROM runs r JOIN plannerConfigs p ON p.id = r.plannerid ORDER BY r.id"
    ).fetchall()
    enums = dict(connection.execute("SELECT value, description FROM enums WHERE name='status'"))
    progress = connection.execute("SELECT count(*) FROM progress").fetchone()
    limit = connection.execute("SELECT timelimit, runcount FROM experiments").fetchone()
    connection.close()
    assert rows[0] == ("astar", 6, 1, 1.0, 1, 0.5, 1.0, 0)
    assert rows[-1] == ("RRT", 7, 0, None, None, None, None, 3)
    assert (enums[6], enums[7]) == ("Exact solution", "Crash")
    assert progress == (8,) and limit == (5.0, 4)


def test_the_status_numbers_are_ompls() -> None:
    """OMPL's own enumeration gives the places of the words."""
    code = (
        "from ompl import base as ob; S = ob.PlannerStatus; print(*(m.value for m in "
        "(S.UNKNOWN, S.TIMEOUT, S.EXACT_SOLUTION, S.CRASH, S.ABORT, S.INFEASIBLE)))"
    )
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True)
    numbers = [int(word) for word in done.stdout.split()]
    words = ("Unknown status", "Timeout", "Exact solution", "Crash", "Abort", "Infeasible problem")
    assert numbers == [STATUSES.index(word) for word in words], done.stderr


def test_the_command_compares_and_resumes(tmp_path: Path) -> None:
    """It writes everything it names; a second call makes no run and shows the same tables."""
    command = [
        sys.executable, "-P", "-m", "gm_ompl", "compare", "paper/slide", "--planners", "astar,RRT",
        "--seeds", "2", "--time-limit", "0.5", "-o", str(tmp_path / "out"),
    ]  # fmt: skip
    environment = {**os.environ, "COLUMNS": "120"}
    first = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert first.returncode == 0, first.stderr
    assert "RRT" in first.stdout and "95% interval" in first.stdout
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"runs.sqlite", "runs.parquet", "report.html", "ompl"} <= names
    again = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert again.stdout == first.stdout


@pytest.mark.parametrize(
    "wrong",
    [
        ["--planners", "nonsense"],
        ["--planners", "astar", "--executor", "cloud"],
        ["--planners", "astar", "--time-limit", str(math.nan)],
    ],
)
def test_wrong_options_are_named(
    wrong: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2, the value in the message, nothing written."""
    from gm_ompl.app.main import app

    with pytest.raises(SystemExit) as ended:
        app(["compare", "paper/slide", *wrong, "-o", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert wrong[-1] in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_page_has_its_marks(tmp_path: Path) -> None:
    """Tables go into docs/results/comparison.md; what stands between them is left alone."""
    found = marked(RUNS, {"k": 9.0})
    assert len(found["runs"].splitlines()) == 2 + 2 and "1.111" in found["runs"]  # 10 over 9
    assert len(found["differences"].splitlines()) == 2 + 1
    page = (Path(__file__).parents[2] / "docs" / "results" / "comparison.md").read_text()
    copy = tmp_path / "page.md"
    copy.write_text(page)
    write_tables(copy, found)
    words = re.compile(r"(<!-- begin (\w+) -->\n).*?(<!-- end \2 -->)", re.DOTALL)
    assert words.sub(r"\1\3", copy.read_text()) == words.sub(r"\1\3", page)


DESIGN = Comparison(
    single=("paper/slide",), families=("random/small",), planners=("astar", "RRT"), seeds=3
)


def test_the_pages_runs_are_each_planner_s_on_every_scenario() -> None:
    """astar once per scenario; a family's k-th scenario with seed k; a longer astar on each."""
    tasks = runs(DESIGN)
    names = [(task.scenario_name, task.planner, task.seed) for task in tasks]
    family = [(f"random/small/{k}", name, k) for k in range(3) for name in ("astar", "RRT")]
    slide = [("paper/slide", "astar", 0), *(("paper/slide", "RRT", k) for k in range(3))]
    assert sorted(names) == sorted([*slide, *family])
    longer = references(DESIGN, tasks)
    assert {task.scenario_name for task in longer} == {name for name, _, _ in names}
    assert {(task.planner, task.limits.time_s) for task in longer} == {("astar", 120.0)}
    assert not {task.key() for task in longer} & {task.key() for task in tasks}


def test_a_family_is_compared_scenario_by_scenario() -> None:
    """Paired samples are drawn in pairs: a constant difference has no spread."""
    records = [
        run(planner, 0, 1.0, cost, scenario=f"random/tumble/{k}", scenario_key=str(k))
        for k in range(6)
        for planner, cost in (("astar", 10.0 * k + 1.0), ("RRT", 20.0 * k + 2.0))
    ]
    best = {str(k): 10.0 * k + 1.0 for k in range(6)}
    astar, rrt = summarise(records, best)
    assert (astar.scenario, rrt.scenario, rrt.runs, rrt.ratio) == (*["random/tumble"] * 2, 6, 2.0)
    rows = {row.what: row for row in differences(records, best)}
    assert (rows["cost / optimum"].low, rows["cost / optimum"].high) == (1.0, 1.0)
    times = [(np.array([k + 1.5]), np.array([float(k)])) for k in range(9)]
    ends = paired_difference(times, lambda x: np.asarray(x.mean(axis=-1)))
    assert ends == pytest.approx((1.5, 1.5, 1.5))
    assert paired_difference([], lambda x: x) == (None, None, None)


def test_parquet_holds_every_run(tmp_path: Path) -> None:
    """Read back, it has the records' columns and values, nothing rounded."""
    import pyarrow.parquet

    write_parquet(RUNS, tmp_path / "runs.parquet")
    rows = pyarrow.parquet.read_table(tmp_path / "runs.parquet").to_pylist()
    assert len(rows) == len(RUNS)
    for row, record in zip(rows, RUNS, strict=True):
        history = [(h["time_s"], h["cost"], h["lower_bound"]) for h in row.pop("history")]
        assert tuple(history) == record.history
        assert json.loads(row.pop("parameters")) == record.parameters
        assert row == {name: getattr(record, name) for name in row}
    # No run, or runs without plans, have the same columns and types.
    write_parquet(RUNS[-1:], tmp_path / "one.parquet")
    schemas = [pyarrow.parquet.read_schema(tmp_path / name) for name in ("runs.parquet",
                                                                        "one.parquet")]  # fmt: skip
    assert schemas[0].equals(schemas[1])


def test_without_pyarrow_one_is_told_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The message names the extra."""
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match=r"gm-ompl\[parquet\]"):
        write_parquet(RUNS, tmp_path / "runs.parquet")


def test_scaling_is_drawn_where_sizes_differ() -> None:
    """Two charts more, over the states of the lattice."""
    records = [run("RRT", k, 1.0, 2.0, states=10.0**k, first_plan_decisions=k) for k in (1, 2)]
    page = report_html(records, {})
    assert page.count('class="plotly-graph-div"') == 5 and "states of the lattice" in page
