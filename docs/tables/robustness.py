"""``python -m docs.tables.robustness``: what several cases cost and change.

Writes the tables of docs/results/uncertainty.md.
Times are CPU times, nominal and robust by turns in one
process.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import gm_ompl
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import Instant
from gm_ompl.mechanics.columns import wrench_norm
from gm_ompl.mechanics.family import hand_tips, surroundings
from gm_ompl.mechanics.modes import STABLE
from gm_ompl.mechanics.robust import Surroundings, Tips, cases_at, decide_cases
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.uncertainty.ranges import Uncertainty
from gm_ompl.uncertainty.worlds import cases_of

from .pages import growing, write_page

PROBLEMS = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")
RANGES = {
    "uncertainty.environment_friction": "10 %",
    "uncertainty.finger_friction": "10 %",
    "uncertainty.mass": "5 %",
    "uncertainty.centre_of_mass": "5 %",
}
TIMES = 3
INSTANTS = 60
"""Decisions per row of the second table."""

PLANS = ("problem", "ranges", "status", "cost", "regrasps", "force control", "least z",
         "placements", "CPU s")  # fmt: skip
TIMED = ("cases N", "outcome", "decisions", "T(1) in ms", "T(N) in ms", "T(N) / (N T(1))")


def clocked(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the CPU time of ``work`` and what it returns."""
    begin = time.process_time()
    found = work()
    return time.process_time() - begin, found


def plans() -> Iterator[tuple[object, ...]]:
    """Yield a nominal and a robust row per problem."""
    for name in PROBLEMS:
        nominal = gm_ompl.load(name)
        both = (nominal, nominal.with_(RANGES))
        for scenario in both:
            gm_ompl.plan(scenario, planner="astar", time_limit=5.0)  # compiled, warm
        runs = [
            [clocked(lambda s=s: gm_ompl.plan(s, planner="astar")) for s in both]  # type: ignore[misc]
            for _ in range(TIMES)
        ]
        for k, word in enumerate(("nominal", "robust")):
            seconds = float(np.median([run[k][0] for run in runs]))
            share = seconds / float(np.median([run[0][0] for run in runs]))
            yield (name, word, *_told(runs[0][k][1]), f"{seconds:.2f} ({share:.1f})")


def _told(plan: Plan) -> tuple[object, ...]:
    """Return status, cost, regrasps, force control, least z and first placements of a plan."""
    if not plan.has_plan:
        return (plan.status, "-", "-", "-", "-", "-")
    modes = [mode for segment in plan.segments for mode in segment.modes]
    forced = f"{100 * modes.count('force') / len(modes):.0f} %"
    first = plan.steps[0].placements
    where = ", ".join(f"{at.face}:{','.join(map(str, at.cell or at.point))}" for at in first)
    proven = "optimal" if plan.optimal else plan.status
    return (proven, f"{plan.cost:.4f}", plan.regrasps, forced, f"{plan.least_z:.4f}", where)


def instants(problem: Problem) -> Iterator[Instant]:
    """Yield instants in motion at random placements."""
    rng, hand = np.random.default_rng(0), problem.fingers
    low, high = np.array(problem.motion.low), np.array(problem.motion.high)
    everyone = tuple(range(hand.count))
    while True:
        q = tuple(rng.uniform(low, high).tolist())
        moment = problem.motion.moment(q, tuple((high - low).tolist()))
        rows = tuple(rng.integers(len(hand.placements), size=hand.count).tolist())
        yield problem.instant(
            contacts_at(moment, problem.body, problem.environment), everyone, rows
        )


def _families(instant: Instant) -> tuple[tuple[Surroundings, Tips], tuple[Surroundings, Tips]]:
    """Return the first case alone, and all cases."""
    U, ranges = wrench_norm(instant.mass, instant.inertia), instant.uncertainty
    tips = hand_tips(
        instant.points[:, None], instant.normals[:, None], instant.friction, instant.soft,
        instant.cone_edges, U, ranges, f_max=instant.max_normal_force / instant.force_scale,
    )  # fmt: skip
    around = surroundings(instant, ranges, U)
    one = around._replace(envs=around.envs[:1].copy(), loads=around.loads[:1].copy())
    return (one, tips._replace(command=0.0)), (around, tips)


def decisions() -> Iterator[tuple[object, ...]]:
    """Yield how long decisions for N cases take, beside those for one of them."""
    families = {
        8: Uncertainty((0.05,), (0.07, 0.07), 0.0, (0.25, 0.5, 0.0)),
        16: Uncertainty((0.05,), (0.07, 0.07), 0.05, (0.25, 0.5, 0.0)),
        32: Uncertainty((0.05,), (0.07, 0.07), 0.05, (0.25, 0.5, 0.0), command=0.05),
    }
    for problem in (gm_ompl.load(name).problem for name in ("paper/slide", "paper/tumble")):
        for ranges in families.values():
            found: dict[bool, list[tuple[int, float, float]]] = {True: [], False: []}
            for instant in instants(dataclasses.replace(problem, uncertainty=ranges)):
                stable, row = _timed(instant)
                if len(found[stable]) < INSTANTS:
                    found[stable].append(row)
                if all(len(rows) == INSTANTS for rows in found.values()):
                    break
            for stable, rows in found.items():
                N, one, all_ = np.array(rows).mean(axis=0)
                word = f"{problem.name}: {'stable' if stable else 'refused'}"
                share = all_ / (N * one)
                yield (f"{N:.1f}", word, len(rows), f"{1e3 * one:.3f}", f"{1e3 * all_:.3f}",
                       f"{share:.2f}")  # fmt: skip


def _timed(instant: Instant) -> tuple[bool, tuple[int, float, float]]:
    """Return whether some modes have a margin, and N, T(1), T(N) in CPU seconds."""
    n, times = len(instant.points), []
    there = np.zeros(n, dtype=np.int64)
    end = STABLE
    for around, tips in _families(instant):

        def decide(around: Surroundings = around, tips: Tips = tips) -> int:
            for _ in range(5):
                cases = cases_at(around, tips, np.arange(n), there)
                end, *_rest = decide_cases(cases, 0.0, -1, -1, np.zeros(n), np.zeros(6))
            return int(end)

        decide()
        measured = [clocked(decide) for _ in range(3)]
        times.append(float(np.median([seconds for seconds, _ in measured])) / 5.0)
        end = measured[0][1]
    return end == STABLE, (len(cases_of(instant)), *times)  # type: ignore[return-value]


if __name__ == "__main__":
    tables = {"times": growing(TIMED, decisions()), "plans": growing(PLANS, plans())}
    write_page("uncertainty", tables)
