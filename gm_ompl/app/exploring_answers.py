"""What a run answers: the plan under some settings, ready to be shown, or why there is none."""

from __future__ import annotations

import base64
import io
import warnings
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

import gm_ompl
from gm_ompl.app.mapping import lines
from gm_ompl.errors import InputError, LimitError, ScenarioError
from gm_ompl.exploring.handles import handles
from gm_ompl.forks import Json
from gm_ompl.geometry.pose import Pose
from gm_ompl.planfile import files
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.planner import Status
from gm_ompl.scenario.document import dump
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.viz.animation import animate
from gm_ompl.viz.canvas import save_to, styled
from gm_ompl.viz.page import shown
from gm_ompl.viz.placements import placements_figure
from gm_ompl.viz.region import View, neighbourhood

SEED: Final = 0  # the same settings give the same plan, as far as a time limit lets them


@dataclass(frozen=True, eq=False)
class BaseScenario:
    """What every run starts from."""

    scenario: Scenario  # as the file has it
    view: View  # what is seen of it; a run shows at least as much, so that nothing jumps


def ground(scenario: Scenario, planner: str, seconds: float) -> BaseScenario:
    """Return the ground that runs on ``scenario`` start from: what a first search sees is seen."""
    with warnings.catch_warnings(record=True):
        first = gm_ompl.plan(scenario, planner, time_limit=seconds, seed=SEED)
    return BaseScenario(scenario, neighbourhood(animate(first)))


def answer(base: BaseScenario, task: Json) -> Json:
    """Return what a page shows of the plan under a task's settings.

    Args:
        base: the scenario.
        task: ``settings``, as ``--set`` takes them; ``planner``; ``time_s`` and ``memory_mb``.

    Returns:
        ``kind`` is "plan" with all that the page needs to show the result of the search, a plan or
        none; or "refused" with ``lines`` of text, where ``of`` says whether the scenario is wrong
        or the planner cannot treat it.
    """
    try:
        scenario = base.scenario.with_(task["settings"])
    except ScenarioError as error:
        return {"kind": "refused", "of": "scenario", "lines": list(error.problems)}
    try:
        with warnings.catch_warnings(record=True):  # they are told below
            plan = gm_ompl.plan(
                scenario, task["planner"], time_limit=task["time_s"],
                memory_limit=task["memory_mb"], seed=SEED,
            )  # fmt: skip
    except InputError as error:
        return {"kind": "refused", "of": "planner", "lines": str(error).splitlines()}
    except LimitError as error:
        return {"kind": "refused", "of": "planner", "lines": [f"the budget was spent: {error}"]}
    return {"kind": "plan", **_shown(base, scenario, plan, bool(task["settings"]))}


def _shown(base: BaseScenario, scenario: Scenario, plan: Plan, changed: bool) -> Json:
    seen = shown(animate(plan), base.view)
    tree: dict[str, Any] = {**plan.scenario}
    if changed:
        tree.pop("expect", None)  # it was true of the file
    return {
        "status": plan.status,
        "sentence": Status(plan.status).sentence,
        "solved": plan.cost is not None,
        "optimal": plan.optimal,
        "planner": plan.planner,
        "pieces": seen.pieces(),
        "score": seen.score,
        "messages": seen.messages,
        "camera": seen.camera,
        "handles": [asdict(handle) for handle in handles(scenario, seen.parts)],
        "warnings": [str(warning) for warning in scenario.warnings],
        "plan": files.dumps(plan.to_dict()),
        "scenario": dump(tree),
    }


def mapped(base: BaseScenario, task: Json) -> Json:
    """Return where fingers may be at an instant: an image and lines of text, ``kind`` is "map".

    Or "refused", as for ``answer``; without matplotlib there is no image.
    """
    instant, image = task["instant"], ""
    at: dict[str, Any] = instant
    try:
        if instant.get("pose") is not None:
            row = np.array(instant["pose"], dtype=np.float64)
            at = {"pose": Pose.from_quaternion(row[:3], row[3:])}
        scenario = base.scenario.with_(task["settings"])
        limits = {"time_limit": task["time_s"], "memory_limit": task["memory_mb"]}
        with warnings.catch_warnings(record=True):
            found = gm_ompl.placement_map(scenario, **at, **limits)
    except (InputError, LimitError) as error:
        return {"kind": "refused", "of": "map", "lines": str(error).splitlines()}
    told = [line for group in found.kinds() for line in lines(found, group[0])]
    try:
        with styled(), io.BytesIO() as content:
            save_to(content, placements_figure(found), "png")
            image = base64.b64encode(content.getvalue()).decode("ascii")
    except InputError as error:  # matplotlib is missing
        told.append(str(error))
    return {"kind": "map", "lines": told, "image": image}
