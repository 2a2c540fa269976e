"""``python -m docs.tables.engines_apart``: pulses on which the two simulators do not agree.

Puts weaker and stronger pulses where ``python -m tests.verify engines_under_pulses`` found that
MuJoCo and DART disagree, and writes the table of docs/results/execution.md.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from gm_ompl.study.report import table
from tests.verify.count_engines import PULSES, pulse_of

from .pages import write_tables

COUNTED: Final = Path("build/verify/engines_under_pulses.jsonl")
PAGE: Final = Path("docs/results/execution.md")
SHARES: Final = (0.7, 0.85, 1.0, 1.2, 1.45)
HEAD: Final = ("pulse", *(f"{engine}, {share:g}" for engine in ("MuJoCo", "DART")
                          for share in SHARES))  # fmt: skip


def apart() -> list[int]:
    """Return the pulses, by their numbers, of the last count."""
    lines = COUNTED.read_text(encoding="utf-8").splitlines()
    rows = {row["instance"]: row for row in map(json.loads, lines)}
    return sorted(number for number, row in rows.items() if not row["holds"] and number < PULSES)


def rows() -> Iterator[tuple[str, ...]]:
    """Yield per pulse how far the object was off afterwards [% of D]; * where it was lost."""
    for number in apart():
        name, instant, direction, fraction, disturbers = pulse_of(number)
        trials = [one.trial(instant, direction, -1, share * fraction)
                  for one in disturbers for share in SHARES]  # fmt: skip
        told = [f"{100.0 * t.offset:.2g}{'' if t.withstood else ' *'}" for t in trials]
        yield (f"{name}, {fraction:.2f} z", *told)


def main() -> None:
    """Write the table."""
    write_tables(PAGE, {"apart": table(HEAD, list(rows()))})


if __name__ == "__main__":
    main()
