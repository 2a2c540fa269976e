from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gm_ompl.viz.animation import animate
from gm_ompl.viz.canvas import styled
from gm_ompl.viz.search import search_figure
from typer.testing import CliRunner

from gm_ompl.app.main import app
from gm_ompl.errors import InputError
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.planner import Progress, silent
from gm_ompl.planners.trace import Expansion, Vertex, tracer
from gm_ompl.planners.trace_file import Told, TraceFile, read_trace

SMALL = ["--set", "lattice.segments=3", "--set", "fingers.placements.grid=[2, 2]"]
HEADER = {"scenario": "s", "planner": "astar", "seed": 0, "coordinates": ["s"]}


def test_plan_writes_what_the_search_told(tmp_path: Path) -> None:
    """``plan --trace`` keeps the progress and how it ended, ``--html`` the page."""
    trace, html = tmp_path / "trace", tmp_path / "view.html"
    options = [*SMALL, "--trace", str(trace), "--html", str(html)]
    result = CliRunner().invoke(app, ["plan", "paper/slide", *options])
    assert result.exit_code == 0, result.output
    records = [json.loads(line) for line in trace.read_text().splitlines()]
    assert records[0]["format"] == "gm-ompl-trace/1"
    assert (records[-1]["event"], records[-1]["status"]) == ("end", "solved")
    assert {record["event"] for record in records[1:]} >= {"progress", "end"}
    assert "<title>paper/slide</title>" in html.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "arguments",
    [
        ["paper/slide", "--planner", "astra", "--trace", "t"],
        ["paper/slide", "--time-limit", "nan", "--trace", "t"],
        ["paper/slide", "--trace", "same", "--html", "same"],
        ["paper/slide", "--trace", "no-such-folder/t"],
    ],
)
def test_bad_input_leaves_no_trace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    """A search that never starts writes nothing."""
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(app, ["plan", *arguments]).exit_code == 2
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def traced(tmp_path: Path) -> Path:
    """A trace with events of every kind."""
    path = tmp_path / "trace"
    with TraceFile(path, HEADER, silent) as report:
        trace = tracer(report)
        assert trace is not None
        report(Progress(0.1, 1, 2, 3, None, 5.0))
        report(Progress(0.2, 4, 2, 3, 9.0, float("inf")))
        trace(Expansion((0.0,), (1, 2), 0.0, 5.0, "renewed"))
        trace(Expansion((0.5,), (1, 2), 1.0, 6.0, "judged"))
        trace(Expansion((0.25,), (-1, 2), 1.0, 6.5, "judged"))
        trace(Vertex(0, None, (0.0,), (), "root"))
        trace(Vertex(1, 0, (0.5,), (), "displacement"))
        trace(Vertex(2, 1, (0.5,), (), "regrasp"))
        trace(Vertex(2, 0, (0.5,), (), "displacement"))
    return path


def test_a_trace_reads_back(traced: Path) -> None:
    """Events come back in order; a vertex said again hangs on its new parent."""
    trace = read_trace(traced)
    assert trace.history == ((0.1, None, 5.0), (0.2, 9.0, None))
    assert [row["why"] for row in trace.expansions] == ["renewed", "judged", "judged"]
    assert trace.vertices is not None
    assert [row["parent"] for row in trace.vertices.values()] == [None, 0, 0]


def test_the_figure_draws_what_was_told(traced: Path, slide: Plan) -> None:
    """One panel each: bound and cost, expansions by reason, the tree's edges."""
    with styled():
        figure = search_figure(animate(slide), read_trace(traced))
    bounds, expanded, _ = figure.axes if len(figure.axes) == 3 else (*figure.axes, None)
    assert {line.get_label() for line in bounds.lines} == {"best cost", "lower bound"}
    drawn = {c.get_label(): len(c.get_offsets()) for c in expanded.collections}
    assert (drawn["renewed"], drawn["judged"]) == (1, 2)
    edges = [segment for c in figure.axes[-1].collections for segment in _segments(c)]
    assert sorted(np.array(e)[1, 0] for e in edges) == [0.5, 0.5]


def test_a_tree_is_drawn_over_sets_of_placements(slide: Plan) -> None:
    """One row per set: displacements run along it, a regrasp across; equal fingers are one."""
    rows = {
        0: _row(0.0, (1, 2), None, "root"),
        1: _row(0.5, (1, 2), 0, "displacement"),
        2: _row(0.5, (1, 3), 1, "regrasp"),
        3: _row(1.0, (3, 1), None, "root") | {"tree": "goal"},
    }
    with styled():
        figure = search_figure(animate(slide), Told({}, (), (), rows))
    edges = {c.get_label(): np.array(_segments(c)) for c in figure.axes[-1].collections}
    assert edges["displacement"].tolist() == [[[0.0, 0.0], [0.5, 0.0]]]
    assert edges["regrasp"].tolist() == [[[0.5, 0.0], [0.5, 1.0]]]
    points = next(c for c in figure.axes[-1].collections if len(c.get_offsets()) == 4)
    assert points.get_offsets()[3].tolist() == [1.0, 1.0]
    figure.canvas.draw()
    legend = figure.axes[-1].get_legend().get_window_extent()
    assert figure.bbox.x0 <= legend.x0
    assert legend.x1 <= figure.bbox.x1
    assert figure.axes[-1].bbox.width > 0.6 * figure.bbox.width


def _row(s: float, placements: tuple[int, ...], parent: int | None, kind: str) -> dict[str, Any]:
    where = {"q": (s,), "placements": placements}
    return {**where, "parent": parent, "kind": kind, "tree": "start"}


def _segments(collection: Any) -> list[Any]:
    return list(collection.get_segments()) if hasattr(collection, "get_segments") else []


def test_a_plan_alone_shows_bound_and_cost(regrasp: Plan) -> None:
    """Without a trace the history in the plan is drawn; it ends at the optimum."""
    with styled():
        figure = search_figure(animate(regrasp), None)
    bound = next(line for line in figure.axes[0].lines if line.get_label() == "lower bound")
    assert bound.get_ydata()[-1] == pytest.approx(regrasp.cost)
    assert (np.diff(bound.get_ydata()) >= 0).all()


def test_a_long_trace_is_thinned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond a number expansions are kept ever more rarely; the end tells how many there were."""
    monkeypatch.setattr("gm_ompl.planners.trace_file.WHOLE", 100)
    path = tmp_path / "trace"
    with TraceFile(path, HEADER, silent) as report:
        for k in range(10_000):
            report.trace(Expansion((0.0,), (), 0.0, float(k), "judged"))
    kept = len(read_trace(path).expansions)
    assert 100 <= kept < 1000


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not a trace"),
        ('{"format": "other"}\n', "gm-ompl-trace/1"),
        ("nonsense\n{}\n", ":1:"),
        ('{"format": "gm-ompl-trace/1"}\n[1]\n{}\n', ":2:"),
        ('{"format": "gm-ompl-trace/1"}\n{"event": "vertex", "number": 1}\n', "'q'"),
    ],
)
def test_what_is_no_trace_is_refused(tmp_path: Path, text: str, message: str) -> None:
    """A wrong file is bad input; the message says what is missing."""
    path = tmp_path / "trace"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_trace(path)


def test_a_trace_cut_short_is_read(traced: Path) -> None:
    """A last line that an interruption cut off is left out."""
    traced.write_text(traced.read_text() + '{"event": "vert')
    assert len(read_trace(traced).expansions) == 3
