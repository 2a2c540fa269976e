"""``python -m docs.tables.strong_physics``: which margin foretells what pulses are withstood?

Optimal plans are played back in MuJoCo with pulses at random times of a motion, in random
directions, of 0.3 times the smaller margin to 3 times the larger one (evenly in the logarithm).
Counted is what was withstood of the pulses below z_strong, between z_strong and z, and above z.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

import gm_ompl
from docs.tables.pages import growing, write_page
from gm_ompl.simulation.disturb import instants
from gm_ompl.simulation.engine import STEP
from gm_ompl.simulation.execute import Setup, execute, prepare
from gm_ompl.simulation.pulses import PULSE, Disturber
from gm_ompl.simulation.timeline import Pace
from gm_ompl.study.report import number
from gm_ompl.tolerance.strong import StrongReport

SCENARIOS = (
    "paper/slide", "paper/push", "paper/tumble", "paper/regrasp", "paper/cork", "planar/turn",
    "planar/corridor", "shapes/hexagon", "shapes/l-bracket", "tasks/placedown",
)  # fmt: skip
PULSES = 200  # per scenario
PACE = Pace(speed=0.3)  # three times the usual, so that more is played
LEAST, MOST = 0.3, 3.0
LENGTH = round(PULSE / STEP)
BELOW, BETWEEN, ABOVE = "below z_strong", "between", "above z"
BANDS = (BELOW, BETWEEN, ABOVE)
HEAD = ("scenario", "least z / M g", "least z_strong / M g", "plays without leaning", *BANDS)


def trials(setup: Setup, report: StrongReport) -> Counter[tuple[str, bool]]:
    """Return the pulses put on a plan, by band and outcome."""
    margins = {(site.step, site.segment): site for site in report.sites}
    line, rng = setup.timeline, np.random.default_rng(0)
    when = [
        k for k in instants(setup, 4 * PULSES, rng).tolist()
        if (int(line.step[k]), int(line.segment[k])) in margins
    ][::4]  # fmt: skip
    disturber, found = Disturber(setup, when), Counter[tuple[str, bool]]()
    for k in when:
        site = margins[int(line.step[k]), int(line.segment[k])]
        low, high = np.log([LEAST * max(site.z_strong, 0.1 * site.z), MOST * site.z])
        peak, direction = float(np.exp(rng.uniform(low, high))), rng.normal(size=6)
        stated = max(float(line.z[k : k + LENGTH].min()), setup.problem.mechanics.z_min)
        made = disturber.trial(k, direction / np.linalg.norm(direction), -1, peak / stated)
        band = BELOW if peak < site.z_strong else BETWEEN if peak < site.z else ABOVE
        found[band, made.withstood] += 1
    return found


def rows() -> Iterator[tuple[object, ...]]:
    """Yield a row per scenario, and one for all."""
    total = Counter[tuple[str, bool]]()
    for name in SCENARIOS:
        plan = gm_ompl.plan(name)
        setup, report = prepare(plan, PACE), gm_ompl.strong(plan)
        weight = setup.problem.mass * setup.problem.mechanics.gravity
        least = min(site.z for site in report.sites), report.least.z_strong
        alone = execute(prepare(plan, PACE, lean=False)).holds
        told = name, *(number(z / weight) for z in least), "yes" if alone else "no"
        if not execute(setup).holds:
            yield *told, "does not play back", "", ""
            continue
        found = trials(setup, report)
        total += found
        yield *told, *(share(found, band) for band in BANDS)
    yield "all", "", "", "", *(share(total, band) for band in BANDS)


def share(found: Counter[tuple[str, bool]], band: str) -> str:
    """Return how many pulses of a band were withstood, of how many."""
    held, lost = found[band, True], found[band, False]
    return f"{held} of {held + lost}" if held + lost else "-"


def main() -> None:
    """Play, and write the page."""
    write_page("strong", {"pulses": growing(HEAD, rows())})


if __name__ == "__main__":
    main()
