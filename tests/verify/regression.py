"""Holds shipped scenarios of known optimum to their ``expect`` and to the last release.

``python -m tests.verify.regression`` says what moved and ends with 5 if something is worse;
``--record`` writes the baseline anew. Times are compared as multiples of a piece of work that no
change of this package touches, measured in the same call, so that another machine does not matter.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from gm_ompl import api
from gm_ompl.errors import InputError
from gm_ompl.limits import MEGABYTE, resident_memory
from gm_ompl.planfile.model import Plan
from gm_ompl.reading import Kind, read_text
from gm_ompl.writing import write_text
from tests.executed import PROVEN
from tests.verify.expectations import COST, disagreements

BASELINE = Path(__file__).with_name("regression_baseline.json")

KIND = Kind("baseline", "JSON", 2**20, hint=lambda _: "; --record makes one")

SLOWER, LARGER = 1.5, 1.25
"""Factors on time and memory up to which a scenario counts as unchanged: the same search differs by
a third or so from one call to the next on a machine that does other things."""

NOTICEABLE_S = 0.05
"""Differences below this time are noise, whatever their factor."""

TIME_LIMIT = 120.0
"""A scenario that takes longer is compared by what it found until then [s]."""


@dataclass(frozen=True)
class Figures:
    """What a scenario's plan by ``astar`` is and takes.

    Attributes:
        status: how the search ended.
        cost: of the plan, or None.
        regrasps: in the plan, or None.
        time_ratio: CPU time over that of the unit of work.
        memory_mb: resident memory after it [MiB]; earlier scenarios' is in it.
    """

    status: str
    cost: float | None
    regrasps: int | None
    time_ratio: float
    memory_mb: float


def unit_of_work() -> float:
    """Return the CPU time of numeric work in small arrays and plain Python, median of five [s]."""
    rng = np.random.default_rng(0)
    matrix = rng.normal(size=(24, 24))
    times = []
    for _ in range(5):
        started = time.process_time()
        total = 0.0
        for k in range(2000):
            matrix[k % 24] *= -1.0
            total += float(np.linalg.solve(matrix, matrix[0])[0])
            total += sum(x * 0.5 for x in range(200))
        times.append(time.process_time() - started)
    return statistics.median(times)


def measured(name: str, unit: float) -> tuple[Plan, Figures]:
    """Plan a shipped scenario; the second of two searches counts, compiled code being loaded."""
    scenario = api.load(name)
    for _ in range(2):
        started = time.process_time()
        plan = api.plan(scenario, time_limit=TIME_LIMIT)
        seconds = time.process_time() - started
    memory = resident_memory() / MEGABYTE
    return plan, Figures(plan.status, plan.cost, plan.regrasps, seconds / unit, memory)


def worse(now: Figures, then: Figures, unit: float) -> Iterator[str]:
    """Yield a sentence for everything in which a scenario is worse than before.

    Args:
        now: as measured.
        then: of the baseline.
        unit: CPU time of the unit of work [s].
    """
    if now.status != then.status:
        yield f"status is {now.status}, was {then.status}"
    if now.cost is not None and then.cost is not None and now.cost > then.cost * (1.0 + COST):
        yield f"cost is {now.cost:.9g}, was {then.cost:.9g}"
    if (
        now.time_ratio > SLOWER * then.time_ratio
        and (now.time_ratio - then.time_ratio) * unit > NOTICEABLE_S
    ):
        yield f"takes {now.time_ratio / then.time_ratio:.2f} times as long"
    if now.memory_mb > LARGER * then.memory_mb:
        yield f"memory is {now.memory_mb:.0f} MiB, was {then.memory_mb:.0f}"


def moved(now: Figures, then: Figures) -> str:
    """Return in words how a scenario's figures differ from the baseline's."""
    cost = "-" if now.cost is None else f"{now.cost:.7g}"
    if now.cost is not None and then.cost is not None:
        cost += f" ({(now.cost / then.cost - 1.0):+.1e})"
    return (
        f"{now.status}, cost {cost}, {now.regrasps} regrasps, time x{now.time_ratio:.1f}"
        f" (was x{then.time_ratio:.1f}), {now.memory_mb:.0f} MiB (was {then.memory_mb:.0f})"
    )


def read_baseline(path: Path) -> dict[str, Figures]:
    """Return the recorded figures by scenario.

    Raises:
        InputError: the file is missing or is none.
    """
    try:
        tree: Mapping[str, Mapping[str, object]] = json.loads(read_text(path, KIND))
        return {name: Figures(**row) for name, row in tree.items()}  # type: ignore[arg-type]
    except (ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: no baseline: {error}; --record makes one") from None


def main(arguments: Sequence[str] | None = None) -> int:
    """Hold the scenarios to their baseline; return the exit code: 0, or 5 where one is worse."""
    parser = argparse.ArgumentParser(description="Hold scenarios to what the last release did.")
    parser.add_argument("scenarios", nargs="*", default=list(PROVEN), help="default: all")
    parser.add_argument("--baseline", type=Path, default=BASELINE)
    parser.add_argument("--record", action="store_true", help="write the baseline anew")
    given = parser.parse_args(arguments)
    try:
        before = {} if given.record else read_baseline(given.baseline)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    unit, found, bad = unit_of_work(), {}, 0
    for name in given.scenarios:
        plan, found[name] = measured(name, unit)
        wrong = list(disagreements(plan, api.load(name).model.expect))
        then = before.get(name)
        wrong += worse(found[name], then, unit) if then is not None else ()
        sys.stdout.write(f"{name}: {moved(found[name], then or found[name])}\n")
        sys.stdout.write("".join(f"  WORSE: {sentence}\n" for sentence in wrong))
        bad += bool(wrong)
    if given.record:
        rows = {name: asdict(figures) for name, figures in found.items()}
        write_text(given.baseline, json.dumps(rows, indent=2) + "\n")
    return 5 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
