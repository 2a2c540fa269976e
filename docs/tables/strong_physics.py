"""``python -m docs.tables.strong_physics [NAME ...]``: which margin foretells what is withstood?

The optimal plans of ``tests.executed`` are played back in MuJoCo with pulses at random times of a
motion, in random directions, of 0.3 times the smaller margin to 3 times the larger one (evenly in
the logarithm). Counted is what was withstood of the pulses below z_strong, between z_strong and z,
and above z. What was played is kept in build/strong_physics.jsonl; a second call does what is
missing.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from docs.tables.pages import write_tables
from gm_ompl.simulation.disturb import instants
from gm_ompl.simulation.engine import STEP
from gm_ompl.simulation.execute import Setup, execute, prepare
from gm_ompl.simulation.pulses import PULSE, Disturber
from gm_ompl.study.report import number, table
from gm_ompl.tolerance.sites import sites
from gm_ompl.tolerance.strong import margins_at
from tests.executed import NAMES, plan_of

KEPT, PAGE = Path("build/strong_physics.jsonl"), Path("docs/results/strong.md")
PULSES = 17  # per plan
LEAST, MOST = 0.3, 3.0
LENGTH = round(PULSE / STEP)
BELOW, BETWEEN, ABOVE = BANDS = ("below z_strong", "between", "above z")
HEAD = ("plans", "executed", "least z / M g", "least z_strong / M g", *BANDS)
FORETOLD = ("foretold by", "withstood, as foretold", "lost, though foretold otherwise",
            "lost, as foretold", "withstood, though foretold otherwise")  # fmt: skip

Outcomes = Counter[tuple[str, bool]]


class Played(NamedTuple):
    """A plan's least margins over its weight where pulses began, and pulses by band and outcome."""

    z: float
    z_strong: float
    found: Outcomes


def trials(setup: Setup, seed: int) -> Played:
    """Put pulses on a plan; margins are asked for where pulses begin."""
    places = {(site.step, site.segment): site for site in sites(setup.plan, setup.problem)}
    line, rng = setup.timeline, np.random.default_rng(seed)
    at = [(k, (int(line.step[k]), int(line.segment[k])))
          for k in instants(setup, 4 * PULSES, rng).tolist()]  # fmt: skip
    when = [(k, key) for k, key in at if key in places]
    when = when[:: max(1, len(when) // PULSES)][:PULSES]
    margins = {key: margins_at(places[key]) for key in sorted({key for _, key in when})}
    disturber, found = Disturber(setup, [k for k, _ in when]), Outcomes()
    for k, key in when:
        z, strong = margins[key][0], margins[key][1].z
        low, high = np.log([LEAST * max(strong, 0.1 * z), MOST * z])
        peak, direction = float(np.exp(rng.uniform(low, high))), rng.normal(size=6)
        stated = max(float(line.z[k : k + LENGTH].min()), setup.problem.mechanics.z_min)
        made = disturber.trial(k, direction / np.linalg.norm(direction), -1, peak / stated)
        band = BELOW if peak < strong else BETWEEN if peak < z else ABOVE
        found[band, made.withstood] += 1
    weight = setup.problem.mass * setup.problem.mechanics.gravity
    least_z = min((z for z, _ in margins.values()), default=0.0)
    least_strong = min((strong.z for _, strong in margins.values()), default=0.0)
    return Played(least_z / weight, least_strong / weight, found)


def played(name: str) -> Played:
    """Play one plan; what does not play back undisturbed is not disturbed."""
    setup = prepare(plan_of(name))
    if not setup.plan.least_z or not execute(setup).holds:
        return Played(0.0, 0.0, Outcomes())
    return trials(setup, NAMES.index(name))


def records() -> dict[str, Played]:
    """Return what is kept."""
    lines = KEPT.read_text().splitlines() if KEPT.exists() else []
    return {
        row["name"]: Played(row["z"], row["z_strong"],
                            Outcomes({(band, held): n for band, held, n in row["found"]}))
        for row in map(json.loads, lines)
    }  # fmt: skip


def keep(name: str, made: Played) -> None:
    """Write down what was played."""
    rows = [[band, held, n] for (band, held), n in made.found.items()]
    KEPT.parent.mkdir(exist_ok=True)
    with KEPT.open("a") as file:
        row = {"name": name, "z": made.z, "z_strong": made.z_strong, "found": rows}
        file.write(json.dumps(row) + "\n")


def groups(known: dict[str, Played]) -> Iterator[tuple[object, ...]]:
    """Yield a row per group of plans, and one for all."""
    kinds = {name: name.rpartition("/")[0] for name in known}
    for kind in [*sorted(set(kinds.values())), "all"]:
        of = [known[name] for name in known if kind in ("all", kinds[name])]
        held = [one for one in of if one.found]
        found = sum((one.found for one in held), Outcomes())
        least = (number(min(margins, default=None)) for margins in
                 ([one.z for one in held], [one.z_strong for one in held]))  # fmt: skip
        yield (kind, f"{len(held)} of {len(of)}", *least, *(share(found, band) for band in BANDS))


def share(found: Mapping[tuple[str, bool], int], band: str) -> str:
    """Return how many pulses of a band were withstood, of how many."""
    held, lost = found.get((band, True), 0), found.get((band, False), 0)
    return f"{held} of {held + lost}" if held + lost else "-"


def foretold(known: dict[str, Played]) -> Iterator[tuple[object, ...]]:
    """Yield a row per margin: what it foretold of all pulses, and what became of them."""
    found = sum((one.found for one in known.values()), Outcomes())
    for name, bands in (("z", (BELOW, BETWEEN)), ("z_strong", (BELOW,))):
        inside = [sum(found[band, held] for band in bands) for held in (True, False)]
        outside = [
            sum(found[band, held] for band in BANDS if band not in bands) for held in (False, True)
        ]
        yield (name, *inside, *outside)


def main() -> None:
    """Play what is missing, and write the page, plan by plan."""
    parser = argparse.ArgumentParser(prog="docs.tables.strong_physics", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", default=NAMES)
    names, known = parser.parse_args().names, records()
    for name in names:
        if name not in known:
            known[name] = played(name)
            keep(name, known[name])
        told = {"pulses": table(HEAD, list(groups(known))),
                "foretold": table(FORETOLD, list(foretold(known)))}  # fmt: skip
        write_tables(PAGE, told)


if __name__ == "__main__":
    main()
