"""Random turns of random knobs: what the page of ``gm-ompl explore`` would be told."""

from __future__ import annotations

import asyncio
import json
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

import gm_ompl
from gm_ompl.app.exploring_answers import BaseScenario, answer, ground
from gm_ompl.exploring.handles import handles
from gm_ompl.exploring.knobs import Slider, knobs
from gm_ompl.exploring.planners import AUTO, EXACT
from gm_ompl.exploring.race import Allowance, answers
from gm_ompl.planfile.model import Plan
from tests.verify.counting import Result, count

FEW = ("lattice.segments=6", "fingers.placements.grid=[3, 3]")
SCENARIOS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("paper/slide", FEW), ("paper/regrasp", FEW), ("fingers/three", FEW),
    ("shapes/hexagon", FEW), ("paper/push", ()), ("paper/tumble", ()), ("planar/turn", ()),
    ("free/around", ()),
)  # fmt: skip
"""Names, and what is made smaller."""

SECONDS = 4.0  # of each search

ODD = (
    "fingers.radius=1e9", "object.mass=0", "object.mass=1e-300", "friction.finger=-1", "x", "=",
    "fingers.count=0", "fingers.count=7", "fingers.max_normal_force=1e308", "lattice.segments=1",
    "friction.environment=.nan", "motion.start.position=[0, 0, 1e6]", "gravity=0", "a.b.c=1",
    "object.shape.box=[1e-9, 1, 1]", "mechanics.z_min=1e30", "fingers.placements.grid=[1, 1]",
    "environment.obstacles={a: {box: {min: [0, 0, 0], max: [0, 1, 1]}}}", "environment.floor=false",
    "name=<script>alert(1)</script>", "environment.floor={", "fingers.radius=[1]", "format=1",
)  # fmt: skip
"""Other settings, most of them wrong."""


@cache
def _ground(name: str, overrides: tuple[str, ...]) -> BaseScenario:
    return ground(gm_ompl.load(name, overrides), EXACT, SECONDS)


def turned(base: BaseScenario, rng: np.random.Generator) -> list[str]:
    """Return one to four random settings: knobs, drags, now and then something odd."""
    found = []
    offered, grips = knobs(base.scenario), handles(base.scenario, [])
    for _ in range(rng.integers(1, 5)):
        kind = rng.random()
        if kind < 0.65:
            found.append(_turn(offered[rng.integers(len(offered))], rng))
        elif kind < 0.9:
            grip = grips[rng.integers(len(grips))]
            by = sum(
                rng.integers(-8, 9) * step * np.array(axis)
                for step, axis in zip(grip.steps, grip.axes, strict=True)
            )
            for one in grip.moved:
                found.append(f"{one.key}={_shifted(one.value, by, one.axis)}".replace("'", ""))
        else:
            found.append(str(rng.choice(ODD)))
    return found


def _turn(knob: Slider, rng: np.random.Generator) -> str:
    u = float(rng.random())
    if rng.random() < 0.2:
        u = float(rng.integers(2))
    if knob.logarithmic:
        value = knob.low * (knob.high / knob.low) ** u
    else:
        value = knob.low + u * (knob.high - knob.low)
    return f"{knob.key}={value:.3g} {knob.unit}".strip()


def _shifted(value: Any, by: Any, axis: int | None) -> Any:
    if axis is not None:
        return [one + float(by[axis]) for one in value]
    if isinstance(value[0], list):
        return [_shifted(row, by, None) for row in value]
    return [one if one == "rest" else one + float(by[k]) for k, one in enumerate(value)]


def told(base: BaseScenario, settings: list[str], planner: str = AUTO) -> list[dict[str, Any]]:
    """Return what a page is told; one run after the other, in this process."""

    async def run(task: dict[str, Any]) -> dict[str, Any]:
        return answer(base, task)

    async def collected() -> list[dict[str, Any]]:
        lines = answers(run, settings, planner, Allowance(SECONDS, None))
        return [json.loads(json.dumps(line, allow_nan=False)) async for line in lines]

    with ThreadPoolExecutor(1) as thread:  # this one may have a loop of its own
        return thread.submit(asyncio.run, collected()).result()


@count(instances=1000)
def explored(instance: int) -> Result:
    """Random settings of a page of `explore`: it is told a plan, none, or what is wrong in words;
    no exception reaches it, and every plan that it shows holds in `check`.
    """  # noqa: D205 (a claim, one sentence)
    rng = np.random.default_rng([28, instance])
    name, overrides = SCENARIOS[instance % len(SCENARIOS)]
    base = _ground(name, overrides)
    settings = turned(base, rng)
    found = told(base, settings)
    assert found and [line["final"] for line in found] == [False] * (len(found) - 1) + [True]
    last = found[-1]
    if last["kind"] == "refused":
        holds = last["of"] in ("scenario", "planner") and all(last["lines"])
        return Result(holds, note=f"{name} {settings}: {last['lines']}", outcome="refused")
    for line in found:
        if line.get("solved"):
            report = gm_ompl.check(Plan.model_validate_json(line["plan"]))
            if not report.holds:
                return Result(False, note=f"{name} {settings}: {report.table()}")
    return Result(True, outcome=last["status"])
