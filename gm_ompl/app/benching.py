"""``gm-ompl bench``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
    """Yield what was measured for people: Markdown, each column as ``bench`` calls it."""
    yield "Mode decisions of the whole hand, memo off; whole: in HiGHS as Sec. 3.4 reads."
    yield _table(found["decisions"])
    yield "Plans: A*, and the plain search: its decisions, counted, times HiGHS's measured mean."
    yield _table([{k: v for k, v in row.items() if k != "profile"} for row in found["plans"]])
    yield "Shares of A*'s time."
    yield _table([{"scenario": row["scenario"], **row["profile"]} for row in found["plans"]])
    yield ", ".join(f"{k} {v:.2f}" for k, v in found["start"].items() if k != "scenario")
    yield ", ".join(f"{k} {v}" for k, v in found["machine"].items())


def _table(rows: Sequence[dict[str, Any]]) -> str:
    def shown(value: Any) -> str:
        plain = isinstance(value, str | bool)
        return str(value) if plain else number(value)

    return "\n" + table(list(rows[0]), [[shown(value) for value in row.values()] for row in rows])
