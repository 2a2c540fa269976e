"""``python -m docs.tables.strong_physics [NAME ...]``: which margin foretells what is withstood?

The optimal plans of ``tests.executed`` are played back in MuJoCo with pulses at random times of a
motion, half of them in the directions of Problem (6), of 0.3 times the smaller margin to 3 times
the larger one (evenly in the logarithm), and at the same times of 0.8 z. Counted is what was
withstood of the former below z_strong, between z_strong and z, and above z, and of the latter.
What was played is kept in build/strong_physics.jsonl; a second call does what is missing.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from docs.tables import execution as executed
from docs.tables.pages import write_tables
from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.strongest import strongly_held
from gm_ompl.reference.modes import margin
from gm_ompl.simulation.disturb import instants
from gm_ompl.simulation.engine import STEP
from gm_ompl.simulation.execute import Setup, execute, prepare
from gm_ompl.simulation.pulses import PULSE, Disturber
from gm_ompl.study.report import number, table
from gm_ompl.tolerance.sites import Site, sites
from gm_ompl.tolerance.strong import margins_at
from tests.executed import NAMES, plan_of

KEPT, PAGE = Path("build/strong_physics.jsonl"), Path("docs/results/strong.md")
PULSES = 17  # per plan
LEAST, MOST, SHARE = 0.3, 3.0, 0.8
LENGTH = round(PULSE / STEP)
BELOW, BETWEEN, ABOVE, USUAL = BANDS = ("below z_strong", "between", "above z", "0.8 z")
HEAD = ("plans", "executed", "least z / M g", "least z_strong / M g", *BANDS)
FORETOLD = ("foretold by", "withstood, as foretold", "lost, though foretold otherwise",
            "lost, as foretold", "withstood, though foretold otherwise")  # fmt: skip

Outcomes = Counter[tuple[str, bool]]


class Played(NamedTuple):
    """A plan's least margins over its weight where pulses began, and pulses by band and outcome."""

    z: float
    z_strong: float
    found: Outcomes


def both(site: Site) -> tuple[float, float]:
    """Return z and z_strong at an instant of a plan, the latter by the kernel where it can."""
    if site.instant.soft.any():
        z, strong = margins_at(site)
        return z, strong.z
    f_com = tuple(
        float(f) if mode is ControlMode.FORCE else None
        for f, mode in zip(site.f_com, site.modes, strict=True)
    )
    z = margin(site.instant, site.modes, f_com)
    return z, strongly_held(site.instant, ModeDecision(Outcome.STABLE, z, site.modes, f_com))


def _drawn(rng: np.random.Generator) -> Array:
    """Return a direction: every other time one of the 76 of Problem (6), else any."""
    direction = rng.normal(size=6) if rng.random() < 0.5 else rng.choice(DIRECTIONS)
    unit: Array = direction / np.linalg.norm(direction)
    return unit


def trials(setup: Setup, seed: int) -> Played:
    """Put pulses on a plan; margins are asked for where pulses begin."""
    places = {(site.step, site.segment): site for site in sites(setup.plan, setup.problem)}
    line, rng = setup.timeline, np.random.default_rng(seed)
    at = [(k, (int(line.step[k]), int(line.segment[k])))
          for k in instants(setup, 4 * PULSES, rng).tolist()]  # fmt: skip
    when = [(k, key) for k, key in at if key in places]
    when = when[:: max(1, len(when) // PULSES)][:PULSES]
    margins = {key: both(places[key]) for key in sorted({key for _, key in when})}
    disturber, found = Disturber(setup, [k for k, _ in when]), Outcomes()
    for k, key in when:
        z, strong = margins[key]
        low, high = np.log([LEAST * max(strong, 0.1 * z), MOST * z])
        peak = float(np.exp(rng.uniform(low, high)))
        stated = max(float(line.z[k : k + LENGTH].min()), setup.problem.mechanics.z_min)
        made = disturber.trial(k, _drawn(rng), -1, peak / stated)
        band = BELOW if peak < strong else BETWEEN if peak < z else ABOVE
        found[band, made.withstood] += 1
        found[USUAL, disturber.trial(k, _drawn(rng), -1, SHARE).withstood] += 1
    weight = setup.problem.mass * setup.problem.mechanics.gravity
    least = np.array(list(margins.values())).min(axis=0, initial=np.inf) / weight
    return Played(float(least[0]), float(least[1]), found)


def played(name: str) -> Played:
    """Play one plan; what does not play back undisturbed is not disturbed."""
    setup = prepare(plan_of(name))
    known = executed.records().get((name, "mujoco"))
    holds = execute(setup).holds if known is None else known["holds"]
    if not setup.plan.least_z or not holds:
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
            sum(found[band, held] for band in BANDS[:3] if band not in bands)
            for held in (False, True)
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
