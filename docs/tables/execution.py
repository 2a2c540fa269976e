"""``python -m docs.tables.execution [--engines mujoco dart] [NAME ...]``: are plans executed?

Executes the optimal plans of ``tests.executed`` and writes the tables of docs/results/execution.md.
What was executed is kept in build/execution.jsonl; a second call does what is missing.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

from gm_ompl.planfile.fit import problem_of
from gm_ompl.simulation.engine import ENGINES, EngineName
from gm_ompl.simulation.execute import execute, prepare
from gm_ompl.simulation.happened import first_beyond
from gm_ompl.simulation.world import force_unit
from gm_ompl.study.report import table
from tests.executed import NAMES, plan_of

from .pages import write_tables

KEPT = Path("build/execution.jsonl")
PAGE = Path("docs/results/execution.md")
HELD = ("plans", "executed", "MuJoCo", "DART", "by both", "they agree")
LOST = ("plan", "least z / weight", "fails in", "first beyond a limit", "z / weight there",
        "forces / weight, and what happened")  # fmt: skip
WRITTEN = {"mujoco": "MuJoCo", "dart": "DART"}

Record = dict[str, Any]


def executed(name: str, engine: EngineName) -> Record:
    """Execute one plan; forces over the object's weight, lengths over D."""
    plan = plan_of(name)
    setup = prepare(plan, engine=engine)
    report, weight = execute(setup), force_unit(problem_of(plan))
    record: Record = {"name": name, "engine": engine, "holds": report.holds,
                      "z": (plan.least_z or 0.0) / weight, "notes": report.notes}  # fmt: skip
    first = None if report.holds else first_beyond(report.segments)
    if first is not None:
        parts = [
            f"{part.finger}: {part.asked / weight:.2f} asked, {part.came / weight:.2f} came"
            for part in first.fingers
        ]
        record |= {
            "where": f"step {first.step}, segment {first.segment}",
            "beyond": ", ".join(first.beyond) or report.findings[0],
            "promised": f"{first.z / weight:.2f}",
            "happened": f"fingers {'; '.join(parts)}; contacts opened "
            f"{100 * first.opened / report.size:.1f} % of D, static ones moved "
            f"{100 * first.static_slip / report.size:.1f} % of D",
        }
    return record


def records() -> dict[tuple[str, str], Record]:
    """Return what is kept, by name and engine."""
    lines = KEPT.read_text().splitlines() if KEPT.exists() else []
    return {(row["name"], row["engine"]): row for row in map(json.loads, lines)}


def groups(known: dict[tuple[str, str], Record]) -> Iterator[tuple[object, ...]]:
    """Yield a row per group of plans."""
    names = {
        "shipped" if not name.startswith("random") else name.rpartition("/")[0] for name in NAMES
    }
    for group in sorted(names, key=lambda one: (one != "shipped", one)):
        of = [name for name in NAMES if name.startswith(group) or
              (group == "shipped" and not name.startswith("random"))]  # fmt: skip
        rows = {engine: {n: known[n, engine]["holds"] for n in of if (n, engine) in known}
                for engine in ENGINES}  # fmt: skip
        both = [name for name in rows["mujoco"] if name in rows["dart"]]
        agree = sum(rows["mujoco"][name] == rows["dart"][name] for name in both)
        told = [f"{sum(held.values())} of {len(held)}" for held in rows.values()]
        yield (group, len(of), *told, len(both), f"{agree} of {len(both)}")


def failures(known: dict[tuple[str, str], Record]) -> Iterator[tuple[object, ...]]:
    """Yield a row per plan that fails."""
    for name in NAMES:
        rows = [known[name, engine] for engine in ENGINES if (name, engine) in known]
        lost = [row for row in rows if not row["holds"]]
        if lost:
            row = lost[0]
            where = " and ".join(WRITTEN[one["engine"]] for one in lost)
            happened = "; ".join([row["happened"], *row["notes"]])
            beyond = f"{row['where']}: {row['beyond']}"
            yield (name, f"{row['z']:.2f}", where, beyond, row["promised"], happened)


def main() -> None:
    """Execute what is missing and write the page, plan by plan."""
    parser = argparse.ArgumentParser(prog="python -m docs.tables.execution", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", default=NAMES)
    parser.add_argument("--engines", nargs="+", choices=ENGINES, default=ENGINES)
    options = parser.parse_args()
    known = records()
    for name in options.names:
        for engine in options.engines:
            if (name, engine) not in known:
                known[name, engine] = record = executed(name, cast(EngineName, engine))
                KEPT.parent.mkdir(exist_ok=True)
                with KEPT.open("a") as file:
                    file.write(json.dumps(record) + "\n")
            tables = {"runs": table(HELD, list(groups(known))),
                      "failures": table(LOST, list(failures(known)))}  # fmt: skip
            write_tables(PAGE, tables)


if __name__ == "__main__":
    main()
