"""Holds the working tree's speed and plans to those of an earlier commit.

``python -m tests.side_by_side --old HASH`` builds that commit and the working tree, lets runs of
the two alternate and prints a table; it ends with 5 where something is slower. ``--record`` has
the old build plan what ``tests/data/before.json`` lacks; ``--compare`` holds the working tree's
plans to that file and needs no old build.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from gm_ompl.scenario.load import shipped
from tests.side_by_side.before import BEFORE, Before, Outcome, asked, compare, outcome, record
from tests.side_by_side.builds import Build, of_commit, of_working_tree, scenarios_of
from tests.side_by_side.measure import Ask, answers, asking, requests, starts, table


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="tests.side_by_side", description=__doc__)
    parser.add_argument("--old", help="the commit to compare with")
    parser.add_argument("--runs", type=int, default=5, help="repetitions of everything")
    parser.add_argument("--first-uses", type=int, default=1, help="with an empty cache; 0: none")
    parser.add_argument("--only", default="", help="what begins so: 'later start', random/small")
    parser.add_argument("--cpu", action="store_true", help="CPU time of solves and decisions")
    parser.add_argument("--record", action="store_true", help="record the old build's plans")
    parser.add_argument("--compare", action="store_true", help="hold plans to the record")
    parser.add_argument("--seconds", type=float, default=600.0, help="to spend on recording")
    parser.add_argument("--limit", type=float, default=10.0, help="of each recorded search [s]")
    given = parser.parse_args(arguments)
    if given.old is None and not given.compare:
        parser.error("--old HASH: say which commit to compare with")
    return given


def _planned(ask: Ask, limit: float, key: tuple[str, str, int]) -> Outcome:
    scenario, planner, seed = key
    request = {"scenario": scenario, "planner": planner, "seed": seed, "time_limit": limit}
    return outcome(ask(task="plan", **request))


def _record(old: Build, limit: float, seconds: float) -> int:
    before = Before.read(BEFORE) if BEFORE.exists() else Before(old.name, limit, {})
    if (before.commit, before.limit) != (old.name, limit):
        sys.stderr.write(f"{BEFORE}: of {before.commit} under {before.limit} s; remove it first\n")
        return 2
    with asking(old) as ask:
        ask(task="warm")
        missing = record(
            before,
            asked([name for name in shipped() if name in scenarios_of(old.name)]),
            lambda *key: _planned(ask, limit, key),
            seconds,
            BEFORE,
        )
    sys.stdout.write(f"{len(before.runs)} runs recorded, {missing} missing\n")
    return 0


def _compare(only: str) -> int:
    before = Before.read(BEFORE)
    before.runs = {key: run for key, run in before.runs.items() if key[0].startswith(only)}
    with asking(of_working_tree()) as ask:
        ask(task="warm")
        differing = compare(before, lambda *key: _planned(ask, before.limit, key), sys.stdout.write)
    return 5 if differing else 0


def _measure(given: argparse.Namespace) -> int:
    old, new, runs = of_commit(given.old), of_working_tree(), given.runs
    first_uses = given.first_uses if "first use".startswith(given.only) else 0
    rows = list(starts(old, new, runs if "later start".startswith(given.only) else 0, first_uses))
    clock = "cpu_s" if given.cpu else "wall_s"
    if any(name.startswith(given.only) for name, _, _ in requests(clock)):
        with asking(old) as ask_old, asking(new) as ask_new:
            for ask in (ask_old, ask_new):
                ask(task="warm")
            rows += answers(ask_old, ask_new, runs, clock, given.only)
    sys.stdout.write(table(rows))
    return 5 if any(row.slower for row in rows) else 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked for; return the exit code."""
    given = _options(arguments)
    if given.compare:
        return _compare(given.only)
    if given.record:
        return _record(of_commit(given.old), given.limit, given.seconds)
    return _measure(given)


if __name__ == "__main__":
    sys.exit(main())
