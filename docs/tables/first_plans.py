"""``python -m docs.tables.first_plans``: medians of the counts of first plans and of best ones.

It reads what ``python -m tests.verify`` has recorded of the counts that it names, whatever part of
their instances is done.
"""

from __future__ import annotations

import json
import re
import statistics
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from docs.tables.pages import growing, write_page
from gm_ompl.study.report import number
from tests.verify.__main__ import RESULTS
from tests.verify.count_free_sampling import OPTIMA, SCENARIOS
from tests.verify.count_ompl import FREE, PLANNERS

SCRIPTS = ("paper/tumble", "paper/regrasp", *FREE)

HEAD_SCRIPTS = ("scenario", "planner", "solved", "CPU s, median", "worst", "cost ratio, median")
HEAD_FIRST = ("scenario", "HybridRRTConnect", "CPU s, median", "worst",
              "HybridRRT", "CPU s, median", "worst")  # fmt: skip
HEAD_BEST = ("scenario", "with no more regrasps", "cost / least on the lattice, median", "worst")


def records(name: str) -> list[dict[str, Any]]:
    """Return the records of a count on the latest sources; none where it was never begun."""
    path = RESULTS / f"{name}.jsonl"
    lines = path.read_text().splitlines() if path.exists() else []
    known = [json.loads(line) for line in lines]
    return [record for record in known if record["code"] == known[-1]["code"]]


def counted(scenario: str) -> str:
    """Return a scenario's name as it stands in those of counts."""
    return scenario.split("/")[1].replace("-", "_")


def middle(values: Iterable[float | None]) -> str:
    """Return the median of the values that are there, as it is written."""
    known = [value for value in values if value is not None]
    return number(statistics.median(known)) if known else "-"


def script_rows() -> Iterator[Sequence[object]]:
    """Yield the rows of OMPL's planners."""
    for scenario in SCRIPTS:
        for planner in PLANNERS:
            done = records(f"script_{counted(scenario)}_{planner}")
            if done:
                ratios = (re.match(r"([\d.e+]+) times", record["note"]) for record in done)
                yield (
                    scenario, planner, *_solved(done),
                    middle(float(found[1]) for found in ratios if found),
                )  # fmt: skip


def first_rows() -> Iterator[Sequence[object]]:
    """Yield the rows of the project's own planners."""
    for scenario in SCENARIOS:
        own = [
            records(f"free_first_{counted(scenario)}_{planner}")
            for planner in ("HybridRRTConnect", "HybridRRT")
        ]
        if all(own):
            yield scenario, *_solved(own[0]), *_solved(own[1])


def best_rows() -> Iterator[Sequence[object]]:
    """Yield the rows of plans improved for so long."""
    for scenario in OPTIMA:
        done = records(f"free_best_{counted(scenario)}")
        if done:
            ratios = [record["worst"] for record in done]
            holds = sum(record["holds"] for record in done)
            yield scenario, f"{holds} of {len(done)}", middle(ratios), number(max(ratios))


def _solved(done: Sequence[dict[str, Any]]) -> tuple[str, str, str]:
    """Return how many of some instances hold, and the median and the longest time."""
    seconds = [record["worst"] for record in done]
    holds = sum(record["holds"] for record in done)
    return f"{holds} of {len(done)}", middle(seconds), number(max(seconds))


def main() -> None:
    """Write the tables into the page."""
    write_page(
        "ompl",
        {
            "scripts": growing(HEAD_SCRIPTS, script_rows()),
            "first": growing(HEAD_FIRST, first_rows()),
            "best": growing(HEAD_BEST, best_rows()),
        },
    )


if __name__ == "__main__":
    main()
