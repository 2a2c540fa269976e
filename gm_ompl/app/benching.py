"""``gm-ompl bench``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gm_ompl.app.exits import Exit
from gm_ompl.app.options import require_positive
from gm_ompl.app.output import note, say, say_json
from gm_ompl.app.verbs import BenchVerb
from gm_ompl.study.bench import SCENARIOS, bench
from gm_ompl.study.report import number, table


def bench_command(request: BenchVerb) -> Exit:
    """Measure, show the result."""
    require_positive(repeat=request.repeat, highs=request.highs, search_limit=request.search_limit)
    found = bench(
        request.scenario or SCENARIOS, request.overrides or (), note, repeat=request.repeat,
        highs=request.highs, search_limit=request.search_limit,
    )  # fmt: skip
    if request.as_json:
        say_json(found)
    else:
        for line in lines(found):
            say(line)
    return Exit.OK


def lines(found: dict[str, Any]) -> Iterator[str]:
    """Yield what was measured for people: Markdown."""
    yield "Mode decisions of the whole hand, memo off; HiGHS as needed, and as Sec. 3.4 reads."
    yield ""
    yield _decisions(found["decisions"])
    yield "Plans: A*, and the plain search: its decisions, counted, times HiGHS's measured mean."
    yield ""
    yield _plans(found["plans"])
    yield "Where A*'s time goes; peak memory of its process."
    yield ""
    yield _shares(found["plans"])
    start, machine = found["start"], found["machine"]
    yield (
        f"Start: --help {start['help_s']:.2f} s; first plan of {start['scenario']} in a new "
        f"process {start['first_plan_s']:.2f} s."
    )
    yield (
        f"Python {machine['python']}, {machine['cores']} cores, load {machine['load']:.1f}, "
        f"{machine['platform']}."
    )


def _decisions(rows: list[dict[str, Any]]) -> str:
    head = (
        "scenario", "search", "asked", "kernel median ms", "95 % ms", "both-force median ms",
        "HiGHS median ms", "as it reads", "ratio", "as it reads",
    )  # fmt: skip
    keys = (
        "asked", "kernel_median_ms", "kernel_p95_ms", "both_force_median_ms", "highs_median_ms",
        "highs_whole_median_ms", "ratio", "ratio_whole",
    )  # fmt: skip
    return table(
        head, [(r["scenario"], r["search"], *(number(r[key]) for key in keys)) for r in rows]
    )


def _plans(rows: list[dict[str, Any]]) -> str:
    head = ("scenario", "A* s", "decisions", "plain decisions", "plain s", "ratio")
    return table(head, [
        (
            row["scenario"], number(row["seconds"]), number(row["mode_decisions"]),
            *(_at_least(row[key], row) for key in ("plain_decisions", "plain_s", "ratio")),
        )
        for row in rows
    ])  # fmt: skip


def _shares(rows: list[dict[str, Any]]) -> str:
    head = ("scenario", "geometry", "decisions", "search", "other", "MiB")
    return table(head, [
        (
            row["scenario"], *(f"{100 * share:.0f} %" for share in row["profile"].values()),
            number(row["peak_mb"]),
        )
        for row in rows
    ])  # fmt: skip


def _at_least(value: float | None, row: dict[str, Any]) -> str:
    """Return a number, marked where the counting search was stopped before its end."""
    return number(value) if row["plain_is_whole"] or value is None else f">= {number(value)}"
