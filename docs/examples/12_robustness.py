# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl[sim]"]
# ///
"""Does planning with a larger z_min make executions robust against a wrong model?

    python docs/examples/12_robustness.py [--percent 3] [--trials 20]

Plans two problems of the paper under several z_min and executes each plan in worlds that are off
by a few per cent: in everything, and, for the plans under the scenario's own z_min, in one thing
at a time. The worlds of all plans have the same seeds. Prints a table.
"""

import argparse

from scipy.stats import beta

import gm_ompl
from gm_ompl.simulation.execute import prepare, vary
from gm_ompl.simulation.world import KINDS

CASES = (("paper/cork", (0.05, 0.2, 0.4)), ("paper/regrasp", (0.5, 2.0, 4.0)))
"""Scenarios with the z_min to plan with, the scenario's own first."""


def main() -> None:
    """Do the study."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--percent", type=float, default=3.0, help="greatest error")
    parser.add_argument("--trials", type=int, default=20, help="worlds per plan")
    options = parser.parse_known_args()[0]  # a notebook has arguments of its own
    print("| scenario | z_min | cost | least z / weight | off | hold | 90% interval |")
    print("|---|---|---|---|---|---|---|")
    for name, margins in CASES:
        for z_min in margins:
            plan = gm_ompl.plan(gm_ompl.load(name, [f"mechanics.z_min={z_min}"]))
            setup = prepare(plan)
            weight = setup.problem.mass * setup.problem.mechanics.gravity
            alone = [(kind,) for kind in KINDS] if z_min == margins[0] else []
            for kinds in (KINDS, *alone):
                found = vary(setup, options.percent / 100.0, options.trials, 0, kinds)
                held = sum(run.holds for run in found.runs.values())
                low, high = interval(held, options.trials)
                off = "all" if kinds == KINDS else kinds[0]
                print(
                    f"| {name} | {z_min:g} | {plan.cost:.5g} | {found.z / weight:.2f} | {off} "
                    f"| {held} of {options.trials} | {low:.0%} to {high:.0%} |",
                    flush=True,
                )


def interval(held: int, trials: int) -> tuple[float, float]:
    """Return Jeffreys' 90% interval for the share that holds."""
    lost = trials - held
    low = float(beta.ppf(0.05, held + 0.5, lost + 0.5)) if held else 0.0
    high = float(beta.ppf(0.95, held + 0.5, lost + 0.5)) if lost else 1.0
    return low, high


if __name__ == "__main__":
    main()
