"""``gm-ompl tune``."""

from __future__ import annotations

import json
import math
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from gm_ompl import api
from gm_ompl.app.exits import Exit
from gm_ompl.app.output import made_folder, note, say, writable
from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.study.executors import make_executor
from gm_ompl.study.store import Store
from gm_ompl.study.task import Limits
from gm_ompl.study.tuning import OBJECTIVES, Design, Tuned, tune
from gm_ompl.study.tuning_report import gain_lines, tuning_html

EVERY = 3
"""Where no scenario is held out by name, every third is."""


@dataclass(frozen=True)
class TuneRequest:
    """The options of ``gm-ompl tune``."""

    scenarios: tuple[str, ...]
    planner: str
    trials: int
    hold_out: tuple[str, ...]
    objective: str
    seeds: int
    max_iterations: int | None
    time_limit: float | None
    seed: int
    executor: str
    output: Path


def tune_command(request: TuneRequest) -> Exit:
    """Make the trials that are missing, score the winner, write it."""
    design = _design(request)
    output = writable(request.output)
    assert output is not None
    folder = output.with_name(f"{output.stem}-study")
    with closing(make_executor(request.executor)) as executor:
        made_folder(folder)
        with Store(folder / "runs.sqlite") as store:
            tuned = tune(design, store, executor, folder / "journal.log", _watch)
    _write(request, output, folder, tuned)
    return Exit.OK


def _watch(done: int, wanted: int) -> None:
    note(f"trial {done} of {wanted}")


def _write(request: TuneRequest, output: Path, folder: Path, tuned: Tuned) -> None:
    best = tuned.trials[tuned.best]
    part = output.with_name(f".{output.name}.part")
    part.write_text(json.dumps(best.parameters, indent=2) + "\n", encoding="utf-8")
    part.replace(output)
    measures = OBJECTIVES[request.objective]
    for name, first, value in zip(measures, tuned.trials[0].values, best.values, strict=True):
        say(f"training, {name}: {first:.4g} with the defaults, {value:.4g} in trial {tuned.best}")
    for line in gain_lines(tuned):
        say(line)
    if tuned.best == 0:
        say("no trial beat the defaults")
    title = f"{request.planner} tuned for {request.objective}"
    try:
        page = tuning_html(tuned, measures, title)
        (folder / "report.html").write_text(page, encoding="utf-8")
    except MissingExtraError as error:
        note(f"no report.html: {error}")
    note(f"written to {request.output} and {folder.name}/")


def _design(request: TuneRequest) -> Design:
    """Return what is asked for.

    Raises:
        InputError: an option's value is wrong.
    """
    if request.objective not in OBJECTIVES:
        raise InputError(f"--objective {request.objective}: must be one of {', '.join(OBJECTIVES)}")
    for option, limit in (("--time-limit", request.time_limit),
                          ("--max-iterations", request.max_iterations)):  # fmt: skip
        if limit is not None and not (math.isfinite(limit) and limit > 0):
            raise InputError(f"{option} {limit}: must be a positive number")
    names, held = list(request.scenarios), list(request.hold_out)
    if not held:
        held = names[EVERY - 1 :: EVERY]
        names = [name for name in names if name not in held]
    if not held:
        raise InputError(
            f"SCENARIO: {len(names)} given: name {EVERY} or more, every {EVERY}. is held out, or "
            "name others with --hold-out"
        )
    return Design(
        planner=request.planner,
        training=[api.load(name) for name in names],
        held_out=[api.load(name) for name in held],
        seeds=request.seeds,
        limits=Limits(time_s=request.time_limit, max_iterations=request.max_iterations),
        objective=request.objective,
        trials=request.trials,
        seed=request.seed,
    )
