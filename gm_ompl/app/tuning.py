"""``gm-ompl tune``."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path

import gm_ompl
from gm_ompl.app.exits import Exit
from gm_ompl.app.options import require_positive
from gm_ompl.app.output import made_folder, note, say, writable
from gm_ompl.app.verbs import TuneVerb
from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.study.cluster import make_executor
from gm_ompl.study.report import gain_lines, tuning_html
from gm_ompl.study.store import Store
from gm_ompl.study.task import Limits
from gm_ompl.study.tuning import OBJECTIVES, Design, Tuned, tune
from gm_ompl.writing import write_text

EVERY = 3
"""Where no scenario is held out by name, every third is."""


def tune_command(request: TuneVerb) -> Exit:
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


def _write(request: TuneVerb, output: Path, folder: Path, tuned: Tuned) -> None:
    best = tuned.trials[tuned.best]
    write_text(output, json.dumps(best.parameters, indent=2) + "\n")
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
        write_text(folder / "report.html", page)
    except MissingExtraError as error:
        note(f"no report.html: {error}")
    note(f"written to {request.output} and {folder.name}/")


def _design(request: TuneVerb) -> Design:
    """Return what is asked for.

    Raises:
        InputError: an option's value is wrong.
    """
    if request.objective not in OBJECTIVES:
        raise InputError(f"--objective {request.objective}: must be one of {', '.join(OBJECTIVES)}")
    require_positive(time_limit=request.time_limit, max_iterations=request.max_iterations)
    names, held = list(request.scenarios), list(request.hold_out or ())
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
        training=[gm_ompl.load(name) for name in names],
        held_out=[gm_ompl.load(name) for name in held],
        seeds=request.seeds,
        limits=Limits(time_s=request.time_limit, max_iterations=request.max_iterations),
        objective=request.objective,
        trials=request.trials,
        seed=request.seed,
    )
