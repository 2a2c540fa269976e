"""Plans that an earlier commit made, kept in ``tests/data/before.json``, and those of today."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from tests.side_by_side.builds import ROOT

BEFORE: Final = ROOT / "tests" / "data" / "before.json"
COST: Final = 1e-9
"""Relative difference up to which costs are the same."""

FAMILIES: Final = ("small", "slide", "push", "tumble", "regrasp", "chain", "planar")
SEEDS: Final = 100


@dataclass(frozen=True)
class Outcome:
    """What came of a search.

    Attributes:
        status: how it ended.
        cost: of the plan, or None.
        bound: from below on every plan's cost; None is infinity.
        optimal: whether the plan is proven optimal.
        regrasps: in the plan, or None.
    """

    status: str
    cost: float | None
    bound: float | None
    optimal: bool
    regrasps: int | None

    @property
    def final(self) -> bool:
        """Whether a search without limits would have ended the same."""
        return self.optimal or self.status == "infeasible"


Key = tuple[str, str, int]
"""Scenario, planner, seed."""

Planned = Callable[[str, str, int], Outcome]


def asked(shipped: list[str]) -> Iterator[Key]:
    """Yield what is recorded: shipped scenarios, then the families' seeds in turn."""
    yield from ((name, "astar", 0) for name in shipped)
    for seed in range(SEEDS):
        yield f"random/small/{seed}", "dijkstra", 0
        yield from ((f"random/{family}/{seed}", "astar", 0) for family in FAMILIES)


@dataclass
class Before:
    """The record.

    Attributes:
        commit: whose build was asked.
        limit: of each search [s].
        runs: the outcomes.
    """

    commit: str
    limit: float
    runs: dict[Key, Outcome]

    @classmethod
    def read(cls, path: Path) -> Before:
        """Return what a file holds."""
        tree = json.loads(path.read_text())
        runs = {_key(name): Outcome(**row) for name, row in tree["runs"].items()}
        return cls(tree["commit"], tree["time_limit_s"], runs)

    def write(self, path: Path) -> None:
        """Write the record, a line per run."""
        rows = [
            f"    {json.dumps(' '.join(map(str, key)))}: {json.dumps(asdict(run))}"
            for key, run in self.runs.items()
        ]
        head = f'  "commit": "{self.commit}",\n  "time_limit_s": {self.limit},\n  "runs": '
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{\n" + head + "{\n" + ",\n".join(rows) + "\n  }\n}\n")


def _key(name: str) -> Key:
    scenario, planner, seed = name.split()
    return scenario, planner, int(seed)


def outcome(answer: Mapping[str, Any]) -> Outcome:
    """Return the outcome in a work process's answer."""
    bound = answer["bound"]
    finite = bound if bound is not None and math.isfinite(bound) else None
    return Outcome(answer["status"], answer["cost"], finite, answer["optimal"], answer["regrasps"])


def record(before: Before, wanted: Iterator[Key], plan: Planned, seconds: float, to: Path) -> int:
    """Plan what has no outcome yet until ``seconds`` are over; return how many are missing."""
    ends, missing = time.monotonic() + seconds, 0
    for key in wanted:
        if key in before.runs:
            continue
        if time.monotonic() > ends:
            missing += 1
            continue
        before.runs[key] = plan(*key)
        before.write(to)
    before.write(to)
    return missing


def differences(then: Outcome, now: Outcome) -> Iterator[str]:
    """Yield a sentence for everything in which a plan contradicts the recorded one.

    Where a search met its limit, only what it proved is held against the other's.
    """
    if then.final and now.final:
        if now.status != then.status:
            yield f"status is {now.status}, was {then.status}"
        elif not _same(now.cost, then.cost):
            yield f"cost is {now.cost}, was {then.cost}"
        elif now.regrasps != then.regrasps:
            yield f"{now.regrasps} regrasps, were {then.regrasps}"
        return
    if then.final:
        yield f"{now.status}, not proven; was {then.status}, proven"
    yield from _crossed(then, now, "was")
    yield from _crossed(now, then, "is")


def _crossed(one: Outcome, other: Outcome, word: str) -> Iterator[str]:
    """Yield a sentence where ``one``'s bound refutes the other's plan."""
    if other.cost is None:
        return
    if one.status == "infeasible":
        yield f"{word} infeasible, but there is a plan at {other.cost}"
    elif one.bound is not None and one.bound > other.cost * (1.0 + COST):
        yield f"the bound {word} {one.bound}, but there is a plan at {other.cost}"


def _same(a: float | None, b: float | None) -> bool:
    if a is None or b is None:
        return a is b
    return math.isclose(a, b, rel_tol=COST, abs_tol=0.0)


def compare(before: Before, plan: Planned, say: Callable[[str], object]) -> int:
    """Plan every recorded run anew, list the differences, and return how many runs differ."""
    differing = 0
    for key, then in before.runs.items():
        found = list(differences(then, plan(*key)))
        differing += bool(found)
        for sentence in found:
            say(f"{' '.join(map(str, key))}: {sentence}\n")
    say(f"{len(before.runs)} runs of {before.commit}, {differing} differ\n")
    return differing
